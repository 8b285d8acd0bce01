"""Averaged mass: frequencies against exact ones, what lasts, and what it is refused with."""

import numpy as np
import pytest
from scenes import BAR, SOFT, box, energy, scene, start
from tiers import wide

from pgimp.case.schema import Case
from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.surfaces.table import bits_of
from pgimp.solver.lagrangian import averaged_mass, mass_rows

pytestmark = pytest.mark.slow(60)

#: Stiff enough that strains stay tiny; the speed of waves is 10.
SOLID = {"model": "hooke", "young": 100.0, "poisson": 0.0, "density": 1.0}
C = 10.0


def initial(low, high, **parts):
    return box(low, high) | {"formulation": "total-lagrangian"} | parts


def solid(D, body, cells, mass, courant=0.3, **parts):
    """A case of the solid, with steps of a Courant number."""
    law = BAR if D == 1 else SOLID
    case = scene(D, body, cells=cells, step=courant / C, end=3000 * courant / C,
                 materials={"soft": law}, **parts)  # fmt: skip
    case["method"]["mass"] = mass
    return case


def vertices(sim):
    """Records of the vertices' motion by plane, field, y, z, and their coordinates; cells of 1."""
    grid, frame = sim.rank.grid, sim.scene.domain.frame
    values = grid.by_vertex(grid.kept.values)
    x = [np.arange(n) + low - frame.ghost for n, low in zip(
        (len(values), *values.shape[2:4]), grid.window.lower, strict=True)]  # fmt: skip
    X = np.meshgrid(*x, indexing="ij")
    origin = (*frame.origin, 0.0, 0.0)
    return values, [each[:, None] + begin for each, begin in zip(X, origin, strict=False)]


def frequency(case, shape, exact, axis=0, periods=6.0):
    """Frequency of a mode that begins with velocities of the given shape, less 1 over the exact."""
    sim = start(case)
    values, x = vertices(sim)
    mode = shape(*x) * (values[..., KEPT_MASS] > 0.0)
    values[..., KEPT_VELOCITY + axis] = 1e-4 * mode
    weight, seen, dt = values[..., KEPT_MASS] * mode, [], sim.case.time.step
    for _ in range(round(periods * 2.0 * np.pi / exact / dt)):
        seen.append((weight * vertices(sim)[0][..., KEPT_VELOCITY + axis]).sum())
        sim.advance()
    t, seen = np.arange(len(seen)) * dt, np.array(seen)

    def left(w):
        both = np.stack([np.cos(w * t), np.sin(w * t)], axis=1)
        return np.linalg.lstsq(both, seen, rcond=None)[1][0]

    w = exact * np.linspace(0.96, 1.02, 241)
    residuals = [left(each) for each in w]
    best = min(max(int(np.argmin(residuals)), 1), len(w) - 2)
    a, b, _ = np.polyfit(w[best - 1 : best + 2], residuals[best - 1 : best + 2], 2)
    return -b / (2.0 * a) / exact - 1.0


@pytest.mark.parametrize("mode", [4, 8, wide(1), wide(2)])
def test_a_free_bar(mode):
    """Ends cut off the grid's lines: 40 cells, each frequency to 0.03 %.

    Of five cells in half a wave the next power of the wave number leaves more.
    """
    body = initial([3.37], [43.37])
    exact = mode * np.pi * C / 40.0

    def shape(x, y, z):
        return np.cos(mode * np.pi * (x - 3.37) / 40.0)

    found = {m: frequency(solid(1, body, [48], m), shape, exact) for m in ("lumped", "averaged")}
    assert abs(found["averaged"]) < (5e-4 if mode == 8 else 3e-4)
    assert found["lumped"] == pytest.approx(-1.58e-2 * (mode / 8) ** 2, rel=0.03)


def both(case, shape, exact, axis=0, **parts):
    """Errors of a frequency with lumped and with averaged mass."""
    return [frequency(case(mass), shape, exact, axis, **parts) for mass in ("lumped", "averaged")]


