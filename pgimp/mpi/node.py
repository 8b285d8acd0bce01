"""Ranks of one node: shared cores, and the order in which they compile."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pgimp.mpi.communicator import Communicator

#: A call that compiles a kernel, and a measure of its rough compile time.
Call = tuple[float, Callable[[], Any]]


@contextmanager
def one_rank_first(comm: Communicator) -> Iterator[None]:
    """Run the body on the first rank of each node, then on the others; collective.

    The first compiles, the others find the kernels in the cache.
    An error in the body passes through after the others have been released.
    """
    if comm.size == 1:
        yield
        return
    from mpi4py import MPI

    node = comm.Split_type(MPI.COMM_TYPE_SHARED)
    if node.rank > 0:
        node.Barrier()
    try:
        yield
    finally:
        if node.rank == 0:
            node.Barrier()
        node.Free()


def shared_out(comm: Communicator, calls: list[Call]) -> None:
    """Make calls that compile kernels, shared out to the ranks of a node; collective.

    Each rank then finds the kernels of the others in the cache. An error in a call passes through
    after the others have been released.
    """
    from mpi4py import MPI

    node = comm.Split_type(MPI.COMM_TYPE_SHARED)
    try:
        for call in _part(calls, node.rank, node.size):
            call()
    finally:
        node.Barrier()
        node.Free()


def _part(calls: list[Call], rank: int, ranks: int) -> list[Callable[[], Any]]:
    """A rank's part of the calls: the longest first, each to the rank with the least so far."""
    busy, mine = [0.0] * ranks, []
    for time, call in sorted(calls, key=lambda one: -one[0]):
        first = busy.index(min(busy))
        busy[first] += time
        if first == rank:
            mine.append(call)
    return mine


def cores() -> set[int]:
    """Return the numbers of the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return os.sched_getaffinity(0)
    return set(range(os.cpu_count() or 1))


def shares_cores(comm: Communicator) -> bool:
    """Return whether more ranks than cores are confined to this rank's cores; collective."""
    if comm.size == 1:
        return False
    from mpi4py import MPI

    node = comm.Split_type(MPI.COMM_TYPE_SHARED)
    mine = cores()
    ranks = sum(theirs <= mine for theirs in node.allgather(mine))
    node.Free()
    return ranks > len(mine)
