"""Ownership of layers, at the start and as the load changes, and the window of stored vertices."""

from collections.abc import Callable
from time import perf_counter, thread_time

import numpy as np

from pgimp.decomposition.balance import Balance
from pgimp.decomposition.migrate import pack, unpack
from pgimp.decomposition.slabs import Slab, cut, slab_of
from pgimp.geometry.points.block import Block
from pgimp.kernels.data.frame import MixedExactFrame
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import layers_of, locate
from pgimp.kernels.update.turns import turn_particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction

#: Steps between two re-sorts of the particles' rows, with a report of the load: a sort costs half a
#: step. A step becomes slower by up to a thousandth with every step that the rows grow stale.
RESORT = 48

#: Tag of messages with the particles beyond a seam at the start, and the two beside it.
_SEAM = 13


def partition(
    scene: Scene, comm: Communicator, counts: np.ndarray
) -> tuple[Slab, Balance, list[str]]:
    """Cut the layers into slabs at the start, one a rank, with balanced particle numbers.

    Parameters
    ----------
    counts : (layers,) int64
        Particles of each layer, or of each layer of a ring.

    Returns
    -------
    Slab
        This rank's slab.
    Balance
        The load of the ranks.
    list of str
        Notes for the user.
    """
    vertices, ring = scene.settings.vertices, scene.domain.ring
    ends = scene.ends
    if ring is not None and len(counts) > scene.domain.ring_layers:
        counts = counts[ring : ring + scene.domain.ring_layers]
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
    return slab_of(cuts, comm.rank, ring), balance, notes


def ring_counts(scene: Scene, counts: np.ndarray) -> np.ndarray:
    """Particles of the layers on the grid, those beyond a ring along x in its layers."""
    ring = scene.domain.ring
    if ring is None:
        return counts
    found, end = counts.copy(), ring + scene.domain.ring_layers
    found[ring : 2 * ring] += counts[end : end + ring]
    found[end - ring : end] += counts[:ring]
    found[:ring] = found[end:] = 0
    return found


def create_particles(
    scene: Scene, slab: Slab, comm: Communicator, create: Callable[[Slab], tuple[Particles, int]]
) -> tuple[Particles, int]:
    """Create a slab's particles, those beyond a seam where they belong; collective.

    Parameters
    ----------
    scene, slab, comm
        The scene, this rank's slab, all ranks.
    create : callable
        Returns the particles in the layers of a slab, and their number; collective.
    """
    ring, domain = scene.domain.ring, scene.domain
    wide, count_of = slab, domain.ring_layers
    if ring is not None and slab.layers:  # layers beyond both ends of the grid
        if slab.first == ring:
            wide = wide._replace(first=0, layers=wide.layers + ring)
        if slab.first + slab.layers == ring + count_of:
            wide = wide._replace(layers=wide.layers + ring)
    particles, count = create(wide)
    if not any(domain.periodic):
        return particles, count
    rows = np.arange(count, dtype=np.int32)
    turn_particles(scene.settings.shape, scene.order_frame, domain.exits, particles, rows)
    lower, upper = slab.lower, slab.upper
    if ring is None or slab.layers == 0 or lower == comm.rank:
        return particles, count
    leaving = particles.winding[:count, 0]
    first, last = slab.first == ring, slab.first + slab.layers == ring + count_of
    ends = [(lower, -1)] * first + [(upper, 1)] * last
    sent = [
        comm.isend(pack(particles, np.flatnonzero(leaving == turns)), other, _SEAM - turns)
        for other, turns in ends
    ]
    came = [comm.recv(source=other, tag=_SEAM + turns) for other, turns in ends]
    for each in sent:
        each.wait()
    stay = np.flatnonzero(leaving == 0)
    records = np.concatenate([pack(particles, stay), *came])
    found = Particles.empty(max(1, len(records)), scene.created)
    unpack(records, found, np.arange(len(records)))
    return found, len(records)


def bring_home(
    scene: Scene, slab: Slab, comm: Communicator, particles: Particles, count: int
) -> tuple[Particles, int]:
    """Give particles whose support is of another slab to its rank; collective.

    The deformation of a stress at the start changes the sizes of boxes that follow it. Parts of a
    cell have no size, but are created with others, which have.

    Parameters
    ----------
    scene, slab, comm
        The scene, this rank's slab, all ranks.
    particles, count
        This rank's particles, and their number.
    """
    if not (scene.settings.follows or isinstance(scene.order_frame, MixedExactFrame)):
        return particles, count
    shape, frame, domain = scene.settings.shape, scene.order_frame, scene.domain

    def away(p: Particles, n: int) -> np.ndarray:
        rows = np.arange(n, dtype=np.int32)
        if any(domain.periodic):
            turn_particles(shape, frame, domain.exits, p, rows)
        locate(shape, frame, p, rows, domain.frame.vertices)
        return (p.layer[:n] < slab.first) | (p.layer[:n] >= slab.first + slab.layers)

    gone = away(particles, count)
    strays = comm.allgather(pack(particles, np.flatnonzero(gone)))
    if not sum(map(len, strays)):
        return particles, count
    records = np.concatenate(strays)
    found = Particles.empty(max(1, len(records)), scene.created)
    unpack(records, found, np.arange(len(records)))
    own = np.flatnonzero(~away(found, len(records)))
    records = np.concatenate([pack(particles, np.flatnonzero(~gone)), pack(found, own)])
    found = Particles.empty(max(1, len(records)), scene.created)
    unpack(records, found, np.arange(len(records)))
    return found, len(records)


def slab_predicate(scene: Scene, slab: Slab) -> Callable[[int, Block], np.ndarray]:
    """Return a predicate for particles of a file, given their body: whether a slab has them."""
    shape, frame = scene.settings.shape, scene.order_frame

    def own(body: int, block: Block) -> np.ndarray:
        x = np.ascontiguousarray(block.position[:, 0])
        layers = np.empty(len(x), np.int64)
        if block.saved and scene.settings.follows:  # supports are those of deformed particles
            p = Particles.empty(len(x), scene.created)
            p.x[:], p.F[:], p.V[:], p.body[:] = block.columns["x"], block.columns["F"], 1.0, body
            if p.origin.shape[1]:
                p.origin[:] = block.position
            locate(shape, frame, p, np.arange(len(x), dtype=np.int32), scene.domain.frame.vertices)
            layers[:] = p.layer
        else:
            layers_of(shape, frame, scene.setting.identity, x, layers)
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
