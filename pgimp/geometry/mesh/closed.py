"""A closed surface from facets: merged, checked, and oriented outwards.

In 2D the outline is extended by one along a third direction, into the mantle of a prism. The
prism's ends are left out: they would cast no shadow. So one set of kernels serves 2D and 3D. The
directions are x, y, z, and in 2D x, the added one, y.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.mesh.cells import Facets, unique_rows
from pgimp.geometry.mesh.merge import NEAR, merged
from pgimp.geometry.mesh.tree import Surface, build_tree

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Most triangles through which lines are traced, to find overlapping parts.
_LOOKS = 20_000

#: Least slope of a triangle against a traced line.
_SLOPE = 1e-6

_NOT_NEAR = f", also if corners {NEAR:g} of its size apart are one, so it has no inside"


def enclose(found: Facets) -> Surface:
    """Make a surface of facets, (m, D) corners of (n, D) points.

    Raises
    ------
    CaseError
        Without the file's name, but with their number and a position: an open surface, edges of
        more than two facets, one-sided surfaces, overlapping parts.
    """
    notes, dimensions = list(found.notes), found.points.shape[1]
    points, facets, cells = merged(found, notes)
    if len(facets) == 0:
        raise CaseError("has no facet that is more than a point or a line")
    if dimensions == 3:
        pairs, turned = _neighbours(points, facets, found.filled, cells)
    else:
        pairs, turned = _corners(points, facets, found.filled, cells)
    if found.filled:
        # Cells define the inside: parts may touch in edges only, where facets are ambiguous.
        everything = np.zeros(len(facets), np.int64)
        if _volumes(_stretch(points, facets), everything)[0] < 0.0:
            facets = facets[:, ::-1]
        surface = build_tree(_stretch(points, facets), everything, dimensions)
        _check_lines(surface, points, facets, cells)
        return surface._replace(notes=tuple(notes), facets=len(facets))
    root, parity = _orient(points, facets, pairs, turned, cells)
    given = facets.copy()
    facets = _turned(facets, parity == 1)
    _, component = np.unique(root, return_inverse=True)
    triangles = _stretch(points, facets)
    # First all outward, then cavities inward.
    volumes = _volumes(triangles, component)
    inward = volumes[component] < 0.0
    facets = _turned(facets, inward)
    triangles = _stretch(points, facets)
    surface = build_tree(triangles, component, dimensions)
    depth = _depths(surface, triangles, component)
    if (holes := depth[component] % 2 == 1).any():
        facets = _turned(facets, holes)
        surface = build_tree(_stretch(points, facets), component, dimensions)
    changed = int((facets != given).any(axis=1).sum())
    what = "triangles" if dimensions == 3 else "segments"
    if changed == len(facets):
        notes.append(f"all {changed:,} {what} faced inwards, and were turned over")
    elif changed:
        notes.append(f"{changed:,} of {len(facets):,} {what} faced the wrong way; turned over")
    if cavities := int((depth % 2 == 1).sum()):
        notes.append(f"{cavities:,} inner surface{'s' * (cavities > 1)}: holes, left empty")
    _check_lines(surface, points, facets, cells)
    return surface._replace(notes=tuple(notes), facets=len(facets))


def _turned(facets: Ints, which: NDArray[np.bool_]) -> Ints:
    return np.where(which[:, None], facets[:, ::-1], facets)


def _place(at: Reals) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in at) + ")"


def _of(what: str, cells: Ints) -> str:
    """Name the cells by their numbers in the file, a few at most; empty if unknown."""
    numbers = [str(number) for number in np.unique(cells[cells >= 0])[:5]]
    if not numbers:
        return ""
    return f", of {what}{'s' * (len(numbers) > 1)} {', '.join(numbers)} (from 0)"


def _neighbours(
    points: Reals, facets: Ints, filled: bool, cells: Ints
) -> tuple[Ints, NDArray[np.bool_]]:
    """Pairs of triangles at an edge, and whether they run along it in the same direction.

    If cells fill the body, edges of more than two triangles are allowed: parts touch there.
    """
    start = facets.ravel()
    end = np.roll(facets, -1, axis=1).ravel()
    keys = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=1)
    group, first, counts = unique_rows(keys)
    for bad, what, why in (
        (counts == 1, "open edges", f"the surface is not closed{_NOT_NEAR}"),
        (
            (counts % 2 == 1) | ((counts > 2) & (not filled)),
            "edges with more than two triangles",
            "inside and outside cannot be told apart there",
        ),
    ):
        if number := int(bad.sum()):
            a, b = points[keys[first[bad][0]]]
            where = _of("triangle", cells[np.flatnonzero(group == bad.argmax()) // 3])
            raise CaseError(
                f"has {number:,} {what}, the first from {_place(a)} to {_place(b)}{where}: {why}; "
                "repair the mesh"
            )
    order = np.argsort(group, kind="stable")
    order = order[(counts == 2)[group[order]]].reshape(-1, 2)
    return order // 3, (start < end)[order[:, 0]] == (start < end)[order[:, 1]]


def _corners(
    points: Reals, facets: Ints, filled: bool, cells: Ints
) -> tuple[Ints, NDArray[np.bool_]]:
    """Pairs of segments at a corner, and whether both begin, or end, there."""
    corner = facets.ravel()
    group, first, counts = unique_rows(corner[:, None])
    for bad, what, why in (
        (counts == 1, "open ends", f"the outline is not closed{_NOT_NEAR}"),
        (
            (counts % 2 == 1) | ((counts > 2) & (not filled)),
            "corners with more than two segments",
            "inside and outside cannot be told apart there",
        ),
    ):
        if number := int(bad.sum()):
            at = _place(points[corner[first[bad][0]]])
            where = _of("segment", cells[np.flatnonzero(group == bad.argmax()) // 2])
            raise CaseError(
                f"has {number:,} {what}, the first at {at}{where}: {why}; repair the mesh"
            )
    order = np.argsort(group, kind="stable")
    order = order[(counts == 2)[group[order]]].reshape(-1, 2)
    return order // 2, order[:, 0] % 2 == order[:, 1] % 2


def _orient(
    points: Reals, facets: Ints, pairs: Ints, turned: NDArray[np.bool_], cells: Ints
) -> tuple[Ints, Ints]:
    """First facet of each facet's component, and whether to reverse the facet to agree with it."""
    from pgimp.geometry.mesh.treekernels import unite

    root, parity = np.arange(len(facets)), np.zeros(len(facets), np.int64)
    wrong = unite(np.ascontiguousarray(pairs), np.ascontiguousarray(turned), root, parity)
    if wrong >= 0:
        at = _place(points[facets[pairs[wrong, 0]]].mean(axis=0))
        where = _of("triangle", cells[pairs[wrong]])
        raise CaseError(
            f"has only one side, as a Moebius strip has, near {at}{where}; repair the mesh"
        )
    return root, parity


