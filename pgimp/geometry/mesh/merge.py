"""Corners of facets that are one point: equal ones, and ones that differ by rounding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.mesh.cells import Facets, unique_rows

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Distance of corners that are one, over the size of the mesh; single precision has 6e-8.
NEAR = 1e-6

#: Most points among which the near ones of each are looked for.
_FOLLOWING = 200


def merged(found: Facets, notes: list[str]) -> tuple[Reals, Ints, Ints]:
    """Return points, facets and their cells, where each corner is one point.

    Equal points are one. If that leaves a surface open, and one of near points too closes it, they
    are one as well.

    Parameters
    ----------
    found : Facets
        As read.
    notes : list of str
        Gets what was merged and dropped.
    """
    exact = list(notes)
    points, facets, cells = _equal(found, exact)
    result, said = (points, facets, cells), exact
    if not found.filled and _open(facets):
        near = list(notes)
        if other := _near(found, near, _open(facets)):
            result, said = other, near
    notes[:] = said
    return result


def _equal(found: Facets, notes: list[str]) -> tuple[Reals, Ints, Ints]:
    """Merge equal points, and drop collapsed and duplicate facets, with their cells."""
    points, cells = found.points + 0.0, found.cells  # -0.0 and 0.0 are one point
    used, facets = np.unique(found.facets, return_inverse=True)
    points = points[used]
    group, first, _ = unique_rows(np.ascontiguousarray(points).view(np.int64))
    points, facets = points[first], group[facets.reshape(-1, facets.shape[-1])]
    ordered = np.sort(facets, axis=1)
    flat = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if flat.any():
        notes.append(f"{int(flat.sum()):,} degenerate facets dropped")
        facets, ordered, cells = facets[~flat], ordered[~flat], cells[~flat]
    if len(facets) == 0:
        return points, facets, cells
    _, first, _ = unique_rows(ordered)
    if len(first) < len(facets):
        notes.append(f"{len(facets) - len(first):,} facets that are there twice dropped")
        facets, cells = facets[np.sort(first)], cells[np.sort(first)]
    return points, facets, cells


def _open(facets: Ints) -> int:
    """Number of edges, in 2D of corners, that belong to one facet."""
    if len(facets) == 0:
        return 0
    if facets.shape[1] == 2:
        keys = facets.reshape(-1, 1)
    else:
        keys = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2), axis=2)
        keys = keys.reshape(-1, 2)
    return int((unique_rows(keys)[2] == 1).sum())


def _near(found: Facets, notes: list[str], number: int) -> tuple[Reals, Ints, Ints] | None:
    """Merge near points; None if that leaves edges open, of which there were a number before."""
    used, corners = np.unique(found.facets, return_inverse=True)
    points = found.points[used]
    tolerance = NEAR * float(np.ptp(points, axis=0).max())
    first, apart = _near_points(points, tolerance)
    moved = found._replace(points=points[first], facets=corners.reshape(found.facets.shape))
    result = _equal(moved, notes)
    if _open(result[1]):
        return None
    what = "edges" if found.facets.shape[1] == 3 else "ends"
    notes.append(
        f"{number:,} open {what} closed: corners up to {apart:.2g} apart are one (the tolerance is "
        f"{tolerance:.2g}, {NEAR:g} of its size)"
    )
    return result


def _near_points(points: Reals, tolerance: float) -> tuple[Ints, float]:
    """First of the points that each point is near to, and the greatest distance of two of them."""
    D = points.shape[1]
    # Along a line across all usual planes, near points follow each other.
    along = points @ np.array([0.5377, 0.3131, 0.7829])[:D]
    order = np.argsort(along, kind="stable")
    first, apart = np.arange(len(points)), 0.0
    for step in range(1, min(len(points), _FOLLOWING)):
        a, b = order[:-step], order[step:]
        near = along[b] - along[a] <= tolerance
        if not near.any():
            break
        a, b = a[near], b[near]
        distance = np.linalg.norm(points[a] - points[b], axis=1)
        same = distance <= tolerance
        apart = max(apart, float(distance[same].max(initial=0.0)))
        a, b = a[same], b[same]
        while (first[a] != first[b]).any():
            least = np.minimum(first[a], first[b])
            np.minimum.at(first, a, least)
            np.minimum.at(first, b, least)
    while (first[first] != first).any():
        first = first[first]
    return first, apart
