"""Work of rank 0 or of each rank with failures raised on every rank, so that none waits forever."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from pgimp.errors import PgimpError, RunError
from pgimp.mpi.communicator import Communicator

T = TypeVar("T")


def on_root(comm: Communicator, action: Callable[[], T]) -> T:
    """Do something on rank 0 alone.

    Parameters
    ----------
    comm : communicator
        Of all ranks; the call is collective.
    action : callable
        Rank 0's work.

    Returns
    -------
    object
        The result of `action`, on every rank.

    Raises
    ------
    PgimpError
        The exception of `action`, on every rank.
    """
    result = error = None
    if comm.rank == 0:
        try:
            result = action()
        except PgimpError as raised:
            error = raised
    result, error = comm.bcast((result, error))
    if error is not None:
        raise error
    return cast(T, result)


def agree(comm: Communicator, what: str, cause: str | None) -> None:
    """Raise on every rank if any of them failed.

    Parameters
    ----------
    comm : communicator
        Of all ranks; the call is collective.
    what : str
        The work, for the message.
    cause : str or None
        Reason of the failure on this rank; None without one.

    Raises
    ------
    RunError
        On every rank, with the cause of the lowest failing rank.
    """
    causes = comm.allgather(cause)
    for rank, first in enumerate(causes):
        if first is not None:
            where = f" (rank {rank})" if comm.size > 1 else ""
            raise RunError(f"cannot {what}: {first}{where}")


def all_or_none(comm: Communicator, action: Callable[[], T], *kinds: type[Exception]) -> T:
    """Do something on every rank; it fails on all if it fails on one.

    Parameters
    ----------
    comm : communicator
        Of all ranks; the call is collective.
    action : callable
        Each rank's work; not collective itself.
    *kinds : types of Exception
        The expected failures.

    Returns
    -------
    object
        The result of `action` on this rank.

    Raises
    ------
    Exception
        On every rank, the exception of the lowest failing rank, if it is one of `kinds`.
    """
    result = failure = None
    try:
        result = action()
    except kinds as raised:
        failure = raised
    for first in comm.allgather(failure):
        if first is not None:
            raise first
    return result  # type: ignore[return-value]
