"""Polygons of facets in the initial state, for pictures: cells, and points that they share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.scene.bodies.elements import Indices, Reals
from pgimp.scene.bodies.surface_patches import Facets

#: Part of a facet's size within which corners are one point.
_SAME = 0.05

#: Error of a polygon's area, over that of its facet, from which on it is scaled.
_OFF = 0.1

#: Part of a box by which a plane may lie beside it.
_TOLERANCE = 1e-6


class Polygons(NamedTuple):
    """Cells of facets, each a point in 1D, a line in 2D, a quadrilateral in 3D.

    A polygon of more corners is several quadrilaterals; a triangle has its last corner twice.
    """

    x: Reals  #: (points, 3) float64: Coordinates in the initial state.
    facet: Indices  #: (points,) int64: A facet that each point belongs to.
    cells: Indices  #: (cells, 1, 2 or 4) int64: Points of each cell.
    of: Indices  #: (cells,) int64: Facet of each cell.
    part: Reals  #: (cells,) float64: Part of the facet that it is.


def polygons_of(facets: Facets, body: Indices, D: int) -> Polygons:
    """Polygons of facets, in the order of these."""
    if D == 1:
        number = np.arange(len(facets.x))
        return Polygons(facets.x, number, number[:, None], number, np.ones(len(number)))
    if D == 2:
        along = np.stack([-facets.normal[:, 1], facets.normal[:, 0]], axis=1)
        half = np.zeros_like(facets.x)
        half[:, :2] = 0.5 * facets.area[:, None] * along
        corners = np.stack([facets.x - half, facets.x + half], axis=1)
        of, part = np.arange(len(corners)), np.ones(len(corners))
    else:
        corners, of, part = _quadrilaterals(facets, body)
    n, nodes = corners.shape[:2]
    x, point = _shared(corners.reshape(-1, 3), np.repeat(of, nodes), facets, body, D)
    owner = np.empty(len(x), np.int64)
    owner[point[::-1]] = np.repeat(of, nodes)[::-1]
    return Polygons(x, owner, point.reshape(n, nodes), of, part)


def _shared(x: Reals, of: Indices, facets: Facets, body: Indices, D: int) -> tuple[Reals, Indices]:
    """Mean places of corners that are one point, and the point of each corner."""
    size = facets.area if D == 2 else np.sqrt(facets.area)
    side = _SAME * float(np.median(size)) if len(size) else 1.0
    label = np.arange(len(x))
    # Corners are joined in bins, then in bins shifted by half, until nothing changes.
    for shift in (0.0, 0.5):
        key = np.column_stack([body[of], np.floor(x / side + shift).astype(np.int64)])
        _, same = np.unique(key, axis=0, return_inverse=True)
        same = same.reshape(-1)
        least = np.full(same.max(initial=-1) + 1, len(x))
        np.minimum.at(least, same, label)
        label = np.minimum(label, label[least[same]])
    label = label[label]
    _, first, point = np.unique(label, return_index=True, return_inverse=True)
    point = point.reshape(-1)
    count = np.bincount(point, minlength=len(first))
    mean = np.stack([np.bincount(point, x[:, d]) / count for d in range(3)], axis=1)
    return mean.reshape(-1, 3), point


def _quadrilaterals(facets: Facets, body: Indices) -> tuple[Reals, Indices, Reals]:
    """Corners of the quadrilaterals of facets, (n, 4, 3); their facets, and parts of these."""
    x, normal = facets.x, facets.normal
    n = len(x)
    # A square in the facet's plane, cut by its part of a box.
    axis = np.argmin(np.abs(normal), axis=1)
    a = np.cross(normal, np.eye(3)[axis])
    a /= np.sqrt((a * a).sum(axis=1))[:, None]
    b = np.cross(normal, a)
    reach = 8.0 * (np.abs(x - facets.middle) + facets.half).max(axis=1)[:, None]
    start = [x + reach * (s * a + t * b) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corner, count = np.stack(start, axis=1), np.full(n, 4)
    for d in range(3):
        for side in (-1.0, 1.0):
            way = np.zeros((n, 3))
            way[:, d] = side
            end = side * facets.middle[:, d] + facets.half[:, d] * (1.0 + _TOLERANCE)
            corner, count = _cut(corner, count, way, end)
    corner, count = _cut_by_others(corner, count, facets, body)
    area = _areas(corner, count)
    scale = np.sqrt(facets.area / np.maximum(area, 1e-300))
    bare = (count < 3) | ~(np.abs(scale - 1.0) < 0.5)
    if bare.any():  # nothing is known of its outline
        half = 0.5 * np.sqrt(facets.area)[bare, None]
        for k, (s, t) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
            corner[bare, k] = x[bare] + half * (s * a[bare] + t * b[bare])
        count[bare] = 4
    off = ~bare & ~(np.abs(scale - 1.0) < _OFF)
    corner[off] = x[off, None] + scale[off, None, None] * (corner[off] - x[off, None])
    every, of, parts = [], [], []
    for first in range(1, corner.shape[1] - 1, 2):
        some = np.flatnonzero(count > first + 1)
        last = np.minimum(first + 2, count[some] - 1)
        four = np.stack([corner[some, 0], corner[some, first], corner[some, first + 1],
                         corner[some, last]], axis=1)  # fmt: skip
        every.append(four)
        of.append(some)
        parts.append(_areas(four, np.full(len(four), 4)))
    number = np.concatenate(of)
    order = np.argsort(number, kind="stable")
    number, part = number[order], np.concatenate(parts)[order]
    whole = np.bincount(number, part, n)[number]
    return np.concatenate(every)[order], number, part / np.maximum(whole, 1e-300)


def _areas(corner: Reals, count: Indices) -> Reals:
    """Areas of flat polygons."""
    arm = corner - corner[:, :1]
    found = np.zeros((len(corner), 3))
    for k in range(1, corner.shape[1] - 1):
        found += (k + 1 < count)[:, None] * np.cross(arm[:, k], arm[:, k + 1])
    return np.asarray(0.5 * np.sqrt((found * found).sum(axis=1)))


def _cut(corner: Reals, count: Indices, normal: Reals, end: Reals) -> tuple[Reals, Indices]:
    """Cut off what lies beyond planes, one for each polygon, at `end` along `normal`."""
    n, most = corner.shape[:2]
    depth = np.einsum("nkd,nd->nk", corner, normal) - end[:, None]
    found, number, row = np.zeros((n, most + 1, 3)), np.zeros(n, np.int64), np.arange(n)
    for k in range(most):
        after = np.where(k + 1 < count, k + 1, 0)
        here, there = depth[:, k], depth[row, after]
        kept = (k < count) & (here <= 0.0)
        found[row[kept], number[kept]] = corner[kept, k]
        number += kept
        crossed = (k < count) & ((here < 0.0) & (there > 0.0) | (here > 0.0) & (there < 0.0))
        t = here[crossed] / (here[crossed] - there[crossed])
        p, q = corner[crossed, k], corner[row[crossed], after[crossed]]
        found[row[crossed], number[crossed]] = p + t[:, None] * (q - p)
        number += crossed
    return found[:, : max(int(number.max(initial=0)), 4)], number


def _cut_by_others(
    corner: Reals, count: Indices, facets: Facets, body: Indices
) -> tuple[Reals, Indices]:
    """Cut off what lies beyond other facets in the same part of a box, as at edges."""
    size = np.maximum(facets.half.max(axis=1, initial=0.0), 1e-300)[:, None]
    key = np.column_stack([body, np.rint(8.0 * facets.middle / size.max()).astype(np.int64)])
    _, same, shared = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    same = same.reshape(-1)
    for group in np.flatnonzero(shared > 1).tolist():
        members = np.flatnonzero(same == group)
        for one in members:
            for other in members[members != one]:
                normal, x = facets.normal[other], facets.x[other]
                way = float(np.sign((facets.x[one] - x) @ normal))
                if abs(float((facets.x[one] - x) @ normal)) < _TOLERANCE * size[one, 0]:
                    continue
                some, number = _cut(
                    corner[one : one + 1], count[one : one + 1],
                    -way * normal[None], np.array([-way * float(x @ normal)]),
                )  # fmt: skip
                wide = max(some.shape[1], corner.shape[1])
                if wide > corner.shape[1]:
                    more = np.zeros((len(corner), wide - corner.shape[1], 3))
                    corner = np.concatenate([corner, more], axis=1)
                corner[one, : some.shape[1]], count[one] = some[0], number[0]
    return corner, count
