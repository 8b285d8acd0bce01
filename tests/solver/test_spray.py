"""A particle of a liquid that is alone, with `affine`: its stretch does not press it to nothing."""

import numpy as np
from scenes import start


def alone(**method):
    """The solver of one particle of water that drifts, half a cell from vertices along y only."""
    case = {
        "format": 1, "dimensions": 2, "grid": {"size": [12.0, 8.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2], "affine": True, **method},
        "time": {"end": 1.0e3, "step": {"courant": 0.3}},
        "materials": {"water": {"model": "newtonian", "bulk": 100.0, "density": 1.0}},
        "bodies": {
            "water": {
                "material": "water", "velocity": [0.05, 0.0],
                "region": {"box": {"min": [4.5, 4.0], "max": [5.0, 4.5]}},
            }
        },
    }  # fmt: skip
    sim = start(case)
    assert len(sim.rank.up_to_date().id) == 1
    sim.rank.up_to_date().x[0] += 0.2
    return sim


def test_a_particle_alone_keeps_its_volume_and_its_spin():
    # Without the rule its stretch feeds itself: at t = 1.1 the particle has half of its volume.
    sim = alone()
    sim.rank.up_to_date().L[0] = [3.0, -0.5, 0.5, -3.0]
    while sim.time < 5.0:
        sim.advance()
        assert 0.9 < float(sim.rank.up_to_date().V[0]) / 0.25 < 1.5
    spin = sim.rank.up_to_date().L[0].reshape(2, 2)
    np.testing.assert_allclose(spin + spin.T, 0.0, atol=0.05)
    np.testing.assert_allclose(sim.rank.up_to_date().v[0, :2], [0.05, 0.0], atol=1e-12)
    assert 0.25 < spin[1, 0] < 0.75  # the voids that its stretch opened have slowed it a little
