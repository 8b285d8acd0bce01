"""Convected particle domains in full: equal to ends where boxes stay along the grid, and clamped.

That kernels do as `reference.py` says is in test_transfer.py.
"""

import numpy as np
import pytest
from kernel_driver import SEED, Rank, entry, make_frame, random_particles, random_positions
from reference import Reference
from transfer_setting import CELL, CELLS, ORIGIN, close, copied


def stretched(name, D, diagonal, seed=SEED):
    """A rank and the reference with particles up to six times as long as at the start."""
    rng = np.random.default_rng(seed)
    shape = entry(name, (2,) * D)
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], CELLS[:D])
    p = random_particles(rng, random_positions(rng, frame, 30))
    F = np.zeros((30, D, D)) if diagonal else rng.uniform(-2.0, 2.0, (30, D, D))
    F[:, range(D), range(D)] = rng.uniform(0.1, 6.0, (30, D))
    p.F[:] = F.reshape(30, -1)
    return Rank(shape, frame, p), Reference(name, (2,) * D, frame)


@pytest.mark.parametrize("D", [2, 3])
def test_with_a_diagonal_gradient_they_are_those_of_ends(D):
    """Also beyond the clamp; the layers are the same as well."""
    one, _ = stretched("cpdi-corners", D, True)
    other, _ = stretched("cpdi", D, True)
    for rank in (one, other):
        rank.particles_to_grid()
    assert (one.up_to_date().F.reshape(-1, D, D)[:, 0, 0] > 4.1).sum() > 5  # clamped
    assert close(one.records(), other.records())


@pytest.mark.parametrize("D", [2, 3])
def test_what_outgrows_its_support_is_shrunk(D):
    """Sheared far beyond the clamp: sums as in plain NumPy, mass and centre kept."""
    rank, reference = stretched("cpdi-corners", D, False)
    rank.particles_to_grid()
    p = copied(rank)
    reference.particles_to_grid(p)
    G = rank.records()
    assert close(G[..., 0], reference.m)
    assert close(G[..., 1 : 1 + D], reference.p)
    assert close(G[..., 5 : 5 + D], reference.f)
    assert sum(reference.half_widths(F)[1] for F in p.F) > 10
    assert close(reference.m.sum(), p.m.sum())
    for d, along in enumerate(reference.vertices):
        moment = np.moveaxis(reference.m, d, -1) @ along
        assert close(moment.sum(), p.m @ p.x[:, d])


@pytest.mark.parametrize("D", [2, 3])
def test_neighbours_share_their_corners(D):
    """A lattice under one F, sheared and turned, and one stress: inside it there is no force.

    The boxes of `cpdi`, along the grid, overlap here and leave gaps there.
    """
    F = np.array([[1.1, 0.4, 0.1], [-0.5, 0.9, 0.2], [0.0, -0.1, 1.0]])[:D, :D]
    cells = (12,) * D
    lattice = np.stack(np.meshgrid(*[np.arange(-24, 25)] * D, indexing="ij"), -1).reshape(-1, D)
    x = np.array(ORIGIN[:D]) + (6.03 + 0.5 * lattice @ F.T) * CELL[0]
    x = x[((x > ORIGIN[:D]) & (x < np.array(ORIGIN[:D]) + 12.0 * CELL[0])).all(axis=1)]
    force = {}
    for name in ("cpdi-corners", "cpdi"):
        shape = entry(name, (2,) * D)
        frame = make_frame(shape, ORIGIN[:D], CELL[:1] * D, cells)
        p = random_particles(np.random.default_rng(SEED), x)
        p.F[:], p.V[:] = F.ravel(), 1.0
        p.sigma[:] = p.sigma[0]
        rank = Rank(shape, frame, p)
        rank.particles_to_grid()
        inside = slice(frame.ghost + 3, frame.ghost + 10)
        f = rank.records()[..., 5 : 5 + D]
        force[name] = np.abs(f[(inside,) * D]).max() / np.abs(f).max()
    assert force["cpdi-corners"] < 1e-13 < 1e-3 < force["cpdi"]
