"""Means of a cell's weights over facets, which may reach into cells beside.

A facet counts as a parallelogram with its second moments. On its own body it is in one cell; in
the other body planes of the grid cut it. Its weights there are the means over all of it, piece by
piece. Those at its centroid miss the kinks of the weights: uniform pressure would not be uniform
at vertices.
"""

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.surfaces.motion import hat, set_means

#: What `spread_weights` fills, and scratch.
Pieces = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

#: Length in cells by which a facet has to reach into a cell beside.
_REACHES = 1e-9

#: Weights of a triangle's centroid, and of points on the lines from there to its corners, 3/5 of
#: the way from the corners' opposite sides: exact for cubic functions.
_MIDDLE, _POINT, _CORNER, _OTHER = -27.0 / 48.0, 25.0 / 48.0, 0.6, 0.2


def pieces_of(D: int) -> Pieces:
    """Allocate the pieces of a facet, see `spread_weights`."""
    count = 3**D + 1
    return np.zeros(count, np.int64), np.zeros((count, 2**D)), np.zeros((2, 16, 3)), np.zeros(3)


def kept_of(D: int, count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Allocate for so many pieces of facets that are kept within a step: cells, and weights."""
    return np.zeros(count, np.int64), np.zeros((count, 2**D))


def scratch_of(D: int) -> tuple[Any, ...]:
    """Allocate what `move_facets` and `find_gaps` need; the last are pieces that they keep."""
    return np.zeros((2**D, 4)), np.zeros(3), pieces_of(D), kept_of(D, 0)


@inner_kernel
def _clip(polygon, count, axis, at, side):
    """Cut off what is below a plane (`side` 1), or above it (-1); the number of corners left."""
    kept = 0
    for n in range(count):
        m = n + 1 if n + 1 < count else 0
        a, b = side * (polygon[0, n, axis] - at), side * (polygon[0, m, axis] - at)
        if a >= 0.0:
            for d in range(3):
                polygon[1, kept, d] = polygon[0, n, d]
            kept += 1
        if (a > 0.0 and b < 0.0) or (a < 0.0 and b > 0.0):
            t = a / (a - b)
            for d in range(3):
                begin = polygon[0, n, d]
                polygon[1, kept, d] = begin + t * (polygon[0, m, d] - begin)
            polygon[1, kept, axis] = at
            kept += 1
    for n in range(kept):
        for d in range(3):
            polygon[0, n, d] = polygon[1, n, d]
    return kept


@inner_kernel
def _add_polygon(polygon, count, whole, first, hats):
    """Add the integrals of weights over a polygon, over an area, in the cell at `first`."""
    p = polygon[0]
    for n in range(2, count):
        a, b = p[n - 1], p[n]
        square = 0.0
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            part = (a[e] - p[0, e]) * (b[f] - p[0, f]) - (a[f] - p[0, f]) * (b[e] - p[0, e])
            square += part * part
        share = 0.5 * sqrt(square) / whole
        for point in range(4):
            at = polygon[1, 0]
            for d in range(3):
                if point == 3:
                    at[d] = (p[0, d] + a[d] + b[d]) / 3.0 - first[d]
                else:
                    own = p[0, d] if point == 0 else (a[d] if point == 1 else b[d])
                    rest = p[0, d] + a[d] + b[d] - own
                    at[d] = _CORNER * own + _OTHER * rest - first[d]
            weight = share * (_MIDDLE if point == 3 else _POINT)
            for corner in range(8):
                hats[corner] += weight * hat(3, at, corner)


@inner_kernel
def _reaches(place, edges, d):
    """Whether a facet reaches into the cells below and above along an axis.

    Only then are there pieces in these, and is what is beyond the plane cut off from others.
    """
    reach = abs(edges[0, d]) + abs(edges[1, d])
    return place[d] - reach < -_REACHES, place[d] + reach > 1.0 + _REACHES


@inner_kernel
def _set_polygon(place, edges, ways, polygon):
    """Set the part of a parallelogram in a cell beside, or in the cell; the number of corners."""
    count = 4
    for n in range(4):
        s, r = 1.0 if n in (0, 3) else -1.0, 1.0 if n < 2 else -1.0
        for d in range(3):
            polygon[0, n, d] = place[d] + s * edges[0, d] + r * edges[1, d]
    for d in range(3):
        below, above = _reaches(place, edges, d)
        if ways[d] > 0.0 or (ways[d] == 0.0 and below):
            count = _clip(polygon, count, d, 1.0 if ways[d] > 0.0 else 0.0, 1.0)
        if ways[d] < 0.0 or (ways[d] == 0.0 and above):
            count = _clip(polygon, count, d, 0.0 if ways[d] < 0.0 else 1.0, -1.0)
    return count


@inner_kernel
def _set_segment(place, edges, ways, part):
    """Set place and half the length of the part of a line in a cell beside; its share."""
    low, high = -1.0, 1.0
    for d in range(2):
        e, (below, above) = edges[0, d], _reaches(place, edges, d)
        if e == 0.0:
            continue
        if ways[d] > 0.0 or (ways[d] == 0.0 and below):
            t = ((1.0 if ways[d] > 0.0 else 0.0) - place[d]) / e
            if e > 0.0:
                low = max(low, t)
            else:
                high = min(high, t)
        if ways[d] < 0.0 or (ways[d] == 0.0 and above):
            t = ((0.0 if ways[d] < 0.0 else 1.0) - place[d]) / e
            if e > 0.0:
                high = min(high, t)
            else:
                low = max(low, t)
    for d in range(2):
        part[0, d] = place[d] + 0.5 * (low + high) * edges[0, d]
        part[1, d] = 0.5 * (high - low) * edges[0, d]
        part[2, d] = 0.0
    return max(0.0, 0.5 * (high - low))


@inner_kernel
def _meets(D, place, edges, d):
    """Bits of where a parallelogram reaches along `d`: below a cell, in it, above it."""
    if d >= D:
        return 2
    reach, found = abs(edges[0, d]) + abs(edges[1, d]), 0
    below, above = _reaches(place, edges, d)
    if below:
        found |= 1
    if not (below and place[d] + reach <= 0.0) and not (above and place[d] - reach >= 1.0):
        found |= 2
    if above:
        found |= 4
    return found


@inner_kernel
def _find_pieces(D, cells, c, place, edges, pieces):
    """Find the pieces of a parallelogram in a cell and in those beside it; how many there are.

    Cells that are not known count as the one at hand, continued.
    """
    number, hats, scratch, ways = pieces
    inside, whole, size, found = True, 0.0, 0.0, 0
    for d in range(D):
        reach = abs(edges[0, d]) + abs(edges[1, d]) - _REACHES
        inside = inside and place[d] >= reach and place[d] <= 1.0 - reach
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        whole += (edges[0, e] * edges[1, f] - edges[0, f] * edges[1, e]) ** 2
        size += abs(edges[0, d]) + abs(edges[1, d])
        ways[d] = 0.0
    if inside or D == 1 or size == 0.0 or (D == 3 and whole == 0.0):
        number[0] = c
        set_means(D, place, edges, hats[0])
        return 1
    whole = 4.0 * sqrt(whole)
    x, y, z = _meets(D, place, edges, 0), _meets(D, place, edges, 1), _meets(D, place, edges, 2)
    for way in range(27):
        there = way % 3, way // 3 % 3, way // 9
        if not (x >> there[0] & 1 and y >> there[1] & 1 and z >> there[2] & 1):
            continue
        cell = c
        for d in range(D):
            ways[d] = there[d] - 1.0
            if there[d] != 1:
                cell = cells.beside[cell, 2 * d + there[d] // 2] if cell >= 0 else -1
        own = hats[found]
        if D == 2:
            share = _set_segment(place, edges, ways, scratch[0])
            for d in range(2):
                scratch[0, 0, d] -= ways[d] if cell >= 0 else 0.0
            set_means(D, scratch[0, 0], scratch[0, 1:3], own)
            for corner in range(1 << D):
                own[corner] *= share
        else:
            count = _set_polygon(place, edges, ways, scratch)
            for d in range(3):
                ways[d] = ways[d] if cell >= 0 else 0.0
            for corner in range(1 << D):
                own[corner] = 0.0
            _add_polygon(scratch, count, whole, ways, own)
        number[found] = cell if cell >= 0 else c
        found += 1
    return found


@inner_kernel
def _slope(D, place, corner, axis):
    """Derivative of `hat` along an axis."""
    w = 1.0 if corner >> (D - 1 - axis) & 1 else -1.0
    for d in range(D):
        if d != axis:
            w *= place[d] if corner >> (D - 1 - d) & 1 else 1.0 - place[d]
    return w


@inner_kernel
def spread_weights(D, cells, c, near, pieces):
    """Find the cells that a facet is in, with the means of the weights of their vertices over it.

    Parameters
    ----------
    c : int
        The cell with its centroid.
    near : NEAR_FACET
        The facet, with its place, edges and offset.
    pieces : ((3^D + 1,) int64, (3^D + 1, 2^D) float64, (2, 16, 3) float64, (3,) float64)
        Filled: cells and weights, which add up to 1; scratch.

    Returns
    -------
    int
        How many there are.
    """
    number, hats = pieces[0], pieces[1]
    count = _find_pieces(D, cells, c, near.place, near.edges, pieces)
    number[count] = c
    set_offset(D, near, hats[count])
    return count + 1


@inner_kernel
def set_offset(D, near, hats):
    """Set what a facet's offset adds to the weights of the cell with its centroid."""
    for corner in range(1 << D):
        w = 0.0
        for d in range(D):
            w += near.offset[d] * _slope(D, near.place, corner, d)
        hats[corner] = w


@inner_kernel
def keep_pieces(D, near, used, pieces, count, kept):
    """Keep the pieces of a facet, if there is room from `used` on; the number of those kept."""
    numbers, hats = kept
    near.piece, near.pieces = used, 0
    if used + count > len(numbers):
        return used
    near.pieces = count
    for n in range(count):
        numbers[used + n] = pieces[0][n]
        for corner in range(1 << D):
            hats[used + n, corner] = pieces[1][n, corner]
    return used + count


@inner_kernel
def mean_position(frame, cells, u, pieces, count, x):
    """Set a facet's mean position, by the cells that it is in, see `spread_weights`."""
    D, number, hats = len(frame.cell), pieces[0], pieces[1]
    for d in range(3):
        x[d] = 0.0
    for n in range(count):
        c = number[n]
        for corner in range(1 << D):
            w, v = hats[n, corner], cells.corners[c, corner]
            for d in range(3):
                at = cells.low[c, d] + u[v, d]
                if d < D:
                    at += frame.cell[d] * (corner >> (D - 1 - d) & 1)
                x[d] += w * at
