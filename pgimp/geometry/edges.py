"""Distances of planes that fill as much of a small neighbourhood as a body with edges does.

`pgimp.kernels.toolfill` weighs a vertex's neighbourhood with tents of half a cell, each cut by one
plane. At an edge the plane at the body's distance fills too much: through the corner of a box half
of the tent, where the box fills a quarter. Liquids would be held off edges.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.regions.base import Region

#: Parts of a small tent's half side by which it is divided.
_PARTS = 4

#: Points whose tents are divided together.
_BLOCK = 1 << 10

#: Bisections, to 1e-9 of a cell.
_BISECTIONS = 30


def filling_distances(
    region: Region, points: NDArray[np.float64], found: NDArray[np.float64], cell: tuple[float, ...]
) -> NDArray[np.float64]:
    """Distances of planes that fill as much of the tents of half a cell as the region does, (n,).

    Parameters
    ----------
    region : Region
        The body.
    points : (n, D) float64
        Middles of the tents.
    found : (n, 4) float64
        Distance there, and the unit vector away from the body, which is the plane's normal.
    cell : tuple of D float
        Sides of a cell.
    """
    D, half = len(cell), 0.5 * np.array(cell)
    along = np.arange(1 - _PARTS, _PARTS)
    steps = np.stack(np.meshgrid(*[along] * D, indexing="ij"), axis=-1).reshape(-1, D)
    weights = np.prod(_PARTS - np.abs(steps), axis=1) / _PARTS ** (2.0 * D)
    part = np.empty(len(points))
    for begin in range(0, len(points), _BLOCK):
        some = points[begin : begin + _BLOCK]
        places = some[:, None] + steps * half / _PARTS
        d = region.signed_distance(places.reshape(-1, D)).reshape(len(some), -1)
        part[begin : begin + _BLOCK] = (weights * _below(-d * _PARTS / half.min())).sum(axis=1)
    sides = -np.sort(-np.abs(found[:, 1 : 1 + D]) * half, axis=1)
    most = sides.sum(axis=1)
    low, high = -most, most.copy()
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        less = _cut(sides, middle) < part
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    plane = -0.5 * (low + high)
    plane = np.where(part < 1e-9, np.maximum(found[:, 0], most), plane)
    plane = np.where(part > 1.0 - 1e-9, np.minimum(found[:, 0], -most), plane)
    return np.where(most > 0.0, plane, found[:, 0])


def _below(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Part of a tent from -1 to 1 below u."""
    u = np.clip(u, -1.0, 1.0)
    return 0.5 + u - 0.5 * u * np.abs(u)


def _cut(sides: NDArray[np.float64], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Parts of products of tents with n . x < s, by the rule of `pgimp.kernels.tents.cut`."""
    root = np.sqrt(6.0)
    places = np.array([-4.0 - root, root - 4.0, 4.0 - root, 4.0 + root]) / 10.0
    outer, inner = 0.25 - 1.0 / (6.0 * root), 0.25 + 1.0 / (6.0 * root)
    weights, first = (outer, inner, inner, outer), np.where(sides[:, 0] > 0.0, sides[:, 0], 1.0)
    rest = [(1.0, np.zeros(len(s)))]
    for d in range(1, sides.shape[1]):
        rest = [
            (w * v, x + y * sides[:, d])
            for w, x in rest
            for v, y in zip(weights, places, strict=True)
        ]
    part = np.zeros(len(s))
    for w, x in rest:
        part += w * _below((s - x) / first)
    return part
