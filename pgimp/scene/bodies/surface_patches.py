"""Patches of the surfaces of bodies, about a cell each, on which contact acts.

A facet is an element of a surface, see `pgimp.scene.bodies.surface_elements`: nearly flat, with
area, normal and centroid. A patch is the facets in one cell of the grid with normals near one
direction. Small ones join a neighbour.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.scene.bodies.elements import Indices, Reals
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import Closed, find_elements

#: Least area of a facet, and of a patch that does not join another, over that of a cell's side.
LEAST_FACET, LEAST_PATCH = 1e-6, 0.5

#: Least cosine between the normals of patches that join.
_ALIKE = 0.5


class Facets(NamedTuple):
    """Facets of surfaces, those of a patch together; of three components each vector."""

    x: Reals  #: (n, 3) float64: Centroids in the initial state.
    normal: Reals  #: (n, 3) float64: Unit normals, out of the body.
    area: Reals  #: (n,) float64: Areas.
    #: middle, half: (n, 3) float64: Middle and half-sides of the part of a box that each is in.
    middle: Reals
    half: Reals
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
    found = find_elements(body, None, (low - 1, high + 1), closed)
    size = np.sqrt((found.area * found.area).sum(axis=1))
    side = float(np.prod(cell)) ** (1.0 - 1.0 / len(cell))
    some = size > LEAST_FACET * side
    found, size = found.chosen(some), size[some]
    normal = found.area / size[:, None]
    x = found.centroid
    # A surface between two boxes has an element in each.
    places = np.rint(1e6 * np.column_stack([x / body.size, normal])) + 0.0
    _, first, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
    size = np.bincount(same.reshape(-1), size)
    found, x, normal = found.chosen(first), x[first], normal[first]
    patch = _patches(x, normal, size, origin, cell, side)
    order = np.argsort(patch, kind="stable")
    return Facets(
        _three(x[order]),
        _three(normal[order]),
        size[order],
        _three(found.centre[order]),
        _three(found.half[order]),
        patch[order],
    )


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
    places, patch = np.unique(keys, axis=0, return_inverse=True)
    patch = patch.reshape(-1)
    places = places[:, :-1]
    total = np.bincount(patch, area)
    centre, mean = (
        np.stack([np.bincount(patch, area * v[:, d]) for d in range(x.shape[1])], axis=1)
        for v in (x, normal)
    )
    into = _joins(places, total, centre / total[:, None], mean, side)
    return np.unique(into[patch], return_inverse=True)[1].reshape(-1)


def _joins(places: Indices, total: Reals, centre: Reals, mean: Reals, side: float) -> Indices:
    """The patch that each patch is part of: small ones join the nearest whose normal is alike."""
    into = np.arange(len(total))
    small = np.flatnonzero(total < LEAST_PATCH * side)
    if not len(small):
        return into
    by_place: dict[tuple[int, ...], list[int]] = {}
    for number, place in enumerate(places.tolist()):
        by_place.setdefault(tuple(place), []).append(number)
    steps = np.stack(np.meshgrid(*[[-1, 0, 1]] * places.shape[1]), axis=-1)
    steps = steps.reshape(-1, places.shape[1]).tolist()
    unit = mean / np.sqrt((mean * mean).sum(axis=1))[:, None]
    area = total.copy()

    def root(one: int) -> int:
        while into[one] != one:
            one = int(into[one])
        return one

    for one in small[np.argsort(total[small], kind="stable")].tolist():
        own = root(one)
        if area[own] >= LEAST_PATCH * side:
            continue
        near = [
            other
            for step in steps
            for other in by_place.get(
                tuple(a + b for a, b in zip(places[one], step, strict=True)), ()
            )
        ]
        near = [n for n in near if root(n) != own and float(unit[n] @ unit[one]) > _ALIKE]
        if not near:
            continue
        away = [round(float(((centre[n] - centre[one]) ** 2).sum()) / side**2, 9) for n in near]
        best = root(near[int(np.argmin(away))])
        into[own] = best
        area[best] += area[own]
    return np.array([root(n) for n in range(len(into))])
