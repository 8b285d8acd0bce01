"""Patches of the surfaces of bodies, about a cell each, on which contact acts.

A facet is an element of a surface, see `pgimp.scene.bodies.surface_elements`: nearly flat, with
area, normal and centroid. A patch is the facets in one cell of the grid with normals near one
direction. Small ones join a neighbour.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.scene.bodies.elements import Indices, Reals, half_edges
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surfaces.beside import beside
from pgimp.scene.bodies.surfaces.boxes import Closed
from pgimp.scene.bodies.surfaces.edges import FLAT, parted

#: Least area of a facet, and of a patch that does not join another, over that of a cell's side.
LEAST_FACET, LEAST_PATCH = 1e-4, 0.5

#: Least cosine between normals of patches that join.
_ALIKE = 0.7


class Facets(NamedTuple):
    """Facets of surfaces, those of a patch together; of three components each vector."""

    x: Reals  #: (n, 3) float64: Centroids in the initial state.
    normal: Reals  #: (n, 3) float64: Unit normals, out of the body.
    area: Reals  #: (n,) float64: Areas.
    #: middle, half: (n, 3) float64: Middle and half-sides of the part of a box that each is in.
    middle: Reals
    half: Reals
    edges: Reals  #: (n, 2, 3) float64: See `half_edges`.
    patch: Indices  #: (n,) int64: Number of each facet's patch, ascending.

    @classmethod
    def joined(cls, every: list[Facets]) -> Facets:
        """All of some bodies; patches are numbered on."""
        first, parts = 0, []
        for each in every:
            parts.append(each._replace(patch=each.patch + first))
            first += each.patches
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    @property
    def patches(self) -> int:
        """Number of patches."""
        return int(self.patch[-1]) + 1 if len(self.patch) else 0


def facets_of(body: LatticeBody, origin: Reals, cell: Reals, closed: Closed = ()) -> Facets:
    """Facets of a body, in patches.

    Parameters
    ----------
    body : LatticeBody
        The body; its surface cuts boxes.
    origin, cell : (D,) float64
        A vertex of the grid, and the sides of a cell.
    closed : sequence of (axis, side)
        See `find_elements`.
    """
    low, high = body.box[0]
    found = parted(find_elements(body, None, (low - 1, high + 1), closed))
    size = np.sqrt((found.area * found.area).sum(axis=1))
    side = float(np.prod(cell)) ** (1.0 - 1.0 / len(cell))
    some = size > LEAST_FACET * side
    found, size = found.chosen(some), size[some]
    normal = found.area / size[:, None]
    x = found.centroid
    # A surface between two boxes has an element in each.
    places = np.rint(1e6 * np.column_stack([x / body.size, normal])) + 0.0
    first, same = _distinct(places)
    size = np.asarray(np.bincount(same, size), float)
    found, x, normal = found.chosen(first), x[first], normal[first]
    patch = _patches(x, normal, size, origin, cell, side)
    order = np.argsort(patch, kind="stable")
    return Facets(
        _three(x[order]),
        _three(normal[order]),
        size[order],
        _three(found.centre[order]),
        _three(found.half[order]),
        np.pad(half_edges(found, x, normal, size)[order], ((0, 0), (0, 0), (0, 3 - len(cell)))),
        patch[order],
    )


def _distinct(values: NDArray[Any]) -> tuple[Indices, Indices]:
    """First of each of the different rows, in ascending order, and which of these each row is."""
    order = np.lexsort(values.T[::-1])
    new = np.ones(len(order), bool)
    new[1:] = (values[order[1:]] != values[order[:-1]]).any(axis=1)
    same = np.empty(len(order), np.int64)
    same[order] = np.cumsum(new) - 1
    return order[new], same


def _three(values: Reals) -> Reals:
    """Vectors with three components."""
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


def _patches(
    x: Reals, normal: Reals, area: Reals, origin: Reals, cell: Reals, side: float
) -> Indices:
    """Numbers of the facets' patches."""
    if not len(x):
        return np.zeros(0, np.int64)
    inside = np.floor((x - origin) / cell - 1e-6 * normal).astype(np.int64)
    axis = np.argmax(np.round(np.abs(normal), 6), axis=1)
    sign = normal[np.arange(len(x)), axis] > 0.0
    keys = np.column_stack([inside, 2 * axis + sign])
    first, patch = _distinct(keys)
    places, patch = _flat(inside[first], patch, normal, area)
    total = np.asarray(np.bincount(patch, area), float)
    centre, mean = (
        np.asarray(np.stack([np.bincount(patch, area * e) for e in v.T], axis=1), float)
        for v in (x, normal)
    )
    into = _joins(places, total, np.asarray(centre / total[:, None]), np.asarray(mean), side)
    return np.unique(into[patch], return_inverse=True)[1].reshape(-1)


def _flat(places: Indices, patch: Indices, normal: Reals, area: Reals) -> tuple[Indices, Indices]:
    """Split patches whose facets are not alike, as beside edges; all patches' places, and numbers.

    Each part has the facets that are alike to the greatest of the rest.
    """
    mean = np.stack([np.bincount(patch, area * n) for n in normal.T], axis=1).astype(float)
    mean = mean / np.maximum(np.sqrt((mean * mean).sum(axis=1)), 1e-300)[:, None]
    bent = np.unique(patch[(mean[patch] * normal).sum(axis=1) < FLAT])
    more, order, own = [places], np.argsort(patch, kind="stable"), patch
    begin, end = (np.searchsorted(own[order], bent, side) for side in ("left", "right"))
    patch = patch.copy()
    for one, a, b in zip(bent.tolist(), begin.tolist(), end.tolist(), strict=True):
        rest = order[a:b]
        rest = rest[np.argsort(-np.round(area[rest] / area[rest].max(), 6), kind="stable")]
        while len(rest):
            alike = normal[rest] @ normal[rest[0]] >= FLAT
            if not alike.all():
                patch[rest[alike]] = sum(map(len, more))
                more.append(places[one : one + 1])
            rest = rest[~alike]
    return np.concatenate(more), patch


def _joins(places: Indices, total: Reals, centre: Reals, mean: Reals, side: float) -> Indices:
    """The patch that each patch is part of: small ones join the nearest whose normal is alike."""
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

    # Patches beside the small ones, the nearest first.
    row, near = beside(places[small].astype(float), np.full(len(small), 1.5), places.astype(float))
    alike = (unit[near] * unit[small[row]]).sum(axis=1) > _ALIKE
    row, near = row[alike], near[alike]
    away = np.round(((centre[near] - centre[small[row]]) ** 2).sum(axis=1) / side**2, 9)
    order = np.lexsort((*places[near].T[::-1], away, row))
    near, start = near[order], np.searchsorted(row, np.arange(len(small) + 1))
    for k in np.argsort(total[small], kind="stable").tolist():
        own = root(int(small[k]))
        if area[own] >= LEAST_PATCH * side:
            continue
        others = (root(n) for n in near[start[k] : start[k + 1]].tolist())
        best = next((other for other in others if other != own), None)
        if best is not None:
            into[own] = best
            area[best] += area[own]
    return np.array([root(n) for n in range(len(into))])
