"""Orders of phases: waves and vibrations keep their energy with `stress: average`, in any frame."""

import numpy as np
import pytest
from reference_weights import weights
from scenes import box, field, finish, scene, start, stir, wall

from pgimp.errors import CaseError
from pgimp.solver.parts import parts_of

pytestmark = pytest.mark.slow(30)

CELL, AMPLITUDE, COURANT = 0.1, 0.03, 0.3


def bar(stress, velocity=0.0, periods=1.0, **method):
    """A free bar of ten cells, to be set swinging in its first mode; wave speed, length 1."""
    cells = round((3.2 + 2.0 * velocity * periods) / CELL)
    case = scene(1, box([1.03], [2.03], [velocity]), cells=[cells], cell=CELL,
                 end=periods * 2.0, step={"courant": COURANT})  # fmt: skip
    case["materials"] = {"soft": {"model": "linear-1d", "young": 1.0, "density": 1.0}}
    case["method"] |= {"stress": stress, **method}
    sim = start(case)
    p, rows = sim.particles, sim.live()
    shape = np.cos(np.pi * (p.x[rows, 0] - 1.03))
    p.v[rows, 0] += AMPLITUDE * shape
    if p.L.shape[1]:
        p.L[rows, 0] = -np.pi * AMPLITUDE * np.sin(np.pi * (p.x[rows, 0] - 1.03))
    return sim


def vibration(sim):
    """Kinetic energy as seen from the centre of mass, and strain energy."""
    line = sim.diagnostics()
    return line["kinetic-energy"] - 0.5 * line["momentum-x"] ** 2 / line["mass"], line[
        "strain-energy"
    ]


def kept(sim):
    """Energy of the vibration in the last period, over that of the first."""
    energies = []
    while not sim.finished:
        sim.advance()
        energies.append(sum(vibration(sim)))
    count = len(energies) // round(sim.clock.end / 2.0)
    return np.mean(energies[-count:]) / np.mean(energies[:count])


