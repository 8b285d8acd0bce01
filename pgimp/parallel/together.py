"""What every rank does and all must succeed in, so that none goes on without the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")


def all_or_none(comm: Any, action: Callable[[], T], *kinds: type[Exception]) -> T:
    """Do something on every rank, and let it fail on all if it fails on one.

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