def _stretch(points: Reals, facets: Ints) -> Reals:
    """Corners of triangles, (n, 3, 3); each segment of an outline becomes a rectangle of two."""
    corners = points[facets]
    if points.shape[1] == 3:
        return np.ascontiguousarray(corners)
    a, b = corners[:, 0], corners[:, 1]

    def lift(end: Reals, w: float) -> Reals:
        return np.stack([end[:, 0], np.full(len(end), w), end[:, 1]], axis=1)

    low = np.stack([lift(a, 0.0), lift(a, 1.0), lift(b, 0.0)], axis=1)
    high = np.stack([lift(b, 0.0), lift(a, 1.0), lift(b, 1.0)], axis=1)
    return np.concatenate([low, high])


def _volumes(triangles: Reals, component: Ints) -> Reals:
    """Volume enclosed by each component, positive if it faces outwards."""
    component = np.resize(component, len(triangles))
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    p = triangles - 0.5 * (low + high)
    # By shadows along the last direction: a prism's missing ends have none.
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    shadow = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return np.bincount(component, shadow * p[:, :, 2].mean(axis=1)).astype(float)


def _depths(surface: Surface, triangles: Reals, component: Ints) -> Ints:
    """Number of other components around each one."""
    number = int(component.max()) + 1
    if number == 1:
        return np.zeros(1, np.int64)
    # At each component's largest triangle, where nearby triangles of others disturb least.
    size = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )[: len(component)]
    order = np.lexsort((-size, component))
    first = order[np.searchsorted(component[order], np.arange(number))]
    points = triangles[first].mean(axis=1)
    return surface.count_above(points, np.arange(number))


def _check_lines(surface: Surface, places: Reals, facets: Ints, cells: Ints) -> None:
    """Refuse overlapping parts of a surface: along a line, entries and exits must alternate.

    `facets` are the surface's facets with their `places`, in the order of their `cells`.
    """
    n = len(surface.triangles)
    chosen = np.linspace(0, n - 1, min(n, _LOOKS)).astype(np.int64)
    points = np.tensordot(surface.triangles[chosen], [0.37, 0.34, 0.29], axes=(1, 0))
    corners = surface.triangles[chosen]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    slopes = np.abs(normals) / np.linalg.norm(normals, axis=1, keepdims=True)
    slack = 1e-9 * float(np.ptp(places, axis=0).max())
    for axis in range(3):
        if surface.dimensions == 2 and axis == 1:
            continue
        # A line parallel to its triangle has no definite intersection.
        across = slopes[:, axis] > _SLOPE
        heights, signs = surface.meet(points[across], axis)
        order = np.argsort(heights, axis=1, kind="stable")
        heights = np.take_along_axis(heights, order, axis=1)
        within = -np.cumsum(np.take_along_axis(signs, order, axis=1), axis=1)
        gap = np.diff(heights, axis=1) > slack
        bad = np.argwhere(gap & ((within[:, :-1] < 0) | (within[:, :-1] > 1)))
        if len(bad):
            line, place = bad[0]
            at = points[across][line].copy()
            at[axis] = 0.5 * (heights[line, place] + heights[line, place + 1])
            at = at[[0, 2]] if surface.dimensions == 2 else at
            same = (_stretch(places, facets) == corners[across][line]).all(axis=(1, 2))
            what = "segment" if surface.dimensions == 2 else "triangle"
            where = _of(what, cells[np.flatnonzero(same) % len(facets)])
            raise CaseError(
                f"overlaps or cuts itself, for example at {_place(at)}, in line with a point"
                f"{where} ({len(bad):,} places of {len(points):,} lines looked along): inside and "
                "outside cannot be told apart; repair the mesh (a union of its parts)"
            )
