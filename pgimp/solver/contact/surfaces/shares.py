"""What ranks have of the surfaces near others: facets, their cells, and the vertices of these."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.kernels.contact.impulses.reference_grid import NUMBERS
from pgimp.kernels.contact.surfaces.data import SurfaceCells
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.mpi.communicator import Communicator
from pgimp.solver.contact.impulses.messages import swap
from pgimp.solver.contact.surfaces.groups import Groups
from pgimp.solver.contact.surfaces.table import Table
from pgimp.solver.rank_state import RankState


class Near(NamedTuple):
    """Vertices that move facets near other bodies, until the next search."""

    any: bool  #: Whether there are any.
    facets: np.ndarray  #: (n,) int64: All facets of clusters that may meet others.
    cells: SurfaceCells  #: Cells with the vertices' numbers among those below.
    keys: np.ndarray  #: (v,) int64: Keys of the vertices that move these facets.
    records: np.ndarray  #: (o,) int64: Records of those that the rank owns.
    own: np.ndarray  #: (o,) int64: Their numbers.
    every: np.ndarray  #: (v,) int64: Numbers of those of all ranks, one rank after the other.
    counts: np.ndarray  #: (ranks,) int64: How many each rank owns.

    def displacements(self, rank: RankState, root: int) -> np.ndarray | None:
        """Displacements of the vertices, (v, 4), on the root; collective."""
        values = rank.grid.kept.values.reshape(-1, RECORD)
        own = values[self.records, DISPLACEMENT : DISPLACEMENT + 4]
        return self.on_root(rank.comm, root, np.ascontiguousarray(own))

    def on_root(self, comm: Communicator, root: int, values: np.ndarray) -> np.ndarray | None:
        """What all ranks have at their vertices, on the root; collective."""
        found = np.zeros((len(self.keys), *values.shape[1:]), values.dtype)
        if comm.size == 1:
            found[self.own] = values
            return found
        sent, received = np.zeros((2, comm.size), np.int64)
        sent[root] = len(values)
        if comm.rank == root:
            received[:] = self.counts
        arrived = swap(comm, values, sent, received)
        if comm.rank != root:
            return None
        found[self.every] = arrived
        return found


class Share(NamedTuple):
    """What a rank has of the groups of bodies near each other, until the next search."""

    moving: np.ndarray  #: (k,) int64: Its facets near others, and those near them.
    cells: SurfaceCells  #: Cells with the vertices' numbers among those below.
    keys: np.ndarray  #: (v,) int64: Keys of the vertices that move these facets.
    #: records, sent: (o,) int64: Records of its own vertices that any rank needs, by rank; keys.
    records: np.ndarray
    sent: np.ndarray
    counts: np.ndarray  #: (2, ranks) int64: How many of these each rank needs, and it has of each.
    place: np.ndarray  #: (v,) int64: Numbers of those that it gets.
    same: bool  #: Whether these are its own, in their order.

    def gather(
        self, comm: Communicator, u: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What all ranks have at the share's vertices, given that of `sent`; collective.

        These are displacements, (n, 4) float64, and records of reference vertices, in one message.
        """
        if self.same:
            return u, values
        arrived = np.concatenate([u, values.view(np.float64).reshape(-1, NUMBERS)], axis=1)
        if comm.size > 1:
            arrived = swap(comm, arrived, *self.counts)
        found = np.zeros((len(self.keys), arrived.shape[1]))
        found[self.place] = arrived
        n = u.shape[1]
        return found[:, :n].copy(), found[:, n:].copy().view(values.dtype).reshape(-1)


def marked(count: int, parts: list[np.ndarray]) -> np.ndarray:
    """Numbers below `count` that are in any of some arrays, ascending."""
    marks = np.zeros(count, bool)
    for some in parts:
        marks[some] = True
    return np.flatnonzero(marks)


def moving_vertices(table: Table, facets: np.ndarray) -> np.ndarray:
    """Mask of the vertices that move some facets, also in the cells beside theirs."""
    cells = table.cells
    marks, used = np.zeros(len(table.keys), bool), np.zeros(len(cells.low), bool)
    some = table.every.cell[facets]
    used[some[some >= 0]] = True
    for _ in range(cells.corners.shape[1].bit_length() - 2):  # facets may reach into cells beside
        beside = cells.beside[used]
        used[beside[beside >= 0]] = True
    marks[cells.corners[used].reshape(-1)] = True
    marks[cells.column[np.repeat(used, np.diff(cells.start))]] = True
    return marks


def _numbered(cells: SurfaceCells, marks: np.ndarray) -> tuple[np.ndarray, SurfaceCells]:
    """Numbers of vertices among those of a mask, and the cells with these.

    Other cells have vertices of any number: they are not looked at.
    """
    number = np.cumsum(marks) - 1
    return number, cells._replace(corners=number[cells.corners], column=number[cells.column])


def select(comm: Communicator, table: Table, facets: np.ndarray, records: np.ndarray) -> Near:
    """The cells and vertices of facets that may meet others; collective.

    `records` are those of the surface vertices, -1 where another rank has one.
    """
    marks = moving_vertices(table, facets)
    number, mapped = _numbered(table.cells, marks)
    own = np.flatnonzero(marks & (records >= 0))
    every = comm.allgather(number[own])
    return Near(
        len(facets) > 0, facets, mapped, table.keys[marks], records[own], number[own],
        np.concatenate(every), np.array([len(each) for each in every]),
    )  # fmt: skip


def share_of(
    comm: Communicator, table: Table, moving: np.ndarray, groups: Groups, records: np.ndarray
) -> Share:
    """The rank's share of the facets near others, `moving`; collective.

    `records` are those of the surface vertices.
    """
    group = groups.of[table.every.body[moving]]
    joins = group >= 0
    rank = np.where(joins, groups.rank[group], comm.rank)
    used = np.full(len(table.keys), -1)
    for each in range(comm.size):
        some = moving[joins & (rank == each)] if comm.size > 1 else moving
        used[moving_vertices(table, some)] = each
    own = np.flatnonzero((used >= 0) & (records >= 0))
    own = own[np.argsort(used[own], kind="stable")]
    parts = comm.allgather((own, np.bincount(used[own], minlength=comm.size)))
    get, mine = [each[used[each] == comm.rank] for each, _ in parts], moving[rank == comm.rank]
    marks = moving_vertices(table, mine) if comm.size > 1 else used >= 0
    number, mapped = _numbered(table.cells, marks)
    place, keys = number[np.concatenate(get)], table.keys[marks]
    same = comm.size == 1 and np.array_equal(place, np.arange(len(keys)))
    return Share(
        mine, mapped, keys, records[own], table.keys[own],
        np.array([parts[comm.rank][1], [len(each) for each in get]]), place, same,
    )  # fmt: skip
