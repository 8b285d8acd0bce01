"""Patches of the surfaces of bodies, about a cell each, on which contact acts.

A facet is an element of a surface, see `pgimp.scene.bodies.surface_elements`: nearly flat, with
area, normal and centroid. A patch is the facets in one cell of the grid with normals near one
direction. Small ones join a neighbour.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.rows import distinct
from pgimp.scene.bodies.elements import Elements, Indices, Reals, half_edges
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surfaces.beside import beside
from pgimp.scene.bodies.surfaces.boxes import Closed
from pgimp.scene.bodies.surfaces.edges import FLAT, parted

#: Least area of a facet, and of a patch that does not join another, over that of a cell's side.
LEAST_FACET, LEAST_PATCH = 1e-4, 0.5

#: Least cosine between normals of patches that join.
_ALIKE = 0.7

#: Part of the mean radius of a facet by which it reaches farther than a disc of its area.
_WIDE = 1.25

#: Cells within which facets are on a plane.
_AT = 1e-6

#: Periods of the domain, and where the part of a rigid body that spans them begins, see
#: `facets_of`.
Around = tuple[Reals, ...] | None


class Facets(NamedTuple):
    """Facets of surfaces, those of a patch together; of three components each vector."""

    x: Reals  #: (n, 3) float64: Centroids in the initial state.
    normal: Reals  #: (n, 3) float64: Unit normals, out of the body.
    area: Reals  #: (n,) float64: Areas, of rings all round.
    radius: Reals  #: (n,) float64: Radii of discs of these sizes; half-lengths in 2D.
    #: middle, half: (n, 3) float64: Middle and half-sides of the part of a box that each is in.
    middle: Reals
    half: Reals
    edges: Reals  #: (n, 2, 3) float64: See `half_edges`.
    patch: Indices  #: (n,) int64: Number of each facet's patch, ascending.

    @classmethod
    def joined(cls, every: list[Facets]) -> Facets:
        """All of some bodies; patches are numbered on."""
        none = np.zeros((0, 3))
        first, edges, whole = 0, np.zeros((0, 2, 3)), np.zeros(0, np.int64)
        parts = [cls(none, none, none[:, 0], none[:, 0], none, none, edges, whole)]
        for each in every:
            parts.append(each._replace(patch=each.patch + first))
            first += each.patches
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    @property
    def patches(self) -> int:
        """Number of patches."""
        return int(self.patch[-1]) + 1 if len(self.patch) else 0


def facets_of(
    body: LatticeBody, origin: Reals, cell: Reals, closed: Closed = (), ring: bool = False,
    around: Around = None, elements: Elements | None = None,
) -> Facets:  # fmt: skip
    """Facets of a body, in patches.

    Parameters
    ----------
    body : LatticeBody
        The body; its surface cuts boxes.
    origin, cell : (D,) float64
        A vertex of the grid, and the sides of a cell.
    closed : sequence of (axis, side)
        See `find_elements`.
    ring : bool
        Whether facets stand for rings about the axis x = 0.
    around : tuple of (D,) float64, optional
        Periods of the domain, 0 where there are none: patches go on across a seam. With a low end
        only facets within a period of it count, and none on planes at the third.
    elements : Elements, optional
        Those of its whole surface, if they are known.
    """
    low, high = body.box[0]
    if elements is None:
        elements = find_elements(body, None, (low - 1, high + 1), closed)
    found = parted(elements)
    size = np.sqrt((found.area * found.area).sum(axis=1))
    side = float(np.prod(cell)) ** (1.0 - 1.0 / len(cell))
    some = size > LEAST_FACET * side
    found, size = found.chosen(some), size[some]
    normal = found.area / size[:, None]
    x = found.centroid
    # A surface between two boxes has an element in each; nearly there, also two that cancel.
    ways = np.rint(1e6 * normal) + 0.0
    leading = ways[np.arange(len(ways)), np.argmax(ways != 0.0, axis=1)]
    sign = np.where(leading < 0.0, -1.0, 1.0)
    places = np.column_stack([np.rint(1e5 * x / body.size), sign[:, None] * ways]) + 0.0
    first, same = distinct(places)
    size = np.asarray(np.bincount(same, sign * size), float)
    way = (np.sign(size) * sign[first])[:, None]
    found, x, normal, size = found.chosen(first), x[first], way * normal[first], np.abs(size)
    some = size > LEAST_FACET * side
    found, x, normal, size = found.chosen(some), x[some], normal[some], size[some]
    if ring:  # what reaches across the axis has no part there
        beyond = x[:, 0] > LEAST_FACET * cell[0]
        found, x, normal, size = found.chosen(beyond), x[beyond], normal[beyond], size[beyond]
    periods, *ends = around or (np.zeros(len(cell)),)
    if ends:
        inside = _within_period(x, normal, cell, periods, *ends)
        found, x, normal, size = found.chosen(inside), x[inside], normal[inside], size[inside]
    edges = half_edges(found, x, normal, size)
    x, middle = x.copy(), found.centre.copy()
    for d in np.flatnonzero(periods):  # places, and so patches, in one order wherever a seam is
        below = x[:, d] < _beginning(x[:, d], periods[d], _AT * cell[d])
        x[below, d] += periods[d]
        middle[below, d] += periods[d]
    patch = _patches(x, normal, size, origin, cell, periods)
    order = np.argsort(patch, kind="stable")
    edges = edges[order]
    x, normal, size, patch = x[order], normal[order], size[order], patch[order]
    # All facets of a patch are at one side of a seam, also beyond the domain.
    _, first, number = np.unique(patch, return_index=True, return_inverse=True)
    away = _whole_periods(x - x[first][number.reshape(-1)], periods)
    x, middle = x - away, middle[order] - away
    radius = radius_of(size, len(cell))
    if ring:
        r = x[:, 0].copy()
        # The centroid of a strip that weighs with its radius is farther out than its middle.
        x[:, 0] += (normal[:, 1] * size) ** 2 / (12.0 * r)
        x[:, 1] -= normal[:, 0] * normal[:, 1] * size**2 / (12.0 * r)
        size = 2.0 * np.pi * r * size
    return Facets(
        _three(x),
        _three(normal),
        size,
        radius,
        _three(middle),
        _three(found.half[order]),
        np.pad(edges, ((0, 0), (0, 0), (0, 3 - len(cell)))),
        patch,
    )


def radius_of(area: Reals, D: int) -> Reals:
    """Radii of discs of such areas, and some more; half-lengths in 2D."""
    return np.asarray(0.5 * area if D < 3 else _WIDE * np.sqrt(area / np.pi))


def _three(values: Reals) -> Reals:
    """Vectors with three components."""
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


def _whole_periods(way: Reals, periods: Reals) -> Reals:
    """Whole periods in vectors."""
    return np.asarray(np.rint(way / np.where(periods > 0.0, periods, np.inf)) * periods)


def _beginning(x: Reals, period: float, least: float) -> float:
    """Coordinate after the widest gap between others, in a ring; the first of about as wide ones.

    Others are at most a period apart.
    """
    places = np.sort(x)
    if not len(places):
        return 0.0
    gaps = np.diff(places, prepend=places[-1] - period)
    return float(places[np.flatnonzero(gaps > gaps.max() - least)[0]]) - least


def _within_period(
    x: Reals, normal: Reals, cell: Reals, periods: Reals, begin: Reals, low: Reals
) -> NDArray[np.bool_]:
    """Mask of facets within a period, and not on the planes where an image begins."""
    found = np.ones(len(x), bool)
    for d in np.flatnonzero(periods):
        found &= (begin[d] <= x[:, d]) & (x[:, d] < begin[d] + periods[d])
        plane = np.abs(_whole_periods(x - low, periods)[:, d] - (x - low)[:, d]) < _AT * cell[d]
        found &= ~(plane & (np.abs(normal[:, d]) > 1.0 - _AT))
    return found


def _patches(
    x: Reals, normal: Reals, area: Reals, origin: Reals, cell: Reals, periods: Reals
) -> Indices:
    """Numbers of the facets' patches."""
    if not len(x):
        return np.zeros(0, np.int64)
    inside = np.floor((x - origin) / cell - 1e-6 * normal).astype(np.int64)
    axis = np.argmax(np.round(np.abs(normal), 6), axis=1)
    sign = normal[np.arange(len(x)), axis] > 0.0
    keys = np.column_stack([inside, 2 * axis + sign])
    first, patch = distinct(keys)
    off = np.abs((x - origin) / cell - inside - 0.5)
    places, patch = _flat(inside[first], patch, normal, area, off)
    total = np.asarray(np.bincount(patch, area), float)
    centre, mean = (
        np.asarray(np.stack([np.bincount(patch, area * e) for e in v.T], axis=1), float)
        for v in (x, normal)
    )
    side = float(np.prod(cell)) ** (1.0 - 1.0 / len(cell))
    around = periods, np.rint(periods / cell).astype(np.int64)
    into = _joins(places, total, np.asarray(centre / total[:, None]), mean, side, around)
    return np.unique(into[patch], return_inverse=True)[1].reshape(-1)


