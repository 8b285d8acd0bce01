"""Bodies exact to their surface: forces, masses and stresses against integrals over true bodies."""

from itertools import product

import numpy as np
import pytest
from meshes import ball as octahedron
from meshes import stl
from scenes import finish, scene, start

from pgimp.errors import CaseError
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import FORCE, RECORD
from pgimp.solver.lagrangian.masters import Vertices

pytestmark = pytest.mark.slow(60)

SIZE = 4.0
PUSH = 0.05


def exact(region, **more):
    """A body in the initial configuration, exact to its surface."""
    body = {"material": "soft", "region": region, "formulation": "total-lagrangian"}
    return body | more


def block(low, **parts):
    """A square of four cells, cut anywhere."""
    low = np.array(low)
    region = {"box": {"min": low.tolist(), "max": (low + SIZE).tolist()}}
    more = {"velocity": parts.pop("velocity")} if "velocity" in parts else {}
    return scene(2, exact(region, **more), cells=[9, 9], **parts)


def corners(sim):
    """Weights and gradients of a simulation's particles, by NumPy: (n, 2^D), (n, 2^D, D)."""
    p, rows = sim.particles, sim.live()
    D, h = sim.scene.dimension, np.array(sim.scene.domain.frame.cell)
    x, c = p.origin[rows] / h, p.products[rows]
    first = np.floor(x)
    t = x - first
    N, dN, cells = [], [], []
    for corner in product((0, 1), repeat=D):
        sign = np.array([1.0 if k else -1.0 for k in corner])
        n = np.where(np.array(corner) == 1, t, 1.0 - t)
        if D == 2:
            N.append(n[:, 0] * n[:, 1] + sign.prod() * c[:, 0] / h.prod())
            dN.append(np.stack([sign[0] * n[:, 1], sign[1] * n[:, 0]], axis=1) / h)
        else:
            yz, xz, xy = (c[:, k] / np.delete(h, k).prod() for k in range(3))
            a, b, g = n.T
            s, u, v = sign
            N.append(a * b * g + a * u * v * yz + b * s * v * xz + g * s * u * xy
                     + s * u * v * c[:, 3] / h.prod())  # fmt: skip
            parts = s * (b * g + u * v * yz), u * (a * g + s * v * xz), v * (a * b + s * u * xy)
            dN.append(np.stack(parts, axis=1) / h)
        cells.append(first + corner)
    return (np.stack(each, axis=1) for each in (N, dN, np.array(cells, int)))


def at_vertices(shape, cells, values):
    """Sums of particles' values at vertices."""
    found = np.zeros((*shape, *values.shape[2:]))
    np.add.at(found, tuple(np.moveaxis(cells, -1, 0)), values)
    return found


def tents(x, shape):
    """Weights of all vertices at points, (n, *shape)."""
    each = [np.maximum(1.0 - np.abs(x[:, d, None] - np.arange(n)), 0.0)
            for d, n in enumerate(shape)]  # fmt: skip
    letters = "xyz"[: len(shape)]
    return np.einsum(",".join("n" + c for c in letters) + "->n" + letters, *each)


