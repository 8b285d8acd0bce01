"""Pairs of close boxes, of thousands, without a matrix of all pairs."""

from __future__ import annotations

import numpy as np


def close_pairs(low: np.ndarray, high: np.ndarray, wide: np.ndarray) -> np.ndarray:
    """Pairs of boxes, the lower number first, ascending, that are within `wide` along an axis.

    They are found by a sweep along the axis on which the boxes reach farthest, without a matrix of
    all pairs. Empty boxes, whose ends are infinite, are close to none.

    Parameters
    ----------
    low, high : (n, D) float64
        The boxes.
    wide : (D,) float64
        Distances by direction.
    """
    some = np.isfinite(low).all(axis=1)
    if np.count_nonzero(some) < 2:
        return np.empty((0, 2), np.int64)
    axis = int((high[some].max(axis=0) - low[some].min(axis=0)).argmax())
    order = np.flatnonzero(some)[low[some, axis].argsort(kind="stable")]
    begin = low[order, axis]
    last = np.searchsorted(begin, high[order, axis] + wide[axis] + 1e-9, "right")
    here = np.arange(len(order))
    counts = np.maximum(last - here - 1, 0)
    first = np.repeat(here, counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs = np.sort(np.stack([order[first], order[second]], axis=1), axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]
