"""A rank's place in the decomposition, and how it changes while a simulation goes on."""

from collections.abc import Callable
from time import perf_counter, thread_time
from typing import TYPE_CHECKING

import numpy as np

from pgimp.decomposition.balance import Balance
from pgimp.decomposition.grid import LATE, Grid
from pgimp.decomposition.halo import Halo
from pgimp.decomposition.handover import hand_over
from pgimp.decomposition.migrate import Migration
from pgimp.decomposition.slabs import cut, slab_of
from pgimp.kernels.order import layers_of
from pgimp.solver.state import ACCUMULATORS, no_sums

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation


def share_out(sim: "Simulation", counts: np.ndarray, interval: int) -> None:
    """Give each rank its layers at the start, so that none has more particles than need be.

    Parameters
    ----------
    counts : (layers,) int64
        Particles of each layer.
    interval : int
        Steps between two reports of the load.
    """
    vertices = sim.scene.vertices
    # A vertex beyond a face and its mirror image must not lie on different ranks.
    ends = 2 * vertices if sim.scene.mirrors else 0
    cuts = cut(counts, sim.comm.size, vertices - 1, ends)
    sim.slab = slab_of(cuts, sim.comm.rank)
    sim.balance = Balance(cuts, int(counts.sum()), vertices, ends, interval)
    idle = sim.comm.size - (len(cuts) - 1)
    if idle:
        each = vertices - 1
        outer = f", {ends} next to a wall that mirrors" if ends > each else ""
        sim.notes.append(
            f"{idle} of {sim.comm.size} ranks own no layer: the grid's {cuts[-1]} layers feed "
            f"at most {len(cuts) - 1} ranks ({each} layers each{outer}); use fewer ranks"
        )


def owned(sim: "Simulation") -> Callable[[np.ndarray], np.ndarray]:
    """Tell which undeformed particles are this rank's, by their coordinates along x."""
    scene, slab = sim.scene, sim.slab

    def own(x: np.ndarray) -> np.ndarray:
        layers = np.empty(len(x), np.int64)
        layers_of(scene.shape, scene.frame, sim.identity, x, layers)
        return (slab.first <= layers) & (layers < slab.first + slab.layers)

    return own


def occupy(sim: "Simulation") -> None:
    """Make grid, halo and sums by plane for the rank's layers; the window is still to be set."""
    scene, slab = sim.scene, sim.slab
    shared = scene.vertices - 1
    sim.grid = Grid(scene.frame, scene.vertices, slab, LATE if sim.comm.size > 1 else 0)
    sim.halo = Halo(sim.comm, slab, shared)
    sim.migration = Migration(sim.comm, slab, sim.particles)
    sim.owned_planes = slab.layers if slab.above is not None else sim.grid.planes
    sums = no_sums(scene, sim.grid.planes)
    sim.work, sim.impulse, sim.beyond, sim.grip_impulse, sim.escaped = sums


def rebalance(sim: "Simulation") -> None:
    """Let rank 0 decide where slab boundaries should be, and move them; collective."""
    begin, comm, balance = perf_counter(), sim.comm, sim.balance
    counts = comm.gather(np.diff(sim.population.start))
    cuts = None if counts is None else balance.decide(np.concatenate(counts), sim.step)
    cuts, balance.pause, balance.price = comm.bcast((cuts, balance.pause, balance.price))
    if cuts is not None:
        # Not by the clock: what others make of a shared core is no part of a move.
        agreed = thread_time()
        move_boundaries(sim, cuts)
        balance.moved(thread_time() - agreed, sim.step)
    balance.watch(sim.local_count)
    sim.timings["balance"] += perf_counter() - begin


def move_boundaries(sim: "Simulation", cuts: list[int]) -> None:
    """Go over to another decomposition between two steps; collective.

    No bit of what follows depends on it.

    Parameters
    ----------
    cuts : list of int
        As from `pgimp.decomposition.slabs.cut`, the same on every rank.
    """
    own, window = sim.owned_planes, sim.grid.base
    sums = [getattr(sim, name)[:own] for name in ACCUMULATORS]
    extra = sim.scene.vertices - 1
    sums = hand_over(sim.comm, sim.balance.cuts, cuts, extra, sim.population, sums)
    sim.balance.cuts, sim.slab = cuts, slab_of(cuts, sim.comm.rank)
    occupy(sim)
    sim.grid.store(window)
    for name, values in zip(ACCUMULATORS, sums, strict=True):
        getattr(sim, name)[: sim.owned_planes] = values
