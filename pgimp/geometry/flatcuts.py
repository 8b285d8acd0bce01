"""Intersections of flat surfaces at any angle within boxes that are measured.

At these intersections the part inside, as a function of a coordinate, has a kink. A line in which
two planes meet leaves a box through one of its faces; three planes meet in a point.
"""

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.regions.base import Points, Region

Reals = NDArray[np.float64]
Rows = NDArray[np.int64]

#: Most tilted planes of a region that are considered; with more, boxes in which several meet have
#: an error of second order.
MAX_PLANES = 16


def corners(
    region: Region, points: Points, boxes: tuple[Points, Points], row: Rows, axes: tuple[int, ...]
) -> Iterator[tuple[Rows, Reals]]:
    """Yield the coordinates, along the first of `axes`, at which tilted planes meet within pieces.

    Parameters
    ----------
    region : Region
        Region with the flat surfaces; ignored if more than `MAX_PLANES` are tilted.
    points : (n, D) float64
        Coordinates of the pieces but in the directions `axes`.
    boxes, row : ((m, D) float64, (m, D) float64), (n,) int64
        Low and high corners of boxes, and the box of each piece.
    axes : tuple of int
        The remaining directions of integration.

    Yields
    ------
    rows, cuts : (k,) int64 and (k,) float64
        Pieces, and coordinates between their ends.
    """
    D = points.shape[1]
    if len(axes) < 2:
        return
    flats = list(dict.fromkeys(flat for part in region.simple() for flat in part.flats()))
    tilted = [flat for flat in flats if sum(n != 0.0 for n in flat.normal) > 1]
    if not 2 <= len(tilted) <= MAX_PLANES:
        return
    (low, high), offsets, near = (end[row] for end in boxes), [], []
    for normal, foot in tilted:
        offsets.append(sum(n * x for n, x in zip(normal, foot, strict=True)))
        away, reach = np.full(len(points), -offsets[-1]), np.zeros(len(points))
        for d in range(D):
            a, b = (low[:, d], high[:, d]) if d in axes else (points[:, d], points[:, d])
            away += normal[d] * (0.5 * (a + b))
            reach += abs(normal[d]) * (0.5 * (b - a))
        near.append(np.abs(away) <= reach * (1.0 + 1e-9))
    for k in range(2, len(axes) + 1):
        for chosen in combinations(range(len(tilted)), k):
            rows = np.flatnonzero(np.logical_and.reduce([near[i] for i in chosen]))
            if len(rows) == 0:
                continue
            planes = [(tilted[i].normal, offsets[i]) for i in chosen]
            for held in combinations(axes[1:], len(axes) - k):
                free = [d for d in axes if d not in held]
                matrix = np.array([[normal[d] for d in free] for normal, _ in planes])
                if abs(np.linalg.det(matrix)) < 1e-12:
                    continue
                inverse = np.linalg.inv(matrix)
                for ends in product((0, 1), repeat=len(held)):
                    at = points[rows]
                    for d, end in zip(held, ends, strict=True):
                        at[:, d] = (low, high)[end][rows, d]
                    yield _within(_meet(planes, inverse, free, at), rows, low, high, free)


def _meet(
    planes: list[tuple[tuple[float, ...], float]], inverse: Reals, free: list[int], at: Points
) -> list[Reals]:
    """Coordinates `free` of the intersections of planes n.x = b; the others are given by `at`."""
    rest = []
    for normal, offset in planes:
        rest.append(np.full(len(at), offset))
        for d in range(at.shape[1]):
            if d not in free:
                rest[-1] -= normal[d] * at[:, d]
    found = []
    for row in inverse:
        found.append(np.zeros(len(at)))
        for factor, value in zip(row, rest, strict=True):
            found[-1] += factor * value
    return found


def _within(
    places: list[Reals], rows: Rows, low: Points, high: Points, free: list[int]
) -> tuple[Rows, Reals]:
    """Rows of the pieces that contain the points, and first coordinates, between the ends.

    The other coordinates have a tolerance: rounding may put a point beyond a face.
    """
    inside = np.ones(len(rows), bool)
    for i, (x, d) in enumerate(zip(places, free, strict=True)):
        a, b = low[rows, d], high[rows, d]
        slack = 1e-9 * (b - a) * (i > 0)
        inside &= (a - slack < x) & (x < b + slack)
    return rows[inside], places[0][inside]