def test_a_step_is_what_its_equations_say():
    """Against plain NumPy, over all vertices: half the strain before, half by mapped velocities."""
    sim = bar("average")
    x, v, F = (field(sim, name).ravel() for name in "xvF")
    m, V0 = field(sim, "m"), field(sim, "V0")
    nodes = CELL * np.arange(-2, 35)
    for _ in range(20):
        sim.advance()
        dt = sim.dt
        S, slope = weights("gimp", x[:, None] - nodes, CELL, 0.25 * CELL)
        mass = m @ S
        inverse = np.where(mass > 0.0, 1.0 / np.where(mass > 0.0, mass, 1.0), 0.0)
        before = (m * v) @ S * inverse
        half = F / (1.0 - 0.5 * dt * (slope @ before))
        a = -(V0 * half * (half - 1.0)) @ slope * inverse  # Cauchy stress F - 1 on the volume V0 F
        v = v + dt * (S @ a)
        mapped = (m * v) @ S * inverse
        F = half * (1.0 + 0.5 * dt * (slope @ mapped))
        x = x + dt * (S @ mapped)
    for mine, name in ((x, "x"), (v, "v"), (F, "F")):
        np.testing.assert_allclose(field(sim, name).ravel(), mine, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("velocity", [0.0, 0.05, 0.2, 1.0])
def test_waves_keep_their_energy_in_any_frame(velocity):
    """Over 50 periods; with `last` they die away, `last-mapped` makes energy in some."""
    assert kept(bar("average", velocity, 50.0)) == pytest.approx(1.0, abs=0.01)


def test_other_orders_do_not():
    assert kept(bar("last", 0.05, 50.0)) < 0.4
    assert kept(bar("last-mapped", 0.0, 50.0)) == pytest.approx(1.0, abs=0.1)
    assert kept(bar("last-mapped", 0.2, 50.0)) > 1.2


def test_longer_steps_are_stable():
    """At twice the Courant number that is the limit with `last` waves keep their energy."""
    sim = bar("average", 0.05, 50.0)
    sim.clock.courant = 0.9
    assert kept(sim) == pytest.approx(1.0, abs=0.03)


def block(stress, turn=0.0, velocity=0.0, **parts):
    """A free block of 8 x 4 cells that bends, turns and moves."""
    motion = {"rotation": {"about": [7.3, 5.2], "rate": turn}, "translation": [velocity, 0.0]}
    case = scene(2, box([3.3, 3.2], [11.3, 7.2], motion), cells=[30, 12], end=6.0,
                 step={"courant": COURANT}, **parts)  # fmt: skip
    case["method"]["stress"] = stress
    sim = start(case)
    stir(sim, 0.3)
    return sim


@pytest.mark.parametrize(("turn", "velocity"), [(0.0, 0.0), (0.5, 0.0), (0.0, 2.0)])
def test_a_bending_block_keeps_its_energy(turn, velocity):
    """As it swings some fifty times, turns half round, or crosses twelve cells."""
    lost = {}
    for stress in ("last", "average"):
        sim = block(stress, turn, velocity)
        line = sim.diagnostics()
        begun = line["kinetic-energy"] - 0.5 * line["momentum-x"] ** 2 / line["mass"]
        lost[stress] = finish(sim).diagnostics()["dissipated-energy"] / begun
    assert abs(lost["average"]) < 0.01
    assert lost["last"] > 0.04


def test_faces_and_constraints_hold_mapped_velocities():
    """And momentum grows by what they give and by gravity, to rounding."""
    body = box([0.0, 2.0], [6.0, 5.0], [0.5, -0.4])
    grip = {"body": "body", "region": {"box": {"min": [4.0, 2.0], "max": [6.0, 5.0]}}}
    case = scene(2, body, cells=[12, 8], end=1.0, gravity=[0.0, -1.0],
                 boundaries={"x-min": "fixed", "y-min": wall(None, 0.2)},
                 constraints={"grip": grip | {"velocity": [0.3, None]}})  # fmt: skip
    case["method"]["stress"] = "average"
    sim = start(case)
    before = sim.diagnostics()
    finish(sim)
    grid, line = sim.rank.phases._sums.grid, sim.diagnostics()
    v = grid.by_vertex(grid.G)[:, 0, :, 0, 1:3]
    mass = grid.by_vertex(grid.G)[:, 0, :, 0, 0] > 0.0
    first = sim.scene.domain.frame.ghost - sim.rank.grid.window.lower[0]
    assert mass[first].any() and (v[first][mass[first]] == 0.0).all()
    marked = sim.rank.grid.marks[0].reshape(mass.shape) > 0
    assert (marked & mass).any() and (v[marked & mass][:, 0] == 0.3).all()
    given = sim.rank.ledger.impulse.sum((0, 1)) + sim.rank.ledger.constraint_impulse.sum((0, 1))
    given[1] -= line["mass"] * sim.time
    for d, axis in enumerate("xy"):
        gained = line[f"momentum-{axis}"] - before[f"momentum-{axis}"]
        assert gained == pytest.approx(given[d], abs=1e-10)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"formulation": "total-lagrangian"}, "is for the current configuration"),
        ({"other": True}, "'body' is total Lagrangian and 'other' updated"),
    ],
)
def test_it_is_for_the_current_configuration(change, said):
    body = box([1.0], [3.0]) | {"formulation": "total-lagrangian"}
    bodies = {"body": body} | ({"other": box([4.0], [6.0])} if "other" in change else {})
    case = scene(1, bodies)
    case["method"]["stress"] = "average"
    with pytest.raises((CaseError, ValueError), match=said):
        start(case)


def test_other_scenes_pay_nothing():
    """Without the key there is no part, and kernels are given nothing of it."""
    sim = bar("last")
    assert sim.rank.phases is None and parts_of(sim.rank) == []


def test_chosen_steps_are_longer():
    """`courant: auto` takes nine tenths of the largest stable Courant number; affine keeps its."""
    case = scene(2, box([2.0, 2.0], [4.0, 4.0]), step={"courant": "auto"})
    for more, courant in (({}, 0.855), ({"affine": True}, 0.63)):
        case["method"] |= {"stress": "average"} | more
        assert start(case).scene.case.courant == pytest.approx(courant)
