"""Results of unknown size: arrays that are made anew, with more room, until all fits."""

from collections.abc import Callable
from typing import TypeVar

Arrays = TypeVar("Arrays")


def grown(
    room: int, make: Callable[[int], Arrays], fill: Callable[[Arrays], int]
) -> tuple[Arrays, int]:
    """Return arrays with room for a result, and the result's size.

    Parameters
    ----------
    room : int
        The size to begin with.
    make : callable
        Makes arrays of a size.
    fill : callable
        Fills them as far as there is room, and returns the size of the whole result.
    """
    while True:
        arrays = make(room)
        found = fill(arrays)
        if found <= room:
            return arrays, found
        room = found