@pytest.mark.parametrize("way", ["fixed", "mirror", "constraint"])
def test_a_held_end(way):
    """A bar that a face holds, or a mirror at the wall, or a constraint: a third of the error."""
    exact = 3.5 * np.pi * C / 30.4
    parts = {"boundaries": {"x-min": "slip" if way == "mirror" else "fixed"}}
    if way == "constraint":
        grip = {"body": "body", "region": {"box": {"min": [-1.0], "max": [0.01]}}}
        parts = {"constraints": {"grip": grip | {"velocity": [0.0]}}}
    shapes = {"shape": "fuzzy-nearest", "wall": "mirror"} if way == "mirror" else {}
    low = -0.5 if way == "constraint" else 0.0
    if way == "constraint":
        parts["grid"] = {"origin": [-2.0], "size": [38.0], "cell": [1.0]}

    def case(mass):
        return solid(1, initial([low], [30.4]), [36], mass, **parts, **shapes)

    def shape(x, y, z):
        return np.sin(3.5 * np.pi * x / 30.4)

    lumped, averaged = both(case, shape, exact)
    assert abs(averaged) < abs(lumped) / 3.0


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("kind", ["P", "S"])
def test_waves_through_a_seam(axis, kind):
    """A standing wave of ten cells in a periodic domain, across x and across y."""
    size = [3.0, 3.0]
    size[axis] = 10.0
    faces = dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic")

    def case(mass):
        return solid(2, initial([0.0, 0.0], size), [int(n) for n in size], mass, boundaries=faces)

    def shape(x, y, z):
        return np.sin(2.0 * np.pi * (x, y)[axis] / 10.0 + 0.4)

    speed = C if kind == "P" else C * np.sqrt(0.5)
    along = axis if kind == "P" else 1 - axis
    lumped, averaged = both(case, shape, 2.0 * np.pi * speed / 10.0, along)
    assert abs(averaged) < abs(lumped) / 3.0


def bessel(r):
    """Bessel's function J_1."""
    t = (np.arange(400) + 0.5) * np.pi / 400
    return np.cos(t - r[..., None] * np.sin(t)).mean(axis=-1)


def test_a_cylinder_breathes():
    """Radial modes of a solid cylinder without Poisson's ratio: J_1'(w a/c) = 0."""
    a, root = 16.3, 5.331442773525032

    def case(mass):
        faces = {"x-min": "slip", "y-min": "slip", "y-max": "slip"}
        return solid(2, initial([0.0, 0.0], [a, 3.0]), [20, 3], mass, boundaries=faces,
                     geometry="axisymmetric")  # fmt: skip

    def shape(x, y, z):
        return bessel(root * x / a)

    lumped, averaged = both(case, shape, root * C / a, periods=4.0)
    assert abs(averaged) < abs(lumped) / 3.0


@pytest.mark.parametrize(
    ("courant", "steps", "surface"),
    [wide(0.3, 16_000, "cut-particles"), (0.6, 4_000, "cut-particles"), (0.55, 4_000, "exact")],
)
def test_a_turning_block_bends(courant, steps, surface):
    """Energy and spin by the averaged mass last; momentum to rounding."""
    soft = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
    speed = np.sqrt(100.0 * 0.7 / (1.3 * 0.4))
    spin = {"rotation": {"about": [11.37, 7.21], "rate": 0.02 * speed}}
    body = initial([3.37, 3.21], [19.37, 11.21], velocity=spin, surface=surface)
    case = scene(2, body, cells=[24, 16], end=1e9, step={"courant": courant},
                 materials={"soft": soft})  # fmt: skip
    case["method"]["mass"] = "averaged"
    sim = start(case)
    values, (x, _, _) = vertices(sim)
    there, wave = values[..., KEPT_MASS] > 0.0, np.pi * (x - 11.37) / 16.0
    for d, v in enumerate((np.sin(wave), -0.5 * np.cos(wave))):
        add = 0.05 * speed * v * there
        add -= there * (add * values[..., KEPT_MASS]).sum() / values[..., KEPT_MASS].sum()
        values[..., KEPT_VELOCITY + d] += add
    rank = sim.rank
    if rank.slaves:
        rank.slaves.spread(rank, rank.grid.kept.values, KEPT_VELOCITY)
    rank.population.outdate(True)
    unit, found, before = sim.diagnostics()["mass"] * 0.05 * speed, [], {}
    for n in range(steps + 1):
        line = sim.diagnostics() if n % 100 < 2 else {}
        sim.advance()
        if n % 100 == 1:  # velocities are half a step behind
            kinetic = 0.5 * (before["kinetic-energy"] + line["kinetic-energy"])
            found.append([
                kinetic + before["strain-energy"], line["angular-momentum-z"],
                line["momentum-x"] / unit,
            ])  # fmt: skip
        before = line
    found = np.array(found[1:])  # first, cut particles have not seen the wave yet
    off = np.abs(found - found[0]).max(axis=0) / [*found[0, :2], 1.0]
    assert (off < [1e-3, 1.5e-4, 1e-12]).all(), off


