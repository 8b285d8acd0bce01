"""A gas under pressure at rest in a box, with the method that is chosen."""

import numpy as np
import pytest

import pgimp

#: Sound speed of the gas.
SPEED = (1.4 * 0.4 * 2.5) ** 0.5


@pytest.mark.parametrize("axial", ["slip", "unilateral", "periodic"])
def test_it_rests(axial):
    """Speeds stay within the rounding of the steps; eddies would grow to half of that of sound."""
    steps, size = 3000, [20.0, 4.0]
    sim = pgimp.Simulation(pgimp.load({
        "format": 2, "dimensions": 2, "time": {"end": 1e4},
        "grid": {"origin": [0.0, 0.0], "size": size, "cell": [1.0, 1.0]},
        "materials": {"air": {"model": "ideal-gas", "gamma": 1.4, "density": 1.0, "energy": 2.5}},
        "bodies": {"air": {"material": "air", "region": {"box": {"min": [0.0, 0.0], "max": size}}}},
        "boundaries": {"x-min": axial, "x-max": axial, "y-min": "slip", "y-max": "slip"},
    }))  # fmt: skip
    sim.step(steps)
    rounding = steps * np.finfo(float).eps * SPEED
    assert np.abs(sim.particles["velocity"]).max() < 10.0 * rounding
    assert -sim.particles["stress"][:, :3] == pytest.approx(1.0, rel=1e-9)
