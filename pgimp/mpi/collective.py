"""Work of rank 0 or of each rank whose failure reaches every rank, so that none waits forever."""

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
        What rank 0 does.

    Returns
    -------
    object
        What `action` returned, on every rank.

    Raises
    ------
    PgimpError
        What `action` raised, on every rank.
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
        What was being done, for the message.
    cause : str or None
        Why it failed on this rank; None if it did not.

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
        What each rank does; not collective itself.
    *kinds : types of Exception
        The failures that are expected.

    Returns
    -------
    object
        What `action` returned on this rank.

    Raises
    ------
    Exception
        On every rank, what the lowest failing rank raised, if it is one of `kinds`.
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
