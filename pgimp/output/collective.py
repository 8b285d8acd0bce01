"""Work of rank 0 or of each rank whose failure every rank learns, so that none waits forever."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from typing import Any, TypeVar

from pgimp.errors import PgimpError, RunError

T = TypeVar("T")

_ADVICE = {
    errno.ENOSPC: "Make room there, or choose another place with -o.",
    errno.EDQUOT: "Make room in your quota, or choose another place with -o.",
    errno.EROFS: "Choose another place with -o.",
    errno.EACCES: "Choose another place with -o, or change the permissions.",
    errno.EPERM: "Choose another place with -o, or change the permissions.",
}


def on_root(comm: Any, action: Callable[[], T]) -> T:
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
    return result


def agree(comm: Any, what: str, cause: str | None) -> None:
    """Let every rank know whether any of them failed.

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
        On every rank, with the cause that the lowest failing rank gave.
    """
    causes = comm.allgather(cause)
    for rank, first in enumerate(causes):
        if first is not None:
            where = f" (rank {rank})" if comm.size > 1 else ""
            raise RunError(f"cannot {what}: {first}{where}")


def explain(error: OSError) -> str:
    """Word the cause of a failed file operation for people, with what to do about it."""
    if error.errno is None:
        return " ".join(str(error).split())
    cause = os.strerror(error.errno)
    return f"{cause}. {_ADVICE[error.errno]}" if error.errno in _ADVICE else cause