@pytest.mark.parametrize("D", [2, 3])
def test_forces_and_masses_are_integrals_over_the_ball(D):
    centre, R = np.array([3.13, 2.91, 3.27])[:D], 2.2
    ball = {"ball": {"centre": centre.tolist(), "radius": R}}
    sim = start(scene(D, exact(ball), cells=[6] * D))
    p, rows, shape = sim.particles, sim.live(), (7,) * D
    N, dN, cells = corners(sim)
    force = at_vertices(shape, cells, p.V0[rows][:, None, None] * dN)
    if D == 2:
        angle = (np.arange(20000) + 0.5) * 2.0 * np.pi / 20000
        n = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        weight = np.full(len(n), 2.0 * np.pi * R / len(n))
    else:
        z, w = np.polynomial.legendre.leggauss(120)
        angle = (np.arange(240) + 0.5) * 2.0 * np.pi / 240
        n = np.stack(
            [np.outer(np.sqrt(1 - z * z), np.cos(angle)), np.outer(np.sqrt(1 - z * z),
             np.sin(angle)), np.outer(z, np.ones(240))], axis=-1).reshape(-1, 3)  # fmt: skip
        weight = np.repeat(w, 240) * 2.0 * np.pi / 240 * R**2
    truth = np.einsum("n...,nd->...d", tents(centre + R * n, shape) * _column(weight, D), n)
    assert np.abs(force - truth).max() < 4e-3 * np.abs(truth).max()
    assert np.sqrt(((force - truth) ** 2).sum() / (truth**2).sum()) < 1.5e-3

    # Masses: of what vertices hold, and of these with what slaves give to their masters.
    mass = at_vertices(shape, cells, p.m[rows][:, None] * N)
    if D == 2:
        points = (np.arange(6 * 240) + 0.5) / 240
        x = np.stack(np.meshgrid(points, points, indexing="ij"), axis=-1).reshape(-1, 2)
        x = x[((x - centre) ** 2).sum(axis=1) < R * R]
        parts = np.array_split(x, 20)
        truth = np.sum([tents(part, shape).sum(axis=0) for part in parts], axis=0)
        np.testing.assert_allclose(mass, truth / 240**2, atol=1e-3)
    slaves, ghost = sim.rank.slaves, sim.scene.domain.frame.ghost
    place = [number - ghost for number in Vertices.numbers(sim.rank, slaves.keys)[:D]]
    to = [number - ghost for number in Vertices.numbers(sim.rank, slaves.masters)[:D]]
    few = (mass > 0.0) & (mass < 0.05)
    assert few[tuple(place)].all()
    assert len(slaves.free) + len(place[0]) == few.sum()
    x = np.stack(place, axis=1)
    masters = np.stack(to, axis=1)[slaves.of]
    np.testing.assert_allclose(slaves.weights.sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose((slaves.weights[..., None] * masters).sum(axis=1), x, atol=1e-13)
    assert np.abs(masters - x[:, None]).max() <= 2
    for s in range(len(x)):
        for k, weight in zip(masters[s], slaves.weights[s], strict=True):
            mass[tuple(k)] += weight * mass[tuple(x[s])]
        mass[tuple(x[s])] = 0.0
    kept = sim.rank.grid.kept.values.reshape(-1, RECORD)[:, KEPT_MASS]
    np.testing.assert_allclose(np.sort(kept[kept > 0.0]), np.sort(mass[mass > 0.0]), rtol=1e-10)
    assert len(slaves.free) or kept[kept > 0.0].min() > 0.025


def _column(values, D):
    return values.reshape(-1, *[1] * D)


@pytest.mark.parametrize("low", [(1.37, 1.21), (2.0, 1.97), (1.98, 2.4)])
def test_uniform_stress_under_a_traction(low):
    """By face and by region a cut block has the stress of its traction, everywhere."""
    top = {"box": {"min": [0.0, 3.0], "max": [9.0, 9.0]}}
    tractions = {
        "top": {"body": "body", "region": top, "traction": [0.0, PUSH],
                "normal": {"of": [0.0, 1.0]}},
        "bottom": {"body": "body", "face": "y-min", "traction": [0.0, -PUSH]},
    }  # fmt: skip
    sim = start(block(low, end=3.0, step=0.02, tractions=tractions, damping={"mass": 8.0}))
    sim.diagnostics()
    finish(sim)
    stress = sim.particles.sigma[sim.live()]
    np.testing.assert_allclose(stress[:, 1], PUSH, rtol=2e-3)
    np.testing.assert_allclose(stress[:, [0, 3]], 0.0, atol=2e-3 * PUSH)
    last = sim.diagnostics()
    np.testing.assert_allclose(last["traction.top-y"], PUSH * SIZE, rtol=2e-3)
    assert abs(last["traction.top-y"] + last["traction.bottom-y"]) < 1e-5 * PUSH * SIZE
    assert abs(last["momentum-x"]) < 1e-12


def closed(kind, folder):
    """A region with a closed surface that cuts cells anywhere: round, of triangles, a profile."""
    if kind == "mesh":
        turned = np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2 + np.eye(3))[0]
        corners = octahedron(1, 2.2) @ (turned * np.sign(np.linalg.det(turned))).T
        stl(folder / "body.stl", corners + np.array([3.13, 2.91, 3.27]))
        return {"mesh": {"file": str(folder / "body.stl")}}
    if kind == "profile":
        np.save(folder / "h.npy", np.array([4.2, 4.75, 3.9, 5.1, 4.4]))
        nodes = {"origin": [0.93], "spacing": [1.03]}
        return {"heights": {"file": str(folder / "h.npy"), "bottom": 1.17, "nodes": nodes}}
    return {"ball": {"centre": [3.13, 2.91, 3.27][: int(kind[-1])], "radius": 2.2}}


