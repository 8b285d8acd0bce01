"""The rows of a frame: ascending ids, an equal share a rank, however the particles are spread."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.output.collective import agree

Array = np.ndarray


class Rows:
    """The rows that this rank writes, and the permutation that brings their values here.

    Rank r of P takes the ids from r N/P to (r+1) N/P. The permutation is found once a frame; then
    each field is moved on its own, so that no more than one is in memory.

    Parameters
    ----------
    comm : communicator
        Of all ranks; creation is collective.
    ids : ndarray of int64, shape (n,)
        Numbers of this rank's particles; over all ranks each of 0 to N-1 once, or at most once.
    storage : ndarray of int64, shape (n,)
        Where those particles are stored.
    count : int
        N, the number of ids.
    complete : bool
        Whether no id may be missing.

    Attributes
    ----------
    count : int
        Number of rows of all ranks.
    bounds : list of int
        Where each rank's rows start, and `count`.
    first, last : int
        This rank has the rows from `first` up to but not including `last`.
    storage : ndarray of int64, shape (n,)
        As given, in ascending id: the order in which `collect` takes values.

    Raises
    ------
    RunError
        On every rank, if an id is twice there, or missing where it must not.
    """

    def __init__(
        self, comm: Any, ids: Array, storage: Array, count: int, complete: bool = True
    ) -> None:
        self.comm = comm
        shares = [rank * count // comm.size for rank in range(comm.size + 1)]
        order = np.argsort(ids, kind="stable")
        self.storage = storage[order]
        self._sent = np.diff(np.searchsorted(ids[order], shares))
        self._received = self._sent
        if comm.size > 1:
            self._received = np.empty_like(self._sent)
            comm.Alltoall(self._sent, self._received)
        arrived = self._move(ids[order])
        self._source = np.argsort(arrived)
        once = bool((np.diff(arrived[self._source]) > 0).all()) and self._sent.sum() == len(ids)
        whole = not complete or len(arrived) == shares[comm.rank + 1] - shares[comm.rank]
        cause = None if once and whole else "an id is missing or there twice"
        agree(comm, "order the particles", cause)
        lengths = np.diff(shares) if complete else comm.allgather(len(arrived))
        self.bounds = np.cumsum([0, *lengths]).tolist()
        self.first, self.last = self.bounds[comm.rank : comm.rank + 2]
        self.count = self.bounds[-1]

    def collect(self, values: Array) -> Array:
        """Bring the values of a field to the rank and the row they belong to.

        Parameters
        ----------
        values : ndarray, shape (n,) or (n, k)
            Of this rank's particles, in the order of `storage`.

        Returns
        -------
        ndarray, shape (last - first,) or (last - first, k)
            Those of this rank's rows.
        """
        if self.comm.size == 1:
            return np.ascontiguousarray(values)
        return np.take(self._move(values), self._source, axis=0)

    def _move(self, values: Array) -> Array:
        """Send each rank its share; what arrives is ordered by the sending rank, then by id."""
        if self.comm.size == 1:
            return values
        from mpi4py import MPI

        values = np.ascontiguousarray(values)
        arrived = np.empty((int(self._received.sum()), *values.shape[1:]), values.dtype)
        # Counting in rows keeps the counts below MPI's limit of 2^31.
        row = MPI.BYTE.Create_contiguous(values.dtype.itemsize * int(np.prod(values.shape[1:])))
        row.Commit()
        self.comm.Alltoallv([values, self._sent, row], [arrived, self._received, row])
        row.Free()
        return arrived
