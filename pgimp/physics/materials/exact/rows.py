"""Common tools of exact curves: rows before a path's first turn, roots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Array = np.ndarray

#: Steps of Newton's method, for nearly linear functions.
_ROUNDS = 30


def first_leg(value: Array) -> Array:
    """Mask of the rows before a path's first turn, (n,)."""
    size = np.abs(value)
    same = (np.diff(size, prepend=0.0) >= 0.0) & (value * value[1] >= 0.0)
    return np.logical_and.accumulate(same)


def solved(function: Callable[[Array], tuple[Array, Array]], start: Array) -> Array:
    """Root of a function that returns its values and slopes, by Newton's method."""
    x = start.copy()
    for _ in range(_ROUNDS):
        found, slope = function(x)
        x = x - found / slope
    return x