@pytest.mark.parametrize("kind", ["ball 2", "ball 3", "mesh", "profile"])
def test_a_pressure_all_round_balances_uniform_stress(kind, tmp_path):
    """At every vertex, wherever a surface cuts cells: forces of the load and of the stress."""
    ball, D = closed(kind, tmp_path), 2 if kind in ("ball 2", "profile") else 3
    load = {
        "body": "body",
        "pressure": -1.0,
        "region": {"box": {"min": [0.0] * D, "max": [6.0] * D}},
    }
    sim = start(scene(D, exact(ball), cells=[6] * D, tractions={"all": load}))
    _, dN, cells = corners(sim)
    volume, force = sim.particles.V0[sim.live()], np.zeros((*[7] * D, D))
    truth = at_vertices((7,) * D, cells, volume[:, None, None] * dN)
    fold, grid = sim.rank.slaves.add_forces, sim.rank.grid

    def keep(rank, update):
        G = grid.by_vertex(grid.G)[:, 0, ..., FORCE : FORCE + D]
        first = np.array(grid.window.lower[:D]) - sim.scene.domain.frame.ghost
        for place in np.argwhere((G != 0.0).any(axis=-1)):
            force[tuple(place[:D] + first)] = G[tuple(place)]
        fold(rank, update)

    sim.rank.slaves.add_forces = keep
    sim.advance()
    assert np.abs(force.sum(axis=tuple(range(D)))).max() < 1e-12
    rounding = 1e-4 if "ball" in kind else 1e-11
    assert np.abs(force - truth).max() < rounding * np.abs(truth).max()


def test_faces_and_regions_give_the_same():
    region = {"box": {"min": [0.0, 0.0], "max": [9.0, 9.0]}}
    by_region = {"region": region, "normal": {"of": [2.0, 0.0], "within": 10}}
    found = []
    for load in ({"face": "x-max"}, by_region):
        pressed = {"body": "body", "pressure": 1.0} | load
        sim = start(block((1.37, 1.98), end=0.2, tractions={"t": pressed}))
        sim.advance()
        momentum = sim.diagnostics()["momentum-x"]
        np.testing.assert_allclose(momentum, -SIZE * sim.dt, rtol=1e-12)
        finish(sim)
        found.append(sim.particles.v[sim.live()])
    np.testing.assert_allclose(*found, atol=1e-12)


@pytest.mark.parametrize("load", ["face", "corner"])
def test_work_of_the_first_step_is_its_kinetic_energy(load):
    """Of a load that follows, with slaves under it and at a corner that it goes round."""
    place = {"face": "x-max"}
    if load == "corner":
        place = {"region": {"box": {"min": [3.0, 3.0], "max": [9.0, 9.0]}}}
    tractions = {"t": {"body": "body", "pressure": 1.0} | place}
    sim = start(block((1.37, 1.98), end=0.2, tractions=tractions))
    sim.advance()
    assert len(sim.rank.slaves.keys)
    line = sim.diagnostics()
    assert line["external-work"] == pytest.approx(line["kinetic-energy"], rel=1e-12)


