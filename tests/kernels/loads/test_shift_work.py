"""Work of body forces where the grid is not all that moves particles."""

import numpy as np
import pytest
from scenes import box, field, scene, start, wall

import pgimp
from pgimp.physics.functions.registry import FUNCTIONS

pytestmark = pytest.mark.slow(20)

ABOUT, RATE, SPEED = np.array([1.0, 9.0]), 1.0, -0.1
PULL = [-3.0, -5.0]

#: A block that is pressed into a corner.
CORNERS = {
    "mirrors": {"shape": "bspline-quadratic", "boundaries": {"x-min": "unilateral"}},
    "points": {"shape": "mpm", "boundaries": {"x-min": wall(0.1, None)}},
    "corners": {"shape": "cpdi", "wall": "mirror", "boundaries": {"x-min": "slip"}},
    "absorbing": {"shape": "finite-gimp", "end": 0.5, "boundaries": {"x-min": "absorbing"}},
    "rings": {"geometry": "axisymmetric", "boundaries": {}},
    "initial": {"boundaries": {"x-min": "unilateral"}},
}


@pytest.fixture
def uniform():
    """A uniform force as a function of one's own, which is gone after a test."""
    before = dict(FUNCTIONS)

    @pgimp.body_force("uniform-pull")
    def pull(x, along, up):
        return along, up

    yield {"function": "uniform-pull", "parameters": dict(zip(("along", "up"), PULL, strict=True))}
    FUNCTIONS.clear()
    FUNCTIONS.update(before)


def sloshing():
    """A liquid that a turning frame throws against walls, and over a rigid block that moves."""
    region = {"box": {"min": [3.3, 0.0], "max": [4.7, 2.2]}}
    case = scene(
        2,
        {
            "pool": box([0.0, 0.0], [3.0, 4.0], [0.5, 0.0]),
            "block": {"rigid": {"velocity": [SPEED, 0.0]}, "region": region},
        },
        cells=[8, 6],
        end=2.0,
        step=0.02,
        body_force={"rotating-frame": {"about": ABOUT.tolist(), "rate": RATE}},
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min"), "slip"),
        contact=[{"bodies": ["pool", "block"], "law": "friction"}],
    )
    water = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 0.01, "density": 1.0}
    case["method"]["wall"] = "ghost"  # walls that do not reflect have more to hold
    return case | {"materials": {"soft": water}}


def test_work_is_the_force_on_each_particle_times_its_whole_way():
    """Also of what walls and bodies hold, and of what flows to free space: in each step."""
    sim = start(sloshing())
    line, held = sim.diagnostics(), np.zeros(2, int)
    while not sim.finished:
        x, v, m = (field(sim, name) for name in "xvm")
        turning = np.column_stack([v[:, 1], -v[:, 0]])
        force = m[:, None] * (RATE**2 * (x - ABOUT) + 2.0 * RATE * turning)
        sim.advance()
        last, line = line, sim.diagnostics()
        now = field(sim, "x")
        work = float((force * (now - x)).sum())
        work += line["rigid.block.work"] - last["rigid.block.work"]
        done = line["external-work"] - last["external-work"]
        assert done == pytest.approx(work, rel=0, abs=1e-11)
        across, up = now.T
        held[0] += ((across == 0.0) | (across == 8.0) | (up == 0.0)).sum()
        held[1] += ((np.abs(across - 3.3 - SPEED * sim.time) < 1e-12) & (up < 2.2)).sum()
    assert held.min() > 10


@pytest.mark.wide
@pytest.mark.parametrize("kind", CORNERS)
def test_a_uniform_force_works_as_gravity(kind, uniform):
    """Whatever takes up the momentum, and sets particles back: to rounding, in each step."""
    parts = dict(CORNERS[kind])
    walls = parts.pop("boundaries") | {"y-min": "slip"}
    block = box([0.0, 0.0], [2.0, 2.0], [0.0, -1.0])
    pull = [0.0, PULL[1]] if kind == "rings" else PULL
    if kind == "initial":
        block["formulation"] = "initial"
    uniform["parameters"]["along"] = pull[0]
    pulled = {"gravity": pull}, {"body-force": uniform}
    sims = [start(scene(2, block, cells=[4, 4], boundaries=walls, **parts, **load))
            for load in pulled]  # fmt: skip
    if kind == "rings":  # boxes at a wall have weight on the vertices before it, and creep through
        for sim in sims:
            rows = sim.live()
            sim.particles.x[rows, 1] -= sim.particles.x[rows, 1].min() - 1e-6
            sim.population.sort()
    most = 0.0
    while not sims[0].finished:
        work = [sim.advance() or sim.diagnostics()["external-work"] for sim in sims]
        most = max(most, abs(work[0]))
        assert work[1] == pytest.approx(work[0], rel=1e-11, abs=1e-12 * most)
    assert most > 1.0 and (sims[1].rank.held > 0) == (kind == "rings")
