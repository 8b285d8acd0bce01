"""Pairs of points near each other."""

from __future__ import annotations

import numpy as np

from pgimp.scene.bodies.elements import Indices, Reals
from pgimp.scene.bodies.surfaces.boxes import combinations


def beside(x: Reals, away: Reals, points: Reals) -> tuple[Indices, Indices]:
    """Pairs of a place and a point near it along all directions, ascending, (k,) each.

    Parameters
    ----------
    x, away : (n, D) and (n,) float64
        The places, and distances within which points are near.
    points : (m, D) float64
        The points.
    """
    none = np.zeros(0, np.int64)
    if not len(x) or not len(points):
        return none, none
    D, side = x.shape[1], float(away.max())
    low = np.minimum(points.min(axis=0), x.min(axis=0)) - 2.0 * side
    bins, own = (np.floor((each - low) / side).astype(np.int64) for each in (points, x))
    extent = tuple((np.maximum(bins.max(axis=0), own.max(axis=0)) + 2).tolist())
    keys = np.ravel_multi_index(tuple(bins.T), extent)
    order = np.argsort(keys, kind="stable")
    keys, found = keys[order], []
    for step in combinations([*[np.arange(-1, 2)] * (D - 1), np.zeros(1, np.int64)]):
        key = np.ravel_multi_index(tuple((own + step).T), extent)
        begin = np.searchsorted(keys, key - 1)
        counts = np.searchsorted(keys, key + 1, "right") - begin
        row = np.repeat(np.arange(len(x)), counts)
        at = np.arange(len(row)) + np.repeat(begin - np.cumsum(counts) + counts, counts)
        point = order[at]
        near = (np.abs(points[point] - x[row]) < away[row, None]).all(axis=1)
        found.append((row[near], point[near]))
    row, point = (np.concatenate(each) for each in zip(*found, strict=True))
    order = np.lexsort((point, row))
    return row[order], point[order]