@pytest.mark.parametrize(("cells", "least"), [(20, 0.967), wide(40, 0.9825), wide(80, 0.9905)])
def test_bars_part(cells, least):
    """Two equal bars: what dispersion takes of their rebound becomes less (0.957, 0.973, 0.984)."""
    bodies = {
        name: initial([low], [low + cells], velocity=[v])
        for name, low, v in (("left", 3.3, 0.1), ("right", 3.8 + cells, -0.1))
    }
    case = solid(1, bodies, [2 * cells + 8], "averaged", contact=[{"bodies": "all"}])
    sim = start(case)
    first = sim.diagnostics()
    while sim.time < 2.5 + 2.5 * cells / C:
        sim.advance()
    line, m = sim.diagnostics(), float(cells)
    parted = (line["body.right.momentum-x"] - line["body.left.momentum-x"]) / (0.2 * m)
    assert least < parted < 1.0
    assert line["kinetic-energy"] + line["strain-energy"] < first["kinetic-energy"]


def test_a_bar_stands_on_another():
    """What has come to rest with lumped mass stays: forces of contact are among those averaged."""
    bodies = {"low": initial([0.0], [10.37]), "top": initial([10.37], [18.9])}
    case = solid(1, bodies, [24], "averaged", gravity=[-0.1], boundaries={"x-min": "fixed"},
                 contact=[{"bodies": "all"}],
                 start={"equilibrate": {"tolerance": 1e-8}})  # fmt: skip
    sim = start(case)
    while sim.scene.domain.settling:
        sim.advance()
    first = sim.diagnostics()
    for _ in range(1000):
        sim.advance()
    line, weight = sim.diagnostics(), 0.1 * np.array([8.53, 18.9])
    strained = (8.53 * weight[0] ** 2 + (weight[1] ** 3 - weight[0] ** 3) / 0.1) / 6.0 / 100.0
    assert line["strain-energy"] == pytest.approx(strained, rel=0.03)
    assert line["strain-energy"] == pytest.approx(first["strain-energy"], rel=1e-6)
    assert line["kinetic-energy"] < 1e-8 * strained


def two_blocks(D, mass, shift=0.0):
    """Blocks that do not meet, whose vertices have velocities of their own."""
    size, laws = [4.0, 3.0, 3.0][:D], [{"bodies": "all"}]
    bodies = {
        name: initial([x + shift] * D, [x + shift + s for s in size])
        for name, x in (("low", 2.0), ("high", 8.0))
    }
    sim = start(solid(D, bodies, [14, 13, 13][:D], mass, contact=laws))
    values, rng = vertices(sim)[0], np.random.default_rng(5)
    v = 1e-3 * rng.normal(size=(*values.shape[:-1], D))
    values[..., KEPT_VELOCITY : KEPT_VELOCITY + D] = v * (values[..., KEPT_MASS, None] > 0.0)
    if sim.rank.slaves:
        sim.rank.slaves.spread(sim.rank, sim.rank.grid.kept.values, KEPT_VELOCITY)
    sim.advance()  # by which they are displaced
    return sim


@pytest.mark.parametrize("shift", [0.0, 0.97])
@pytest.mark.parametrize("D", [2, wide(3)])
def test_what_contact_moves_has_lumped_mass(D, shift):
    """Vertices as with lumped mass, those farther away as ever; momentum is the same."""
    at = [4] * D
    found = []
    for mass, marked in (("lumped", False), ("averaged", False), ("averaged", True)):
        sim = two_blocks(D, mass, shift)
        frame, part = sim.scene.domain.frame, sim.rank.averaged_mass
        if marked:
            number = [*(frame.ghost + np.array(at)), 0, 0][:3]
            key = int(number[0])
            fields = 1 + max(sim.rank.grid.fields, default=0)
            for n, bits in zip((*number[1:], 0), bits_of(frame, fields), strict=True):
                key = (key << bits) + int(n)
            part.restore(np.array([key]))
        sim.advance()
        found.append(vertices(sim)[0].copy())
    x = vertices(sim)[1]
    away = np.max([np.abs(x[d] - at[d]) for d in range(D)], axis=0)[..., None]
    lumped, whole, left = (each[..., KEPT_VELOCITY : KEPT_VELOCITY + D] for each in found)
    own, m = np.broadcast_to(away == 0.0, left.shape), found[0][..., KEPT_MASS]
    assert np.abs(whole - lumped)[own].max() > 1e-6
    np.testing.assert_allclose(left[own], lumped[own], rtol=1e-13)
    far = np.broadcast_to(away > 3.0, left.shape)
    np.testing.assert_array_equal(left[far], whole[far])
    assert np.abs(left - whole)[~far].max() > 1e-6
    for d in range(D):
        assert (m * left[..., d]).sum() == pytest.approx((m * lumped[..., d]).sum(), rel=1e-12)


