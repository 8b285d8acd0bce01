"""Messages between all ranks: arrays of one structure, without Python objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pgimp.mpi.communicator import Communicator


def exchange_counts(comm: Communicator, counts: np.ndarray) -> np.ndarray:
    """Return how many items each rank sends to this one, if it sends `counts`; collective."""
    theirs = np.empty(comm.size, np.int64)
    comm.Alltoall(counts.astype(np.int64), theirs)
    return theirs


def swap(
    comm: Communicator, items: np.ndarray, sent: np.ndarray, received: np.ndarray
) -> np.ndarray:
    """Send the first `sent[0]` items to rank 0, and so on; return theirs by rank; collective.

    Parameters
    ----------
    items : array
        Of numbers or records of 8 bytes each, in C order.
    sent, received : (ranks,) int64
        Numbers of items along the first axis.
    """
    found = np.empty((int(received.sum()), *items.shape[1:]), items.dtype)
    width = items.dtype.itemsize // 8 * int(np.prod(items.shape[1:], dtype=np.int64))
    comm.Alltoallv(
        [np.ascontiguousarray(items).view(np.float64), sent * width, "d"],
        [found.view(np.float64), received * width, "d"],
    )
    return found


def swap_parts(
    comm: Communicator, parts: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `swap` for one array a rank; returns items, `sent` and `received`; collective."""
    sent = np.array([len(part) for part in parts])
    received = exchange_counts(comm, sent)
    return swap(comm, np.concatenate(parts), sent, received), sent, received


def greatest(comm: Communicator, value: float) -> float:
    """Return the greatest value of all ranks; collective."""
    return greatest_of(comm, value)[0]


def greatest_of(comm: Communicator, *values: float) -> tuple[float, ...]:
    """Return the greatest of each value of all ranks; collective."""
    if comm.size == 1:
        return values
    from mpi4py import MPI

    return (*_reduced(comm, np.array(values, float), MPI.MAX).tolist(),)


def total(comm: Communicator, values: np.ndarray) -> np.ndarray:
    """Return the sum of all ranks' whole numbers; collective."""
    if comm.size == 1:
        return values
    from mpi4py import MPI

    return _reduced(comm, values, MPI.SUM)


def united(comm: Communicator, marks: np.ndarray) -> np.ndarray:
    """Return the bits set on any rank; collective."""
    if comm.size == 1:
        return marks
    from mpi4py import MPI

    return _reduced(comm, marks, MPI.BOR)


def gathered(comm: Communicator, values: np.ndarray) -> np.ndarray:
    """Return the arrays of all ranks, (ranks, ...), all of one shape; collective."""
    if comm.size == 1:
        return values[None]
    every = np.empty((comm.size, *values.shape), values.dtype)
    comm.Allgather(np.ascontiguousarray(values), every)
    return every


def _reduced(comm: Communicator, values: np.ndarray, operation: Any) -> np.ndarray:
    found = np.empty_like(values)
    comm.Allreduce(values, found, operation)
    return found
