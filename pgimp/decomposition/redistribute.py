"""Redistribution of layers: particles, and sums by plane, move to their new ranks."""

from collections.abc import Sequence
from math import prod

import numpy as np

from pgimp.decomposition.migrate import pack, unpack
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab, common, slab_of
from pgimp.mpi.communicator import Communicator

_TAG = 5

#: Numbers in a message: short, to avoid a second copy of all migrating data.
_PIECE = 2**19

_NONE = np.empty(0, np.int32)


def redistribute(
    comm: Communicator,
    old: list[int],
    new: list[int],
    extra: int,
    population: Population,
    sums: Sequence[np.ndarray],
    ring: int | None = None,
) -> list[np.ndarray]:
    """Change the decomposition between two steps; collective.

    Particles keep their layers and cells, and with these the canonical order, so that no bit of
    the results can change. Arrivals reuse the rows of departed particles: no rank holds more than
    its old and its new share.

    Parameters
    ----------
    old, new : list of int
        Results of `cut`, equal on every rank.
    extra : int
        Planes above the grid's last layer, which belong to the last rank with layers.
    population : Population
        This rank's particles; changed.
    sums : sequence of arrays (planes, ...) float64
        For the planes that this rank owns in the old decomposition.
    ring : int, optional
        See `slab_of`; there are no extra planes then.

    Returns
    -------
    list of arrays (planes, ...) float64
        For the planes that it owns in the new one.
    """
    rank = comm.rank
    before, after = slab_of(old, rank, ring), slab_of(new, rank, ring)
    had, gets = _planes(old, extra, rank, ring), _planes(new, extra, rank, ring)
    start, order, layers = population.start, population.order, before.layers
    columns = population.up_to_date().width
    each = max(1, _PIECE // columns)
    shapes = [part.shape[1:] for part in sums]

    # A plane's particles and sums, in one record.
    counts = np.zeros((had.layers, 1))
    counts[:layers, 0] = np.diff(start)
    flat = [part.reshape(had.layers, prod(shape)) for part, shape in zip(sums, shapes, strict=True)]
    planes = np.concatenate([counts, *flat], axis=1)
    new_planes = np.empty((gets.layers, planes.shape[1]))

    def span(slab: Slab, a: Slab, b: Slab) -> slice:
        first, end = common(a, b)
        return slice(first - slab.first, end - slab.first)

    def rows_of(owner: Slab) -> np.ndarray:
        rows = span(before, before, owner)
        return order[start[rows.start] : start[rows.stop]] if rows.stop > rows.start else _NONE

    new_planes[span(gets, had, gets)] = planes[span(had, had, gets)]
    rows = {rank: [rows_of(after)]}
    # One distance of ranks after the other, so that no ranks wait for each other in a circle. At
    # most one message is on its way out and one on its way in.
    for distance in _distances(old, new, extra):
        to, source = rank + distance, rank - distance
        going = planes[span(had, had, _planes(new, extra, to, ring))]
        coming = new_planes[span(gets, gets, _planes(old, extra, source, ring))]
        leaving = rows_of(_planes(new, 0, to, ring))
        request = comm.Isend(np.ascontiguousarray(going), to, _TAG) if len(going) else None
        if len(coming):
            comm.Recv(coming, source, _TAG)
        if request:
            request.Wait()
        number = int(coming[:, 0].sum())
        rows[source] = []
        for done in range(0, max(len(leaving), number), each):
            request, piece = None, leaving[done : done + each]
            if len(piece):
                message = pack(population.up_to_date(), piece)
                request = comm.Isend(message, to, _TAG)
                population.free(piece)
            if done < number:
                records = np.empty((min(each, number - done), columns), np.int64)
                comm.Recv(records, source, _TAG)
                rows[source].append(population.insert(len(records)))
                unpack(records, population.up_to_date(), rows[source][-1])
            if request:
                request.Wait()

    order = np.concatenate([part for source in sorted(rows) for part in rows[source]])
    start = np.concatenate([[0], np.cumsum(new_planes[: after.layers, 0])]).astype(np.int64)
    population.set_layers(after, order, start)
    edges = np.cumsum([1, *map(prod, shapes)])
    parts = np.split(new_planes, edges[:-1], axis=1)[1:]
    return [part.reshape(len(part), *shape) for part, shape in zip(parts, shapes, strict=True)]


def _planes(cuts: list[int], extra: int, rank: int, ring: int | None) -> Slab:
    """Planes that a rank owns; none for a number without a rank."""
    if not 0 <= rank < len(cuts) - 1:
        return Slab((ring or 0) + cuts[-1] + extra, 0, None, None)
    return slab_of([*cuts[:-1], cuts[-1] + extra], rank, ring)


def _distances(old: list[int], new: list[int], extra: int) -> list[int]:
    """Distances in ranks over which planes move; equal on every rank."""
    found = set()
    for rank in range(len(old) - 1):
        first, end = old[rank], old[rank + 1] + extra * (rank == len(old) - 2)
        lowest = int(np.searchsorted(new[1:-1], first, side="right"))
        highest = int(np.searchsorted(new[1:-1], end - 1, side="right"))
        found |= set(range(lowest - rank, highest - rank + 1))
    return sorted(found - {0})