def test_a_pile_rests_in_long_steps():
    """It neither shakes itself up, nor does what sticks creep, by compliance across normals."""

    bodies = {
        f"b{n}": initial([2.37 + 0.6 * n, 5.0 * n], [10.37 - 0.4 * n, 5.0 * n + 5.0])
        for n in range(3)
    }
    case = solid(2, bodies, [13, 17], "averaged", gravity=[0.0, -0.02],
                 boundaries={"y-min": "fixed"}, contact=[{"bodies": "all", "friction": 0.3}],
                 start={"equilibrate": {"tolerance": 1e-6}})  # fmt: skip
    case["materials"]["soft"] = SOFT
    case["time"]["step"] = {"courant": "auto"}
    sim = start(case)
    while sim.scene.domain.settling:
        sim.advance()
    first = sim.diagnostics()
    for _ in range(1000):
        sim.advance()
    line = sim.diagnostics()
    assert line["strain-energy"] == pytest.approx(first["strain-energy"], rel=5e-6)
    assert line["kinetic-energy"] < 1e-8 * first["strain-energy"]
    assert abs(line["contact.all.friction-heat"]) < 1e-6 * first["strain-energy"]


def test_rest_takes_the_energy_of_this_mass():
    """Kinetic damping takes what there was."""
    body = initial([3.37], [23.37])
    case = solid(1, body, [28], "averaged", courant=0.05, damping={"kinetic": True})
    sim = start(case)
    values, (x, _, _) = vertices(sim)
    wave = np.cos(4.0 * np.pi * (x - 3.37) / 20.0)
    values[..., KEPT_VELOCITY] = 1e-2 * wave * (values[..., KEPT_MASS] > 0.0)
    sim.advance()
    kinetic = [sim.diagnostics()["kinetic-energy"]]
    while not sim.diagnostics()["damped-energy"] > 0.0:
        sim.advance()
        kinetic.append(sim.diagnostics()["kinetic-energy"])
    line = sim.diagnostics()
    assert line["kinetic-energy"] < 0.1 * kinetic[0]
    assert line["damped-energy"] == pytest.approx(kinetic[-2], rel=1e-5)


def test_refused_where_it_means_nothing():
    case = solid(1, box([3.0], [13.0]), [20], "averaged")
    with pytest.raises(ValueError, match=r"method.mass\s.*'body' is in the current one"):
        Case.model_validate(case)
    case["bodies"]["body"] |= {"formulation": "total-lagrangian"}
    case["method"] = {"shape": "mpm", "particles-per-cell": [2], "mass": "averaged"}
    with pytest.raises(ValueError, match=r"method.mass\s.*hardly any mass"):
        Case.model_validate(case)


def test_a_body_beside_others():
    """A bar beside one with lumped mass, and another that says so itself: each has its own."""
    bodies = {"slow": initial([3.37], [23.37]), "fast": initial([26.37], [46.37], mass="averaged")}
    sim = start(solid(1, bodies, [50], "lumped"))
    values, (x, _, _) = vertices(sim)
    for low in (3.37, 26.37):
        inside = (x > low - 1.0) & (x < low + 21.0) & (values[..., KEPT_MASS] > 0.0)
        wave = 1e-4 * np.cos(4.0 * np.pi * (x - low) / 20.0)
        values[..., KEPT_VELOCITY] = np.where(inside, wave, values[..., KEPT_VELOCITY])
    alone = {}
    for name, mass in (("slow", "lumped"), ("fast", "averaged")):
        one = start(solid(1, bodies[name] | {"mass": mass}, [50], "lumped"))
        own, (y, _, _) = vertices(one)
        low = bodies[name]["region"]["box"]["min"][0]
        own[..., KEPT_VELOCITY] = (
            1e-4 * np.cos(4.0 * np.pi * (y - low) / 20.0) * (own[..., KEPT_MASS] > 0.0)
        )
        alone[name] = one
    for _ in range(300):
        for each in (sim, *alone.values()):
            each.advance()
    every = sim.diagnostics()
    for name, one in alone.items():
        mine = one.diagnostics()["strain-energy"]
        assert every[f"body.{name}.strain-energy"] == pytest.approx(mine, rel=1e-9)
    assert every["body.fast.strain-energy"] != pytest.approx(every["body.slow.strain-energy"])