def test_loads_end_where_their_region_ends():
    part = {"box": {"min": [2.13, 5.0], "max": [4.01, 9.0]}}
    load = {"t": {"body": "body", "region": part, "traction": [0.0, 1.0]}}
    sim = start(block((1.37, 1.98), end=0.2, tractions=load))
    sim.advance()
    np.testing.assert_allclose(sim.diagnostics()["momentum-y"], 1.88 * sim.dt, rtol=1e-12)


def test_spin_momentum_and_energy_of_vertices():
    """Totals are those of the vertices' lumped masses; spin and momentum stay."""
    spin = {"rotation": {"about": [4.0, 4.0], "rate": 0.8}, "translation": [0.1, 0.0]}
    sim = start(block((1.98, 2.02), end=1.0, velocity=spin))
    first = sim.diagnostics()
    grid = sim.rank.grid
    finish(sim)
    last, kept = sim.diagnostics(), grid.kept.values.reshape(-1, RECORD)
    m, v = kept[:, KEPT_MASS], kept[:, KEPT_VELOCITY : KEPT_VELOCITY + 2]
    np.testing.assert_allclose(last["kinetic-energy"], 0.5 * (m[:, None] * v**2).sum(), rtol=1e-12)
    np.testing.assert_allclose(last["momentum-x"], (m * v[:, 0]).sum(), rtol=1e-12)
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        np.testing.assert_allclose(last[name], first[name], rtol=1e-12)
    energy = [line["kinetic-energy"] + line["strain-energy"] for line in (first, last)]
    np.testing.assert_allclose(*energy, rtol=2e-3)


def folding(sim, shape):
    """The matrix T, from vertices that move by themselves to all of them, and the slaves."""
    slaves, ghost, D = sim.rank.slaves, sim.scene.domain.frame.ghost, len(shape)
    at = [
        np.ravel_multi_index([n - ghost for n in Vertices.numbers(sim.rank, keys)[:D]], shape)
        for keys in (slaves.keys, slaves.masters)
    ]
    T = np.eye(np.prod(shape))
    T[at[0]] = 0.0
    np.add.at(T, (at[0][:, None], at[1][slaves.of]), slaves.weights)
    return T, at[0]


