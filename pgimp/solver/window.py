"""The window of the grid that all ranks store: made, and made smaller, for where particles are."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation


def open_window(sim: "Simulation") -> None:
    """Make the window for the particles of all ranks; collective."""
    sim.reach = np.zeros((2, 2), np.int64)
    _cover(sim, _reach_of_all(sim))


def shrink_window(sim: "Simulation") -> None:
    """Make it anew if it has become far too wide; collective, when nothing is to be agreed on."""
    reach = _reach_of_all(sim)
    needed = np.prod(np.maximum(reach[1] - reach[0], 0) + 4.0)
    stored = np.prod(sim.grid.base[1] - sim.grid.base[0] + 1.0)
    if stored > 2.0 * needed + 64.0:
        _cover(sim, reach)


def _cover(sim: "Simulation", reach: np.ndarray) -> None:
    sim.grid.cover(reach)
    sim.reach[:] = sim.agreement.reach[:] = sim.grid.known


def _reach_of_all(sim: "Simulation") -> np.ndarray:
    """Least and greatest first vertices of all ranks; 0 where there are no particles."""
    reach = sim.population.reach()
    if sim.comm.size > 1:
        every = np.array(sim.comm.allgather(reach))
        reach = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
    return np.where(reach[0] > reach[1], 0, reach)
