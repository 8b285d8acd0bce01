"""Work of a body force where the grid is not all that moves particles."""

import numpy as np
import pytest
from scenes import box, field, scene, start

pytestmark = pytest.mark.slow(20)

ABOUT, RATE = np.array([1.0, 9.0]), 1.0


def sloshing():
    """A liquid that a turning frame throws against walls, and over a rigid block."""
    block = {"rigid": {}, "region": {"box": {"min": [3.3, 0.0], "max": [4.7, 2.2]}}}
    case = scene(
        2,
        {"pool": box([0.0, 0.0], [3.0, 4.0], [0.5, 0.0]), "block": block},
        cells=[8, 6],
        end=2.0,
        step=0.02,
        body_force={"rotating-frame": {"about": ABOUT.tolist(), "rate": RATE}},
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min"), "slip"),
        contact=[{"bodies": ["pool", "block"], "law": "friction"}],
    )
    water = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 0.01, "density": 1.0}
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
        work += line["tool.block.work"] - last["tool.block.work"]
        done = line["external-work"] - last["external-work"]
        assert done == pytest.approx(work, rel=0, abs=1e-11)
        across, up = now.T
        held[0] += ((across == 0.0) | (across == 8.0) | (up == 0.0)).sum()
        held[1] += ((across == 3.3) & (up < 2.2)).sum()
    assert held.min() > 10
