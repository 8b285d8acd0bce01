"""Rows of a frame: ascending ids, an equal share per rank, for any distribution of particles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from pgimp.errors import RunError
from pgimp.mpi.collective import agree
from pgimp.mpi.communicator import Communicator
from pgimp.storage.framefile import blocks

Array = np.ndarray

_WHAT = "order the particles"
_WRONG = "an id is missing or there twice"


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

    Attributes
    ----------
    count : int
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
    ) -> None:
        self.comm = comm
        self._buffers: tuple[Array, ...] = (np.empty(0, np.uint8), np.empty(0, np.uint8))
        known = bool(((ids >= 0) & (ids < count)).all())
        lengths = comm.allgather(len(ids) if known else -1)
        self.count = sum(lengths)
        if min(lengths) < 0 or self.count > count or (complete and self.count < count):
            raise RunError(f"cannot {_WHAT}: {_WRONG}")
        rows = ids if self.count == count else self._number(ids, count)
        share = _share(self.count, comm.size, unit)
        self.first = min(comm.rank * share, self.count)
        self.last = min(self.first + share, self.count)
        self._exchange = _Exchange(comm, rows, share)
        arrived = self._exchange.forth(rows[self._exchange.order])
        self._source = np.full(self.last - self.first, -1, np.int64)
        self._source[arrived - self.first] = np.arange(len(arrived))
        once = len(arrived) == len(self._source) and bool((self._source >= 0).all())
        agree(comm, _WHAT, None if once else _WRONG)
        self.storage = storage[self._exchange.order if comm.size > 1 else self._source]

    def _number(self, ids: Array, count: int) -> Array:
        """Rows of ids if some are missing: the number of smaller ids."""
        comm, share = self.comm, _share(count, self.comm.size, 1)
        exchange = _Exchange(comm, ids, share)
        arrived = exchange.forth(ids[exchange.order]) - comm.rank * share
        there = np.zeros(share, bool)
        there[arrived] = True
        number = np.cumsum(there)
        agree(comm, _WHAT, None if share == 0 or number[-1] == len(arrived) else _WRONG)
        before = sum(comm.allgather(len(arrived))[: comm.rank])
        rows = np.empty_like(ids)
        rows[exchange.order] = exchange.back(before + number[arrived] - 1)
        return rows

    def collect(
        self, fill: Callable[[int, int], Array], dtype: np.dtype, size: int | None = None
    ) -> Iterator[tuple[int, Array]]:
        """Send values to the ranks of their rows; collective.

        Parameters
        ----------
        fill : callable
            ``fill(begin, end)`` returns the values of this rank's particles in
            ``storage[begin:end]``, one of `dtype` each.
        dtype : dtype
            Type of a particle's values, all together.
        size : int, optional
            Rows of a block.

        Yields
        ------
        int, ndarray
            This rank's rows block by block: number of the first row, and the values.
        """
        if self.comm.size == 1:
            for begin, end in blocks(self.count, size):
                yield begin, fill(begin, end)
            return
        # Reused memory: new pages would cost more than the work.
        lengths = (len(self.storage), self.last - self.first)
        needed = [n * dtype.itemsize for n in lengths]
        if any(len(buffer) < n for buffer, n in zip(self._buffers, needed, strict=True)):
            self._buffers = tuple(np.empty(n * dtype.itemsize, np.uint8) for n in lengths)
        leaving, arrived = (
            buffer[: n * dtype.itemsize].view(dtype)
            for buffer, n in zip(self._buffers, lengths, strict=True)
        )
        for begin, end in blocks(lengths[0]):
            leaving[begin:end] = fill(begin, end)
        self._exchange.forth(leaving, arrived)
        for begin, end in blocks(lengths[1], size):
            yield self.first + begin, np.take(arrived, self._source[begin:end])


def _share(count: int, ranks: int, unit: int) -> int:
    """Number of rows of each rank, in whole units."""
    units = -(-count // unit)
    return -(-units // ranks) * unit


class _Exchange:
    """Exchange of values, one per particle, with the ranks of their rows, and back.

    Parameters
    ----------
    comm : communicator
        Of all ranks.
    rows : ndarray of int64, shape (n,)
        Rows of this rank's particles.
    share : int
        Number of rows of each rank.

    Attributes
    ----------
    order : ndarray of int64 or slice
        Order in which values are sent: by rank, else unchanged.
    """

    def __init__(self, comm: Communicator, rows: Array, share: int) -> None:
        self.order: Any = slice(None)
        self._comm = comm
        if comm.size == 1:
            return
        owner = rows // max(share, 1)
        self._sent = np.bincount(owner, minlength=comm.size)
        # NumPy sorts short integers in a time proportional to their number.
        self.order = np.argsort(
            owner.astype(np.uint16 if comm.size < 1 << 16 else int), kind="stable"
        )
        self._received = np.empty_like(self._sent)
        comm.Alltoall(self._sent, self._received)

    def forth(self, values: Array, arrived: Array | None = None) -> Array:
        """Send values, (n,) in `order`; return the received values, in the order of the ranks."""
        if self._comm.size == 1:
            return values
        if arrived is None:
            arrived = np.empty(int(self._received.sum()), values.dtype)
        self._move(values, self._sent, arrived, self._received)
        return arrived

    def back(self, values: Array) -> Array:
        """Send values, (n,) in the order received, back to their ranks."""
        if self._comm.size == 1:
            return values
        returned = np.empty(int(self._sent.sum()), values.dtype)
        self._move(values, self._received, returned, self._sent)
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
