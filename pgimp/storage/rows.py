"""Rows of a frame: ascending ids, an equal share per rank, for any distribution of particles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from pgimp.errors import RunError
from pgimp.mpi.collective import agree
from pgimp.mpi.communicator import Communicator
from pgimp.storage.framefile import blocks

Array = np.ndarray

_WHAT = "order the particles"
_WRONG = "an id is missing or there twice"
# Rows of each rank in a round of messages; whole chunks of compressed files.
_ROUND = 1 << 16


class Rows:
    """Rows written by this rank, and the permutation that brings their values here.

    Each rank takes an equal number of rows, the last ranks the remainder. The permutation is
    computed once a frame, in a time proportional to the number of particles. Ids serve as
    addresses, so nothing is sorted.

    Parameters
    ----------
    comm : communicator
        Of all ranks; creation is collective.
    ids : ndarray of int64, shape (n,)
        Ids of this rank's particles; over all ranks each of 0 to N-1 once, or at most once.
    storage : ndarray of int64, shape (n,)
        Storage rows of these particles.
    count : int
        N, the number of ids.
    complete : bool
        Whether all ids must exist.
    unit : int
        The rows of a rank begin at a multiple of this number.
    rounds : bool
        Whether messages go in rounds, each with a run of rows: slower, in little memory.

    Attributes
    ----------
    short : bool
        Whether values are few at a time, so that those of all fields may be found together.
    count
        Number of rows of all ranks.
    first, last : int
        This rank has the rows from `first` to `last` (exclusive).
    storage : ndarray of int64, shape (n,)
        Storage rows in the order in which `collect` requests values.

    Raises
    ------
    RunError
        On every rank, if an id occurs twice, or is missing although `complete`.
    """

    def __init__(
        self,
        comm: Communicator,
        ids: Array,
        storage: Array,
        count: int,
        complete: bool = True,
        unit: int = 1,
        rounds: bool = False,
    ) -> None:
        self.comm = comm
        self._buffers: tuple[list[Array], list[Array]] = ([], [])
        known = bool(((ids >= 0) & (ids < count)).all())
        lengths = comm.allgather(len(ids) if known else -1)
        self.count = sum(lengths)
        if min(lengths) < 0 or self.count > count or (complete and self.count < count):
            raise RunError(f"cannot {_WHAT}: {_WRONG}")
        rows = ids if self.count == count else self._number(ids, count)
        share = _share(self.count, comm.size, unit)
        self.first = min(comm.rank * share, self.count)
        self.last = min(self.first + share, self.count)
        self.short = rounds or comm.size == 1
        self._exchange = _Exchange(comm, rows, share, _ROUND if rounds else share)
        arrived = self._exchange.forth(rows[self._exchange.order])
        self._source = np.full(self.last - self.first, -1, np.int64)
        self._source[arrived - self.first] = np.arange(len(arrived))
        once = len(arrived) == len(self._source) and bool((self._source >= 0).all())
        agree(comm, _WHAT, None if once else _WRONG)
        self.storage = storage[self._exchange.order if comm.size > 1 else self._source]

    def _number(self, ids: Array, count: int) -> Array:
        """Rows of ids if some are missing: the number of smaller ids."""
        comm, share = self.comm, _share(count, self.comm.size, 1)
        exchange = _Exchange(comm, ids, share, share)
        arrived = exchange.forth(ids[exchange.order]) - comm.rank * share
        there = np.zeros(share, bool)
        there[arrived] = True
        number = np.cumsum(there)
        agree(comm, _WHAT, None if share == 0 or number[-1] == len(arrived) else _WRONG)
        before = sum(comm.allgather(len(arrived))[: comm.rank])
        rows = np.empty_like(ids)
        rows[exchange.order] = exchange.back(before + number[arrived] - 1)
        return rows

    def _room(self, types: Sequence[np.dtype]) -> tuple[list[Array], list[Array]]:
        """Bytes for the values of each type that leave and arrive; used again by later calls.

        New pages would cost more than the work.
        """
        for buffers, most in zip(self._buffers, self._exchange.most, strict=True):
            buffers += [np.empty(0, np.uint8)] * (len(types) - len(buffers))
            for i, each in enumerate(types):
                if len(buffers[i]) < most * each.itemsize:
                    buffers[i] = np.empty(most * each.itemsize, np.uint8)
        leaving, arrived = (buffers[: len(types)] for buffers in self._buffers)
        return leaving, arrived

    def collect(
        self,
        fill: Callable[[int, int], Sequence[Array]],
        types: Sequence[np.dtype],
        size: int | None = None,
    ) -> Iterator[tuple[int, Sequence[Array]]]:
        """Send values to the ranks of their rows; collective.

        Parameters
        ----------
        fill : callable
            ``fill(begin, end)`` returns the values of this rank's particles in
            ``storage[begin:end]``: an array of each of the `types`.
        types : sequence of dtype
            Types of a particle's values: those of a type go in the same messages.
        size : int, optional
            Rows of a block.

        Yields
        ------
        int, sequence of ndarray
            This rank's rows block by block: number of the first row, and the values.
        """
        if self.comm.size == 1:
            for begin, end in blocks(self.count, size):
                yield begin, fill(begin, end)
            return
        most = self._exchange.most
        leaving, arrived = (
            [
                buffers[: n * each.itemsize].view(each)
                for each, buffers in zip(types, found, strict=True)
            ]
            for n, found in zip(most, self._room(types), strict=True)
        )
        for number, (out, into) in enumerate(self._exchange.spans):
            for begin, end in blocks(out.stop - out.start):
                values = fill(out.start + begin, out.start + end)
                for to, some in zip(leaving, values, strict=True):
                    to[begin:end] = some
            for sent, received in zip(leaving, arrived, strict=True):
                self._exchange.move(number, sent, received)
            for begin, end in blocks(into.stop - into.start, size):
                source = self._source[into.start + begin : into.start + end] - into.start
                yield self.first + into.start + begin, [np.take(each, source) for each in arrived]


def _share(count: int, ranks: int, unit: int) -> int:
    """Number of rows of each rank, in whole units."""
    units = -(-count // unit)
    return -(-units // ranks) * unit


class _Exchange:
    """Exchange of values, one per particle, with the ranks of their rows, and back.

    It goes in rounds, each with a run of rows of each rank, so that messages stay short.

    Parameters
    ----------
    rows : ndarray of int64, shape (n,)
        Rows of this rank's particles.
    share : int
        Number of rows of each rank.
    length : int
        Rows of each rank in a round.

    Attributes
    ----------
    order : ndarray of int64 or slice
        Order in which values are sent: by round, then by rank, else unchanged.
    spans : list of (slice, slice)
        For each round the values sent, and those received.
    most : (int, int)
        Most values sent, and received, in a round.
    """

    def __init__(self, comm: Communicator, rows: Array, share: int, length: int) -> None:
        self.order: Any = slice(None)
        self._comm = comm
        if comm.size == 1:
            return
        owner, rounds = rows // max(share, 1), max(1, -(-share // max(length, 1)))
        key = (rows - owner * share) // max(length, 1) * comm.size + owner
        self._sent = np.bincount(key, minlength=rounds * comm.size).reshape(rounds, comm.size)
        # NumPy sorts short integers in a time proportional to their number.
        short = self._sent.size < 1 << 16
        self.order = np.argsort(key.astype(np.uint16 if short else int), kind="stable")
        found = np.empty((comm.size, rounds), self._sent.dtype)
        comm.Alltoall(np.ascontiguousarray(self._sent.T), found)
        self._received = np.ascontiguousarray(found.T)
        edges = [
            np.concatenate([[0], np.cumsum(counts.sum(axis=1))]).tolist()
            for counts in (self._sent, self._received)
        ]
        self.spans = [
            (slice(edges[0][n], edges[0][n + 1]), slice(edges[1][n], edges[1][n + 1]))
            for n in range(rounds)
        ]
        self.most = tuple(int(each.sum(axis=1).max()) for each in (self._sent, self._received))

    def forth(self, values: Array) -> Array:
        """Send values, (n,) in `order`; return those received, by round and in order of ranks."""
        if self._comm.size == 1:
            return values
        arrived = np.empty(int(self._received.sum()), values.dtype)
        for number, (out, into) in enumerate(self.spans):
            self.move(number, values[out], arrived[into])
        return arrived

    def move(self, number: int, values: Array, arrived: Array) -> None:
        """Send and receive the values of a round, at the beginning of the arrays."""
        self._move(values, self._sent[number], arrived, self._received[number])

    def back(self, values: Array) -> Array:
        """Send values, (n,) in the order received in one round, back to their ranks."""
        if self._comm.size == 1:
            return values
        returned = np.empty(int(self._sent.sum()), values.dtype)
        self._move(values, self._received[0], returned, self._sent[0])
        return returned

    def _move(self, values: Array, sent: Array, arrived: Array, received: Array) -> None:
        from mpi4py import MPI

        # Counting in rows keeps the counts below MPI's limit of 2^31.
        row = MPI.BYTE.Create_contiguous(values.dtype.itemsize)
        row.Commit()
        self._comm.Alltoallv(
            [values.view(np.uint8), sent, row], [arrived.view(np.uint8), received, row]
        )
        row.Free()