def _flat(
    places: Indices, patch: Indices, normal: Reals, area: Reals, off: Reals
) -> tuple[Indices, Indices]:
    """Split patches whose facets are not alike, as beside edges; all patches' places, and numbers.

    Each part has the facets that are alike to the greatest of the rest. Of equal ones their
    normals, and the sizes of their places `off` a cell's middle, decide: images have the same.
    """
    mean = np.stack([np.bincount(patch, area * n) for n in normal.T], axis=1).astype(float)
    mean = mean / np.maximum(np.sqrt((mean * mean).sum(axis=1)), 1e-300)[:, None]
    bent = np.unique(patch[(mean[patch] * normal).sum(axis=1) < FLAT])
    more, order, own = [places], np.argsort(patch, kind="stable"), patch
    begin, end = (np.searchsorted(own[order], bent, side) for side in ("left", "right"))
    patch = patch.copy()
    for one, a, b in zip(bent.tolist(), begin.tolist(), end.tolist(), strict=True):
        rest = order[a:b]
        images = np.round(np.hstack([off[rest], np.abs(normal[rest])]), 6)
        rest = rest[np.lexsort((*images.T, -np.round(area[rest] / area[rest].max(), 6)))]
        while len(rest):
            alike = normal[rest] @ normal[rest[0]] >= FLAT
            if not alike.all():
                patch[rest[alike]] = sum(map(len, more))
                more.append(places[one : one + 1])
            rest = rest[~alike]
    return np.concatenate(more), patch


