"""A particle that must not go on stops `grid_to_particles`, and says why."""

import numpy as np
import pytest
from kernel_driver import SEED, Rank, entry, make_frame, random_particles, random_positions

from pgimp.kernels.g2p import INVERTED, NOT_FINITE, OUTSIDE, TOO_FAST
from pgimp.shapes import SHAPES
from pgimp.solver.particles import Particles

ORIGIN, CELL, CELLS = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.9), (5, 4, 3)
DT = 0.002


def still_particles(name):
    """Rank in 3D with particles at rest, unstressed, 0.4 cells from the nearest face."""
    rng = np.random.default_rng(SEED)
    shape = entry(name, (2, 1, 3))
    frame = make_frame(shape, ORIGIN, CELL, CELLS)
    p = random_particles(rng, random_positions(rng, frame, 8, 0.4))
    p.v[:], p.sigma[:] = 0.0, 0.0
    p.x[3] = np.array(ORIGIN) + np.array(CELL) * 0.4
    p.x[4] = np.array(ORIGIN) + np.array(CELL) * (np.array(CELLS) - 0.4)
    return Rank(shape, frame, p)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("field", "axis", "value", "reason"),
    [
        (None, 0, 0.0, 0),
        ("v", 2, 0.39 * CELL[2] / DT, 0),
        ("v", 2, 0.41 * CELL[2] / DT, OUTSIDE),
        ("v", 1, -0.41 * CELL[1] / DT, OUTSIDE),
        ("v", 0, -0.41 * CELL[0] / DT, OUTSIDE),
        ("v", 1, 0.95 * CELL[1] / DT, OUTSIDE),
        ("v", 2, 1.01 * CELL[2] / DT, TOO_FAST),
        ("v", 1, -1.01 * CELL[1] / DT, TOO_FAST),
        ("v", 1, np.nan, NOT_FINITE),
        ("sigma", 3, np.inf, NOT_FINITE),
        ("F", 0, -9.0, INVERTED),
        ("F", 8, np.nan, NOT_FINITE),
    ],
)
def test_a_particle_at_fault_stops_the_step(name, field, axis, value, reason):
    rank = still_particles(name)
    if field:
        getattr(rank.particles, field)[:, axis] = value
    rank.particles_to_grid()
    rank.update_momentum(DT)
    fault, row, *_ = rank.grid_to_particles(DT)
    assert fault == reason
    assert row in rank.population.order if reason else row == -1


@pytest.mark.parametrize("name", SHAPES)
def test_rounding_takes_no_particle_past_two_layers(name):
    """Moved by a cell from where a layer begins, but for rounding: stopped, or in the next layer.

    Two layers away is past a neighbouring slab of one layer, and the particle would be lost.
    """
    rng = np.random.default_rng(SEED)
    shape, stopped = entry(name, (2,)), 0
    for L in rng.uniform(0.1, 1.0, 100):
        frame = make_frame(shape, (-1.0,), (L,), (9,))
        p = Particles.empty(1, 1, False)
        p.x[:] = -1.0 + L * (6 + 0.25 * (name == "gimp"))
        p.m[:] = p.V[:] = p.V0[:] = 1.0
        p.v[:] = -L / DT
        rank = Rank(shape, frame, p)
        layer = int(rank.particles.layer[0])
        rank.particles_to_grid()
        rank.update_momentum(DT)
        fault, _, found, *_ = rank.grid_to_particles(DT)
        assert fault in (0, TOO_FAST)
        stopped += fault == TOO_FAST
        assert fault or layer - rank.particles.layer[0] == found <= 1
    assert 0 < stopped < 100
