"""What `grid_to_particles` makes of particles that must not go on, and of those that may leave."""

import numpy as np
import pytest
from kernel_driver import SEED, Rank, entry, make_frame, random_particles, random_positions

from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import OUTFLOW, Particles
from pgimp.kernels.step.checks import INVERTED, NOT_FINITE, OUTSIDE, TOO_FAST
from pgimp.physics.shapes import SHAPES

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
def test_a_particle_at_fault_is_found_in_the_same_step(name, field, axis, value, reason):
    rank = still_particles(name)
    if field:
        getattr(rank.up_to_date(), field)[:, axis] = value
    rank.particles_to_grid()
    rank.update_momentum(DT)
    error, row, *_ = rank.grid_to_particles(DT)
    assert error == reason
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
        p = Particles.empty(1, Carried(1))
        p.x[:] = -1.0 + L * (6 + 0.25 * (name == "gimp"))
        p.m[:] = p.V[:] = p.V0[:] = 1.0
        p.v[:] = -L / DT
        rank = Rank(shape, frame, p)
        layer = int(rank.up_to_date().layer[0])
        rank.particles_to_grid()
        rank.update_momentum(DT)
        error, _, found, *_ = rank.grid_to_particles(DT)
        assert error in (0, TOO_FAST)
        stopped += error == TOO_FAST
        assert error or layer - rank.up_to_date().layer[0] == found <= 1
    assert 0 < stopped < 100


def stepped(rank):
    rank.particles_to_grid()
    rank.update_momentum(DT)
    return rank.grid_to_particles(DT)


def test_errors_are_listed_in_canonical_order_while_the_others_go_on():
    """F of one particle reaches no other in the same step; what does not fit is counted."""
    sound, rank = still_particles("gimp"), still_particles("gimp")
    for each in (sound, rank):
        each.up_to_date().v[:] = np.random.default_rng(1).normal(size=each.up_to_date().v.shape)
    order = rank.population.order
    bad = {int(order[i]): kind for i, kind in ((1, INVERTED), (4, NOT_FINITE), (6, INVERTED))}
    for row, kind in bad.items():
        rank.up_to_date().F[row, 0] = np.nan if kind == NOT_FINITE else -9.0
    layers = rank.up_to_date().layer.copy()
    stepped(sound)
    assert sound.failed == 0 and stepped(rank)[:2] == (INVERTED, next(iter(bad)))
    assert rank.errors.tolist() == [[row, kind] for row, kind in bad.items()]
    assert (rank.up_to_date().layer[list(bad)] == layers[list(bad)]).all()
    others = np.setdiff1d(order, list(bad))
    for mine, theirs in zip(rank.up_to_date(), sound.up_to_date(), strict=True):
        assert mine[others].tobytes() == theirs[others].tobytes()

    rank = still_particles("gimp")
    rank.up_to_date().F[list(bad), 0] = -9.0
    rank.capacity = 2
    stepped(rank)
    assert rank.failed == 3 and rank.errors[:, 0].tolist() == list(bad)[:2]


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_no_place_that_is_none_becomes_a_number(value):
    """Particles flung away change neither layers nor window, whatever their positions."""
    rank = still_particles("gimp")
    rank.up_to_date().v[:] = value
    layers = rank.up_to_date().layer.copy()
    _, _, found, *_ = stepped(rank)
    assert rank.failed == len(rank.population.order) and found == rank.outflow == 0
    assert (rank.up_to_date().layer == layers).all() and (
        rank.vertex_bounds == rank.grid.base
    ).all()


@pytest.mark.parametrize("name", ["mpm", "finite-gimp"])
@pytest.mark.parametrize(
    ("exits", "directions", "reason"),
    [
        (("x-max",), (1, 0, 0), OUTFLOW),
        (("x-min", "y-max", "z-max"), (1, 0, 0), OUTSIDE),
        (("y-min", "z-min"), (0, -1, 0), OUTFLOW),
        (("y-min", "z-max"), (0, -1, 1), OUTFLOW),
        (("y-min", "x-max"), (0, -1, 1), OUTSIDE),
        (("z-max",), (0, -1, 1), OUTSIDE),
        (("x-max", "y-max", "z-max"), (1, 1, 1), OUTFLOW),
        (("x-max",), (2.5, 0, 0), TOO_FAST),
    ],
)
def test_particles_leave_through_faces_that_let_them_go(name, exits, directions, reason):
    """One that leaves keeps its state, is listed as changed, and has no layer any more."""
    shape = entry(name, (2, 1, 3))
    p = Particles.empty(1, Carried(3))
    p.m[:] = p.V[:] = p.V0[:] = 1.0
    for d, side in enumerate(directions):
        place = {-1: 0.3, 0: CELLS[d] / 2, 1: CELLS[d] - 0.3}[int(np.sign(side))]
        p.x[0, d] = ORIGIN[d] + CELL[d] * place
        p.v[0, d] = 0.41 * side * CELL[d] / DT
    rank = Rank(shape, make_frame(shape, ORIGIN, CELL, CELLS), p)
    rank.exits = sum(1 << (2 * "xyz".index(face[0]) + (face[2:] == "max")) for face in exits)
    error, _, found, *_ = stepped(rank)
    if reason == OUTFLOW:
        assert (rank.failed, rank.outflow, found) == (0, 1, 1)
        assert rank.up_to_date().layer[0] == OUTFLOW and rank.population.changed[0] == 0
        np.testing.assert_allclose(rank.up_to_date().v[0], 0.41 * np.array(directions) * CELL / DT)
    else:
        assert error == reason and rank.outflow == found == 0
