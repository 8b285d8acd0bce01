"""Pieces of a surface of triangles in the boxes of a lattice: triangles cut along its planes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Corners of a triangle that six planes have cut.
_CORNERS = 9

#: Triangles that are cut together.
_BLOCK = 20_000


def _cut(corners: Reals, count: Ints, axis: int, at: Reals, side: float) -> tuple[Reals, Ints]:
    """Keep the parts of convex polygons on a side of a plane each.

    Parameters
    ----------
    corners, count : (n, m, 3) float64, (n,) int64
        Their corners, as many as `count` has.
    at, side : (n,) float64, float
        Places of the planes along `axis`; 1 above them, -1 below.
    """
    n, m = corners.shape[:2]
    number = np.arange(m)
    there = number < count[:, None]
    following = np.where(number + 1 < count[:, None], number + 1, 0)
    end = np.take_along_axis(corners, following[..., None], axis=1)
    a, b = (side * (each[..., axis] - at[:, None]) for each in (corners, end))
    kept, crosses = there & (a >= 0.0), there & ((a >= 0.0) != (b >= 0.0))
    place = np.cumsum(kept.astype(np.int64) + crosses, axis=1) - crosses
    part = np.divide(a, a - b, out=np.zeros_like(a), where=crosses)
    found = np.zeros((n, m + 1, 3))
    row = np.broadcast_to(np.arange(n)[:, None], kept.shape)
    found[row[kept], place[kept] - 1] = corners[kept]
    point = corners + part[..., None] * (end - corners)
    point[..., axis] = at[:, None]
    found[row[crosses], place[crosses]] = point[crosses]
    return found[:, :_CORNERS], place[:, -1] + crosses[:, -1]


def _sliced(corners: Reals, count: Ints, axis: int, edges: Reals) -> tuple[Reals, Ints, Ints, Ints]:
    """Cut polygons at the edges of boxes along an axis: pieces, their polygons and boxes.

    What lies in an edge belongs to the box above it; what lies beyond all boxes is left out.
    """
    there = np.arange(corners.shape[1]) < count[:, None]
    x = corners[..., axis]
    low = np.where(there, x, np.inf).min(axis=1)
    high = np.where(there, x, -np.inf).max(axis=1)
    first = np.searchsorted(edges, low, "right") - 1
    last = np.maximum(np.searchsorted(edges, high, "left") - 1, first)
    first, last = np.maximum(first, 0), np.minimum(last, len(edges) - 2)
    many = np.maximum(last - first + 1, 0)
    row = np.repeat(np.arange(len(corners)), many)
    box = np.arange(len(row)) - np.repeat(np.cumsum(many) - many, many) + first[row]
    corners, count = corners[row], count[row]
    corners, count = _cut(corners, count, axis, edges[box], 1.0)
    corners, count = _cut(corners, count, axis, edges[box + 1], -1.0)
    kept = count >= 3
    return corners[kept], count[kept], row[kept], box[kept]


def facets(triangles: Reals, edges: list[Reals]) -> tuple[Ints, Reals, Reals, Reals]:
    """Pieces of a surface in the boxes of a lattice; see `Region.facets`.

    Parameters
    ----------
    triangles : (n, 3, 3) float64
        They face outwards; in 2D the directions are x, an added one from 0 to 1, y.
    edges : list of (m + 1,) float64
        Edges of the boxes by direction.
    """
    axes = [0, 2] if len(edges) == 2 else [*range(len(edges))]
    parts = [
        _facets(triangles[begin : begin + _BLOCK], edges, axes)
        for begin in range(0, max(len(triangles), 1), _BLOCK)
    ]
    box, centre, area, second = (np.concatenate(each) for each in zip(*parts, strict=True))
    return box, centre, area, second


def _facets(
    triangles: Reals, edges: list[Reals], axes: list[int]
) -> tuple[Ints, Reals, Reals, Reals]:
    """As `facets`, along `axes` of the triangles."""
    corners, count = triangles, np.full(len(triangles), 3)
    boxes = np.zeros((len(triangles), 0), np.int64)
    for axis, edge in zip(axes, edges, strict=True):
        corners, count, row, box = _sliced(corners, count, axis, edge)
        boxes = np.concatenate([boxes[row], box[:, None]], axis=1)

    # A fan of triangles about the first corner; those beyond the last corner have no area.
    there = np.arange(2, corners.shape[1]) < count[:, None]
    first = corners[:, :1]
    b, c = corners[:, 1:-1] - first, corners[:, 2:] - first
    vector = np.where(there[..., None], 0.5 * np.cross(b, c), 0.0)
    area = vector.sum(axis=1)
    size = np.sqrt((vector * vector).sum(axis=2))
    whole = size.sum(axis=1)
    kept = whole > 0.0
    boxes, first, b, c, area, size, whole = (
        each[kept] for each in (boxes, first, b, c, area, size, whole)
    )
    away = (size[..., None] * (b + c) / 3.0).sum(axis=1) / whole[:, None]
    points = np.stack([0.0 * b, b, c], axis=2) - away[:, None, None]
    points = points[..., axes]
    total = points.sum(axis=2)
    second = []
    D = len(axes)
    pairs = ((), ((0, 1),), ((1, 2), (0, 2), (0, 1)))[D - 1]
    for i, j in pairs:
        of = total[..., i] * total[..., j] + (points[..., i] * points[..., j]).sum(axis=2)
        second.append((size * of).sum(axis=1) / 12.0)
    if D == 3:
        x, y, z = np.moveaxis(points, 3, 0)
        X, Y, Z = np.moveaxis(total, 2, 0)
        of = X * Y * Z + X * (y * z).sum(axis=2) + Y * (x * z).sum(axis=2)
        of += Z * (x * y).sum(axis=2) + 2.0 * (x * y * z).sum(axis=2)
        second.append((size * of).sum(axis=1) / 60.0)
    means = np.stack(second, axis=1) if second else np.zeros((len(whole), 0))
    return (
        boxes, (first[:, 0] + away)[:, axes], area[:, axes], means / whole[:, None],
    )  # fmt: skip