def held_block(D):
    """A lattice on a slip wall, with a corner that is moved."""
    size, low = [7.0, 6.0, 5.0][:D], [0.0, 1.0, 1.0][:D]
    body = initial(low, [a + b for a, b in zip(low, size, strict=True)])
    body["velocity"] = [0.3, -0.2, 0.1][:D]
    part = {"box": {"min": low, "max": [2.0] * D}}
    held = {"body": "body", "region": part, "velocity": [0.2] + [None] * (D - 1)}
    case = scene(D, body, cells=[10, 9, 8][:D], step=0.01, end=0.2, boundaries={"x-min": "slip"},
                 constraints={"grip": held}, gravity=[0.5] + [0.0] * (D - 1))  # fmt: skip
    case["method"]["mass"] = "averaged"
    return case


def after_steps(case):
    """A simulation after 20 steps."""
    sim = start(case)
    sim.diagnostics()
    for _ in range(20):
        sim.advance()
    return sim


@pytest.mark.parametrize("D", [2, 3])
def test_whole_cells_are_as_their_particles(D, monkeypatch):
    """Vertices amid whole cells, and the same with rows of all particles: equal to rounding."""
    found = []
    for whole in (True, False):
        if not whole:
            monkeypatch.setattr(mass_rows, "_whole_cells", no_whole_cells)
        sim = after_steps(held_block(D))
        assert bool(len(sim.rank.averaged_mass._rows.run)) == whole
        found.append(vertices(sim)[0].copy())
    np.testing.assert_allclose(*found, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("D", [2, 3])
def test_planes_one_after_the_other(D, monkeypatch):
    """Forces averaged just before the momentum update of each plane, and all first: same bits."""
    sims = [after_steps(held_block(D))]
    monkeypatch.setattr(averaged_mass, "_CACHED", 1)
    sims.append(after_steps(held_block(D)))
    monkeypatch.setattr(NoContact, "by_planes", False)
    sims.append(after_steps(held_block(D)))
    values, lines = zip(*((vertices(sim)[0], sim.diagnostics()) for sim in sims), strict=True)
    for other, line in zip(values[1:], lines[1:], strict=True):
        assert other.tobytes() == values[0].tobytes()
        assert line == lines[0]
    assert abs(lines[0]["reaction.x-min-x"]) > 0.0


def no_whole_cells(rank, rows, layer, mass):
    """As if no cell of the lattice were whole."""
    shape = rank.slab.layers, *mass_rows._plane(rank)
    return np.zeros(shape), np.zeros(len(rows), np.int64)


def test_a_face_absorbs():
    """Dashpots at both ends: of a pulse of twelve cells hardly anything comes back."""
    faces = {"x-min": "absorbing", "x-max": "absorbing"}
    sim = start(solid(1, initial([0.0], [60.0]), [60], "averaged", boundaries=faces))
    values, (x, _, _) = vertices(sim)
    s = np.clip((x - 30.0) / 12.0, -0.5, 0.5)
    values[..., KEPT_VELOCITY] = 1e-3 * np.cos(np.pi * s) ** 2 * (values[..., KEPT_MASS] > 0.0)
    sim.advance()
    first = energy(sim.diagnostics())
    while sim.time < 10.0:
        sim.advance()
    assert energy(sim.diagnostics()) < 1e-5 * first


def test_a_force_at_a_grip_gives_momentum():
    """To rounding: what the grip's vertices move as is found before and after the averaging."""
    part = {"box": {"min": [3.0], "max": [6.0]}}
    grip = {"body": "body", "region": part, "velocity": [None], "force": [2.0]}
    case = solid(1, initial([3.37], [33.37]), [40], "averaged", constraints={"grip": grip})
    sim = start(case)
    for _ in range(200):
        sim.advance()
    line = sim.diagnostics()
    assert line["momentum-x"] == pytest.approx(2.0 * sim.time, rel=1e-12)
    assert line["kinetic-energy"] + line["strain-energy"] < line["external-work"] * 1.02


def test_a_grip_flies_on_with_its_body():
    """Without a force nothing strains; the forecast of the grip's motion takes its velocity."""
    part = {"box": {"min": [3.0], "max": [6.0]}}
    grip = {"body": "body", "region": part, "velocity": [None], "force": [0.0]}
    body = initial([3.37], [33.37], velocity=[0.5])
    sim = start(solid(1, body, [40], "averaged", constraints={"grip": grip}))
    for _ in range(100):
        sim.advance()
    line = sim.diagnostics()
    assert line["kinetic-energy"] == pytest.approx(0.5 * 30.0 * 0.5**2, rel=1e-12)
    assert line["strain-energy"] < 1e-20
