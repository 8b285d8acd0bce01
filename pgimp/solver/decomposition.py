"""Ownership of layers: at the start, and as the load changes in the course of a simulation."""

from collections.abc import Callable
from time import perf_counter, thread_time

import numpy as np

from pgimp.decomposition.balance import Balance
from pgimp.decomposition.slabs import Slab, cut, slab_of
from pgimp.kernels.order.order import layers_of
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.window import shrink_window

#: Steps between two re-sorts of the particles' rows, with a report of the load: a sort costs half a
#: step. A step becomes slower by up to a thousandth with every step that the rows grow stale.
RESORT = 48


def partition(
    scene: Scene, comm: Communicator, counts: np.ndarray
) -> tuple[Slab, Balance, list[str]]:
    """Cut the layers into slabs at the start, one a rank, with balanced particle numbers.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.
    counts : (layers,) int64
        Particles of each layer.

    Returns
    -------
    Slab
        This rank's slab.
    Balance
        The load of the ranks.
    list of str
        Notes for the user.
    """
    vertices = scene.settings.vertices
    ends = scene.ends
    cuts = cut(counts, comm.size, vertices - 1, ends)
    notes = []
    if idle := comm.size - (len(cuts) - 1):
        each = vertices - 1
        outer = f", {ends} next to a wall that mirrors or lets go" if ends > each else ""
        notes.append(
            f"{idle} of {comm.size} ranks own no layer: the grid's {cuts[-1]} layers feed "
            f"at most {len(cuts) - 1} ranks ({each} layers each{outer}); use fewer ranks"
        )
    balance = Balance(cuts, int(counts.sum()), vertices, ends, RESORT)
    return slab_of(cuts, comm.rank), balance, notes


def slab_predicate(scene: Scene, slab: Slab) -> Callable[[np.ndarray], np.ndarray]:
    """Return a predicate for the undeformed particles of a slab, by their coordinates along x."""

    def own(x: np.ndarray) -> np.ndarray:
        layers = np.empty(len(x), np.int64)
        layers_of(scene.settings.shape, scene.placing, scene.setting.identity, x, layers)
        return (slab.first <= layers) & (layers < slab.first + slab.layers)

    return own


def rebalance(rank: Rank, balance: Balance, step: int) -> None:
    """Move slab boundaries as decided by rank 0; collective."""
    begin, comm = perf_counter(), rank.comm
    counts = comm.gather(np.diff(rank.population.start))
    cuts = None if counts is None else balance.decide(np.concatenate(counts), step)
    cuts, balance.pause, balance.move_cost = comm.bcast((cuts, balance.pause, balance.move_cost))
    if cuts is not None:
        # CPU time, not wall time: other processes on a shared core do not count.
        agreed = thread_time()
        rank.move(balance.cuts, cuts)
        balance.cuts = cuts
        balance.moved(thread_time() - agreed, step)
    balance.watch(rank.count)
    rank.timings["balance"] += perf_counter() - begin


def resort(rank: Rank, balance: Balance, reduction: StepReduction, step: int) -> None:
    """Sort the rows, report the load, and shrink a window that is far too wide; collective."""
    begin = perf_counter()
    if not rank.scene.settings.initial or rank.moved:
        rank.sort()
    rank.timings["sort"] += perf_counter() - begin
    if rank.comm.size > 1:
        balance.report(rank.comm, rank.count, int(rank.grid.active.sum()), step)
    shrink_window(rank, reduction)
