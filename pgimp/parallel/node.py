"""One rank a node goes first: it compiles, and the others find the kernels in the cache."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def one_rank_first(comm: Any) -> Iterator[None]:
    """Run the body on the first rank of each node, then on the others; collective.

    An error in the body passes through after the others have been let go.
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
