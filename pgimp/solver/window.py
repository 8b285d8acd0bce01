"""The window of the grid that all ranks store, fitted to the particles."""

import numpy as np

from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction


def open_window(rank: Rank, reduction: StepReduction) -> None:
    """Make the window for the particles of all ranks; collective."""
    _cover(rank, reduction, _bounds_of_all(rank))


def shrink_window(rank: Rank, reduction: StepReduction) -> None:
    """Reallocate it if it is far too wide; collective, between reductions.

    In the initial configuration it is as narrow as possible from the start.
    """
    if rank.scene.settings.initial:
        return
    bounds = _bounds_of_all(rank)
    for d, joined in enumerate(rank.scene.domain.periodic[1:]):
        if joined:
            bounds[:, d] = rank.grid.base[:, d]
    needed = np.prod(np.maximum(bounds[1] - bounds[0], 0) + 4.0)
    stored = np.prod(rank.grid.base[1] - rank.grid.base[0] + 1.0)
    if stored > 2.0 * needed + 64.0:
        _cover(rank, reduction, bounds)


def _cover(rank: Rank, reduction: StepReduction, bounds: np.ndarray) -> None:
    if rank.scene.settings.initial:
        rank.grid.store(bounds)
    else:
        rank.grid.cover(bounds)
    rank.vertex_bounds[:] = reduction.vertex_bounds[:] = rank.grid.inner_bounds


def _bounds_of_all(rank: Rank) -> np.ndarray:
    """Least and greatest first vertices of all ranks; 0 without particles."""
    bounds = rank.population.vertex_bounds()
    if rank.comm.size > 1:
        every = np.array(rank.comm.allgather(bounds))
        bounds = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
    return np.where(bounds[0] > bounds[1], 0, bounds)
