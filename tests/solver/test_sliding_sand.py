"""Sand that slides on a wall is braked by its friction, whatever the shape of particles."""

import numpy as np
import pytest
from tiers import wide

import pgimp

#: tan = sin(phi) of sand that shears at constant volume, here 0.6; its depth, and gravity.
PHI, DEPTH, G = np.degrees(np.arcsin(0.6)), 1.0, 9.81


def braked(shape, cell):
    """Deceleration over g of the middle of a layer of sand on a fixed floor."""
    sand = {
        "model": "drucker-prager", "match": "plane-strain-flow", "young": 1.0e7, "poisson": 0.3,
        "density": 1500.0, "cohesion": 0.0, "friction-angle": PHI,
    }  # fmt: skip
    layer = {"box": {"min": [1.0, 0.0], "max": [7.0, DEPTH]}}
    sim = pgimp.Simulation({
        "format": 1,
        "dimensions": 2,
        "grid": {"size": [9.0, 1.5], "cell": [cell, cell]},
        "method": {"shape": shape, "particles-per-cell": [2, 2]},
        "time": {"end": 0.4, "step": {"courant": 0.3}},
        "materials": {"sand": sand},
        "bodies": {"layer": {"material": "sand", "region": layer, "velocity": [3.0, 0.0]}},
        "gravity": [0.0, -G],
        "boundaries": {"y-min": "fixed"},
    })  # fmt: skip
    middle = np.abs(sim.particles["position"][:, 0] - 4.0) < 1.0
    speeds = []
    for time in (0.1, 0.4):
        sim.advance(time)
        speeds.append(sim.particles["velocity"][middle, 0].mean())
    return (speeds[0] - speeds[1]) / (0.3 * G)


@pytest.mark.parametrize("shape", ["gimp", wide("bspline-quadratic")])
def test_a_fixed_floor_brakes_sand_by_its_own_friction(shape):
    """Sand shears in the cells at the floor, under the weight of what is above their middle.

    4 %: the weight swings by some per cent, as gravity is set on at once.
    """
    cell = 0.1
    assert braked(shape, cell) == pytest.approx(0.6 * (1.0 - 0.5 * cell / DEPTH), rel=0.04)