@pytest.mark.parametrize("D", [2, 3])
def test_averaged_mass(D):
    """Accelerations, energy and spin by L + alpha (C - L), of vertices that move by themselves."""
    centre, shape = [3.13, 2.91, 2.83][:D], (7,) * D
    ball = exact({"ball": {"centre": centre, "radius": 2.2}})
    rng, sims, v = np.random.default_rng(3), {}, None
    for mass in ("lumped", "averaged"):
        case = scene(D, ball, cells=[6] * D)
        case["method"]["mass"] = mass
        sim = sims[mass] = start(case)
        kept, ghost = sim.rank.grid.kept.values.reshape(-1, RECORD), sim.scene.domain.frame.ghost
        window, number = sim.rank.grid.window, np.indices(shape).reshape(D, -1)
        place = [n + ghost - low for n, low in zip(number, window.lower, strict=False)]
        here = sum(n * (stride // RECORD) for n, stride in zip(place, window.stride, strict=False))
        v = 0.01 * rng.normal(size=(len(here), D)) if v is None else v
        T, slaves = folding(sim, shape)
        assert len(slaves)
        some = kept[here, KEPT_MASS] > 0.0
        kept[here[some], KEPT_VELOCITY : KEPT_VELOCITY + D] = v[some]
        kept[here[slaves], KEPT_VELOCITY : KEPT_VELOCITY + D] = (T @ v)[slaves]
        sim.advance()
        before = kept[here, KEPT_VELOCITY : KEPT_VELOCITY + D].copy()
        sim.advance()
        sims[mass] = sim, kept[here, KEPT_VELOCITY : KEPT_VELOCITY + D] - before

    # The averaged mass of the particles' weights.
    (sim, found), lumped = sims["averaged"], sims["lumped"][1]
    p, rows, alpha = sim.particles, sim.live(), sim.rank.averaged_mass.alpha[0]
    N, _, cells = corners(sim)
    W = np.zeros((len(rows), T.shape[0]))
    at = np.ravel_multi_index(np.moveaxis(cells, -1, 0), shape)
    np.put_along_axis(W, at, N, axis=1)
    C = (W @ T).T @ (p.m[rows][:, None] * (W @ T))
    L = C.sum(axis=1)
    np.testing.assert_allclose(kept[here, KEPT_MASS], L, atol=1e-13)
    inside = L > 0.0
    change = np.zeros_like(lumped)
    change[inside] = (C[inside] @ lumped - (L[:, None] * lumped)[inside]) / L[inside, None]
    expected = T @ (lumped * inside[:, None] - alpha * change)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(lumped).max())
    assert np.abs(alpha * change).max() > 0.1 * np.abs(lumped).max()
    # Ledgers.
    M, v = (1.0 - alpha) * np.diag(L) + alpha * C, kept[here, KEPT_VELOCITY : KEPT_VELOCITY + D]
    line = sim.diagnostics()
    assert line["kinetic-energy"] == pytest.approx(0.5 * (v * (M @ v)).sum(), rel=1e-12)
    x = number.T + kept[here, DISPLACEMENT : DISPLACEMENT + D]
    momentum = M @ v
    spin = (x[:, 0] * momentum[:, 1] - x[:, 1] * momentum[:, 0])[inside].sum()
    assert line["angular-momentum-z"] == pytest.approx(spin, rel=1e-12)


def test_parts_of_a_mesh_are_as_of_a_box(tmp_path):
    """A square of lines is as the box; weights of a slanted one's parts are never negative."""
    path, found = tmp_path / "square.obj", []
    places = [(1.37, 1.21), (5.37, 1.21), (5.37, 5.21), (1.37, 5.21)]
    path.write_text("\n".join([*(f"v {x} {y} 0" for x, y in places), "l 1 2 3 4 1", ""]))
    for turn in ({}, {"rotate": 30.0, "translate": [3.0, 0.0]}):
        found.append(start(scene(2, exact({"mesh": {"file": str(path)} | turn}), cells=[9, 9])))
    (square, slanted), box = found, start(block((1.37, 1.21)))
    for a, b in zip(box.particles, square.particles, strict=True):
        np.testing.assert_allclose(b[square.live()], a[box.live()], atol=1e-12)
    assert next(corners(slanted)).min() > -1e-12


def thin(step):
    """A plate of a quarter of a cell, just across a plane of vertices."""
    region = {"box": {"min": [1.3, 2.97], "max": [6.4, 3.25]}}
    return scene(2, exact(region, velocity=[0.1, 0.2]), step=step, end=2.0)


def test_thin_bodies_keep_their_vertices():
    sim = start(thin({"courant": 0.5}))
    slaves = sim.rank.slaves
    assert len(slaves.free) > 3 and 0.5 < slaves.courant < 0.7
    assert any("no cell near them" in note for note in sim.notes)
    finish(sim)
    np.testing.assert_allclose(sim.particles.v[sim.live()], [[0.1, 0.2]] * sim.count, rtol=1e-9)
    with pytest.raises(CaseError, match="stable up to the Courant number"):
        start(thin({"courant": 0.7}))


@pytest.mark.parametrize("face", ["fixed", "slip"])
def test_a_body_that_hardly_reaches_into_the_cell_beside_a_face_is_not_held(face):
    """It falls as without the face, at a usual Courant number."""
    body = exact({"box": {"min": [1.0, 1.02], "max": [8.03, 5.03]}})
    found = []
    for boundaries in ({}, {"x-max": face}):
        case = scene(2, body, cells=[9, 9], end=0.5, step={"courant": 0.3}, gravity=[0.0, -1.0])
        sim = finish(start(case | {"boundaries": boundaries}))
        assert not len(sim.rank.slaves.free)
        found.append(sim.particles.v[sim.live()])
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
    np.testing.assert_allclose(found[0][:, 1], -0.5, rtol=1e-9)


def test_what_a_face_holds_does_not_count_for_the_step():
    """A plate that hardly reaches a cell's corner, whose light vertices a face holds."""
    region = {"box": {"min": [0.0, 2.97], "max": [0.98, 3.25]}}
    case = scene(2, exact(region), step={"courant": 0.1}, end=0.1)
    loose = start(case).rank.slaves.courant
    held = start(case | {"boundaries": {"x-min": "fixed"}}).rank.slaves.courant
    assert loose < held


def test_a_thin_ring_is_stable_up_to_what_its_vertices_bear():
    """Masters of slaves on both sides lose mass to them: .57 of a cell thick, refused at .65."""
    balls = [{"ball": {"centre": [9.0, 9.0], "radius": radius}} for radius in (8.0, 7.43)]
    turn = {"velocity": {"rotation": {"about": [9.0, 9.0], "rate": 0.01}}}

    def ring(courant, **more):
        body = exact({"difference": balls}, **turn, **more)
        return scene(2, body, cells=[18, 18], end=40.0, step={"courant": courant})

    with pytest.raises(CaseError, match=r"stable up to the Courant number 0\.5\d; .* has 0\.65"):
        start(ring(0.65))
    with pytest.raises(CaseError, match=r"stable up to the Courant number 0\.4\d; .* has 0\.5"):
        start(ring(0.5, mass="averaged"))
    sim = start(ring(0.5))
    first = sim.diagnostics()["kinetic-energy"]
    finish(sim)
    line = sim.diagnostics()
    assert sim.step > 100
    assert abs(line["kinetic-energy"] + line["strain-energy"] - first) < 1e-3 * first


def test_a_bar_in_one_dimension():
    """A bar that ends within two cells: its mass, and its stress under a face's traction."""
    body = exact({"box": {"min": [1.03], "max": [6.2]}})
    pull = {"pull": {"body": "body", "face": "x-max", "traction": [0.5]}}
    hold = {"hold": {"body": "body", "face": "x-min", "traction": [-0.5]}}
    sim = start(scene(1, body, end=8.0, tractions=pull | hold, damping={"mass": 3.0}))
    finish(sim)
    np.testing.assert_allclose(sim.diagnostics()["mass"], 5.17, rtol=1e-13)
    np.testing.assert_allclose(sim.particles.sigma[sim.live(), 0], 0.5, rtol=1e-4)


@pytest.mark.parametrize(
    "region",
    [
        {"box": {"min": [1.3, 3.98], "max": [6.6, 4.28]}},
        {"ball": {"centre": [3.98, 3.97], "radius": 0.3}},
    ],
)
def test_bodies_thinner_than_a_cell_bear_steps_of_any_body(region):
    """Vertices without masters take mass from their cells' others; momenta and energy last."""
    spin = {"rotation": {"about": [4.0, 4.0], "rate": 0.05}, "translation": [0.02, 0.01]}
    body = exact(region, velocity=spin)
    sim = start(scene(2, body, cells=[8, 8], end=4.0, step={"courant": "auto"}))
    slaves, kept = sim.rank.slaves, sim.rank.grid.kept.values.reshape(-1, RECORD)
    assert len(slaves.free) > 3 and slaves.courant > 0.6
    first = sim.diagnostics()
    assert kept[:, KEPT_MASS].sum() == pytest.approx(first["mass"], rel=1e-12)
    while not sim.finished:
        sim.advance()
    last = sim.diagnostics()
    v = kept[:, KEPT_VELOCITY : KEPT_VELOCITY + 2]
    momentum = (kept[:, KEPT_MASS, None] * v).sum(axis=0)
    for name, d in (("momentum-x", 0), ("momentum-y", 1)):
        assert last[name] == pytest.approx(first[name], rel=1e-11)
        assert last[name] == pytest.approx(momentum[d], rel=1e-11)
    assert last["angular-momentum-z"] == pytest.approx(first["angular-momentum-z"], rel=1e-10)
    energy = [line["kinetic-energy"] + line["strain-energy"] for line in (first, last)]
    assert energy[1] == pytest.approx(energy[0], rel=2e-3)