def _joins(
    places: Indices,
    total: Reals,
    centre: Reals,
    mean: Reals,
    side: float,
    around: tuple[Reals, Indices],
) -> Indices:
    """The patch that each patch is part of: small ones join the nearest whose normal is alike.

    Of equally near ones sizes along x, y and z decide, so that images join images. `around` are the
    domain's periods, and the cells in them; 0 without any.
    """
    into = np.arange(len(total))
    small = np.flatnonzero(total < LEAST_PATCH * side)
    if not len(small):
        return into
    unit = mean / np.sqrt((mean * mean).sum(axis=1))[:, None]
    area = total.copy()

    def root(one: int) -> int:
        while into[one] != one:
            one = int(into[one])
        return one

    # Patches beside the small ones, also across seams, the nearest first.
    periods, cells = around
    ways = np.array([*product(*((0, -n, n) if n else (0,) for n in cells.tolist()))])
    points = (ways[:, None] + places).reshape(-1, places.shape[1]).astype(float)
    row, near = beside(places[small].astype(float), np.full(len(small), 1.5), points)
    near %= len(places)
    alike = (unit[near] * unit[small[row]]).sum(axis=1) > _ALIKE
    row, near = row[alike], near[alike]
    way = centre[near] - centre[small[row]]
    way -= _whole_periods(way, periods)
    away = np.round((way * way).sum(axis=1) / side**2, 9)
    sizes = np.round(np.abs(way).T[::-1], 9)
    order = np.lexsort((*places[near].T[::-1], *sizes, away, row))
    near, start = near[order], np.searchsorted(row, np.arange(len(small) + 1))
    nearest = np.append(away[order], np.inf)[start[:-1]]
    for k in np.lexsort((nearest, np.round(total[small] / side, 9))).tolist():
        own = root(int(small[k]))
        if area[own] >= LEAST_PATCH * side:
            continue
        others = (root(n) for n in near[start[k] : start[k + 1]].tolist())
        best = next((other for other in others if other != own), None)
        if best is not None:
            into[own] = best
            area[best] += area[own]
    return np.array([root(n) for n in range(len(into))])
