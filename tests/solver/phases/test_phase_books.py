"""Books of energy with `stress: average`: they close at every output, and the watch trusts them."""

import numpy as np
import pytest
from scenes import box, scene, start

pytestmark = pytest.mark.slow(20)


def unbalanced(courant, **parts):
    """Greatest part of the energy that the books do not explain, at any step."""
    case = scene(2, box([3.0, 2.2], [9.0, 5.2]), cells=[12, 8], end=2.0, **parts)
    case["method"]["stress"] = "average"
    case["time"]["step"] = {"courant": courant}
    sim = start(case)
    lost, most = 0.0, 0.0
    sim.diagnostics()
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        lost = max(lost, abs(line["dissipated-energy"]))
        most = max(most, abs(line["external-work"]) + line["kinetic-energy"])
    return lost / most


def test_a_falling_body_has_all_work_of_gravity():
    """To rounding; by the way of particles, half a step ahead, it is off in proportion to it."""
    assert unbalanced(0.3, gravity=[0.2, -1.0]) < 1e-13


def test_work_of_loads_is_of_second_order():
    """Of a held block that is pulled, pressed by what turns with it, and turned with the grid."""
    loads = {
        "pull": {"body": "body", "face": "x-max", "traction": [0.02, 0.05]},
        "press": {"body": "body", "face": "y-max", "pressure": 0.05},
    }
    parts = {
        "boundaries": {"x-min": "fixed"},
        "tractions": loads,
        "gravity": [0.0, -0.02],
        "body-force": {"rotating-frame": {"about": [6.0, 4.0], "rate": 0.1}},
    }
    long, short = (unbalanced(courant, **parts) for courant in (0.4, 0.2))
    assert long < 2e-3
    assert short < 0.3 * long


def test_the_watch_of_steps_takes_velocities_of_the_time_of_strains():
    """Means of both, as `last` needs them, swing by a fifth in a wave of seven cells."""
    case = scene(1, box([1.0], [11.0]), cells=[14], end=60.0, step={"courant": "auto"})
    case["materials"] = {"soft": {"model": "linear-1d", "young": 1.0, "density": 1.0}}
    case["method"]["stress"] = "average"
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = 0.03 * np.cos(0.3 * np.pi * (p.x[rows, 0] - 1.0))
    while not sim.finished:
        sim.advance()
    assert sim.watch.part == 1.0 and not sim.watch.said
