"""Means of a cell's weights over facets, which may reach into cells beside.

A facet counts as a parallelogram with its second moments. On its own body it is in one cell; in
the other body planes of the grid cut it. Its weights there are the means over all of it, piece by
piece. Those at its centroid miss the kinks of the weights: uniform pressure would not be uniform
at vertices.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.vectors.rows import load_row, store_row, transpose
from pgimp.jit.vectors.simd import pack, vector
from pgimp.kernels.contact.surfaces.motion import set_hats, set_means

#: What `spread_weights` fills, and scratch.
Pieces = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

#: Length in cells by which a facet has to reach into a cell beside.
_REACHES = 1e-9

#: Corners of a polygon, at most.
_CORNERS = 16

#: Weights of a triangle's centroid, and of points on the lines from there to its corners, 3/5 of
#: the way from the corners' opposite sides: exact for cubic functions.
_MIDDLE, _POINT, _CORNER, _OTHER = -27.0 / 48.0, 25.0 / 48.0, 0.6, 0.2


def pieces_of(D: int) -> Pieces:
    """Allocate the pieces of a facet, see `spread_weights`."""
    count = 3**D + 1
    polygon = np.zeros((2 * _CORNERS, 4))
    return np.zeros(count, np.int64), np.zeros((count, 2**D)), polygon, np.zeros(3)


def kept_of(D: int, count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Allocate for so many pieces of facets that are kept within a step: cells, and weights."""
    return np.zeros(count, np.int64), np.zeros((count, 2**D))


def scratch_of(D: int) -> tuple[Any, ...]:
    """Allocate what `move_facets` and `find_gaps` need; the last are pieces that they keep."""
    return np.zeros((2 * 2**D, 4)), pieces_of(D), kept_of(D, 0)


@inner_kernel
def _clip(polygon, count, axis, at, side):
    """Cut off what is below a plane (`side` 1), or above it (-1); the number of corners left."""
    kept, end = _CORNERS, load_row(polygon, 0, 0)
    for n in range(count):
        begin, m = end, n + 1 if n + 1 < count else 0
        end = load_row(polygon, m, 0)
        a, b = side * (polygon[n, axis] - at), side * (polygon[m, axis] - at)
        if a >= 0.0:
            store_row(polygon, kept, 0, begin)
            kept += 1
        if (a > 0.0 and b < 0.0) or (a < 0.0 and b > 0.0):
            t = a / (a - b)
            store_row(polygon, kept, 0, t * (end - begin) + begin)
            polygon[kept, axis] = at
            kept += 1
    for n in range(kept - _CORNERS):
        store_row(polygon, n, 0, load_row(polygon, _CORNERS + n, 0))
    return kept - _CORNERS


@inner_kernel
def _set_polygon_means(polygon, count, whole, first, hats, row):
    """Set the integrals of weights over a polygon, over an area, in the cell at `first`.

    `whole` are an axis, and the component of the vector of that area along it.
    """
    p, zero, (axis, area) = polygon, vector(0.0), whole
    i, j, inverse = (axis + 1) % 3, (axis + 2) % 3, 0.5 / area
    weights = pack(_POINT, _POINT, _POINT, _MIDDLE)
    one, mx, my, mz, myz, mxz, mxy, mxyz = zero, zero, zero, zero, zero, zero, zero, zero
    for n in range(2, count):
        a, b = p[n - 1], p[n]
        part = (a[i] - p[0, i]) * (b[j] - p[0, j]) - (a[j] - p[0, j]) * (b[i] - p[0, i])
        w = (inverse * part) * weights
        x = _points(p[0, 0], a[0], b[0], first[0])
        y = _points(p[0, 1], a[1], b[1], first[1])
        z = _points(p[0, 2], a[2], b[2], first[2])
        wx, wy, yz = w * x, w * y, y * z
        one, mx, my, mz, mxy = one + w, mx + wx, my + wy, w * z + mz, wx * y + mxy
        myz, mxz, mxyz = w * yz + myz, wx * z + mxz, wx * yz + mxyz
    a, b, c, d = transpose(one, mz, my, myz)
    store_row(hats, row, 0, (a + b) + (c + d))
    a, b, c, d = transpose(mx, mxz, mxy, mxyz)
    store_row(hats, row, 4, (a + b) + (c + d))
    set_hats(3, hats[row])


@inner_kernel
def _points(a, b, c, first):
    """Coordinates of a triangle's four points, in lanes, from that of a cell."""
    rest = _OTHER * (a + b + c) - first
    own = _CORNER - _OTHER
    return pack(own * a + rest, own * b + rest, own * c + rest, (a + b + c) / 3.0 - first)


@inner_kernel
def _reaches(place, edges, d):
    """Whether a facet reaches into the cells below (1) and above (2) along an axis."""
    reach = abs(edges[0, d]) + abs(edges[1, d])
    below = 1 if place[d] - reach < -_REACHES else 0
    return below | (2 if place[d] + reach > 1.0 + _REACHES else 0)


@inner_kernel
def _known(cells, c, cut, d, side):
    """Whether there is a cell below or above along an axis, beside any that a facet reaches into.

    Without one the facet is not cut there: weights are continued.
    """
    e, f = (d + 1) % 3, (d + 2) % 3
    for i in range(3):
        if i > 0 and not cut >> 2 * e & i:
            continue
        m = cells.beside[c, 2 * e + i - 1] if i > 0 else c
        for j in range(3 if m >= 0 else 0):
            if j > 0 and not cut >> 2 * f & j:
                continue
            n = cells.beside[m, 2 * f + j - 1] if j > 0 else m
            if n >= 0 and cells.beside[n, 2 * d + side] >= 0:
                return True
    return False


@inner_kernel
def _set_polygon(place, edges, ways, cut, polygon):
    """Set the part of a parallelogram in a cell beside, or in the cell; the number of corners.

    `cut` has the bits of axes and sides on which it is cut.
    """
    count = 4
    for n in range(4):
        s, r = 1.0 if n in (0, 3) else -1.0, 1.0 if n < 2 else -1.0
        for d in range(3):
            polygon[n, d] = place[d] + s * edges[0, d] + r * edges[1, d]
    for d in range(3):
        if ways[d] > 0.0 or (ways[d] == 0.0 and cut >> 2 * d & 1):
            count = _clip(polygon, count, d, 1.0 if ways[d] > 0.0 else 0.0, 1.0)
        if ways[d] < 0.0 or (ways[d] == 0.0 and cut >> 2 * d & 2):
            count = _clip(polygon, count, d, 0.0 if ways[d] < 0.0 else 1.0, -1.0)
    return count


@inner_kernel
def _set_segment(place, edges, ways, cut, part):
    """Set place and half the length of the part of a line in a cell beside; its share."""
    low, high = -1.0, 1.0
    for d in range(2):
        e = edges[0, d]
        if e == 0.0:
            continue
        if ways[d] > 0.0 or (ways[d] == 0.0 and cut >> 2 * d & 1):
            t = ((1.0 if ways[d] > 0.0 else 0.0) - place[d]) / e
            if e > 0.0:
                low = max(low, t)
            else:
                high = min(high, t)
        if ways[d] < 0.0 or (ways[d] == 0.0 and cut >> 2 * d & 2):
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
def _meets(place, edges, cut, d):
    """Bits of where a parallelogram reaches along `d`: below a cell, in it, above it."""
    reach, cut = abs(edges[0, d]) + abs(edges[1, d]), cut >> 2 * d & 3
    found = cut & 1 | (cut & 2) << 1
    if not (cut & 1 and place[d] + reach <= 0.0) and not (cut & 2 and place[d] - reach >= 1.0):
        found |= 2
    return found


@inner_kernel
def find_pieces(D, cells, c, near, pieces):
    """Find the pieces of a facet in its cell and in those beside it; how many there are.

    See `spread_weights`. Cells that are not known count as the one at hand, continued.
    """
    number, hats, place, edges = pieces[0], pieces[1], near.place, near.edges
    cut, known, whole, size, found, axis = 0, 0, 0.0, 0.0, 0, 0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        part = 4.0 * (edges[0, e] * edges[1, f] - edges[0, f] * edges[1, e])
        if abs(part) > abs(whole):
            whole, axis = part, d
        size += abs(edges[0, d]) + abs(edges[1, d])
    for d in range(D if size > 0.0 else 0):  # of no size: of material, whose cells have none beside
        cut |= _reaches(place, edges, d) << 2 * d
    for d in range(D):
        for side in range(2):
            if cut >> (2 * d + side) & 1 and _known(cells, c, cut, d, side):
                known |= 1 << (2 * d + side)
    if known == 0 or D == 1 or size == 0.0 or (D == 3 and whole == 0.0):
        number[0] = c
        set_means(D, place, edges, hats[0])
        return 1
    x, y, z = (_meets(place, edges, known, 0), _meets(place, edges, known, 1), 2)
    if D == 3:
        z = _meets(place, edges, known, 2)
    for k in range(3):
        for j in range(3 if z >> k & 1 else 0):
            for i in range(3 if y >> j & 1 else 0):
                if x >> i & 1:
                    at = (i, j, k), found
                    _add_piece(D, cells, c, near, (known, (axis, whole)), at, pieces)
                    found += 1
    return found


@inner_kernel
def _add_piece(D, cells, c, near, sizes, at, pieces):
    """Add the piece of a facet in its cell, or in one beside it, see `_meets`.

    `sizes` are the sides on which it is cut, and its area, see `_set_polygon_means`; `at` the cell,
    and the pieces so far.
    """
    (number, every, scratch, ways), (cut, whole), (there, found), cell = pieces, sizes, at, c
    for d in range(3):
        ways[d] = there[d] - 1.0
        if there[d] != 1:
            cell = cells.beside[cell, 2 * d + there[d] // 2] if cell >= 0 else -1
    number[found], hats = cell if cell >= 0 else c, every[found]
    if D == 2:
        share = _set_segment(near.place, near.edges, ways, cut, scratch)
        for d in range(2):
            scratch[0, d] -= ways[d] if cell >= 0 else 0.0
        set_means(D, scratch[0], scratch[1:3], hats)
        for corner in range(1 << D):
            hats[corner] *= share
    else:
        count = _set_polygon(near.place, near.edges, ways, cut, scratch)
        for d in range(3):
            ways[d] = ways[d] if cell >= 0 else 0.0
        _set_polygon_means(scratch, count, whole, ways, every, found)


@inner_kernel
def spread_weights(D, cells, c, near, pieces):
    """Find the cells that a facet is in, with the means of the weights of their vertices over it.

    Parameters
    ----------
    c : int
        The cell with its centroid.
    near : NEAR_FACET
        The facet, with its place, edges and offset.
    pieces : ((3^D + 1,) int64, (3^D + 1, 2^D) float64, (32, 4) float64, (3,) float64)
        Filled: cells and weights, which add up to 1; scratch.

    Returns
    -------
    int
        How many there are.
    """
    return add_offset(D, c, near, pieces, find_pieces(D, cells, c, near, pieces))


@inner_kernel
def add_offset(D, c, near, pieces, count):
    """Add what a facet's offset adds to the weights of the cell with its centroid; the new count.

    It is the derivative of weights along the offset.
    """
    hats, x, o = pieces[1][count], near.place, near.offset
    pieces[0][count], hats[0] = c, 0.0
    for d in range(D):
        hats[1 << (D - 1 - d)] = o[d]
    if D == 2:
        hats[3] = o[0] * x[1] + x[0] * o[1]
    if D == 3:
        hats[3], hats[5] = o[1] * x[2] + x[1] * o[2], o[0] * x[2] + x[0] * o[2]
        hats[6] = o[0] * x[1] + x[0] * o[1]
        hats[7] = o[0] * x[1] * x[2] + x[0] * hats[3]
    set_hats(D, hats)
    return count + 1


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
        if D == 3:
            store_row(hats, used + n, 0, load_row(pieces[1], n, 0))
            store_row(hats, used + n, 4, load_row(pieces[1], n, 4))
        else:
            for corner in range(1 << D):
                hats[used + n, corner] = pieces[1][n, corner]
    return used + count


@inner_kernel
def mean_displacement(D, cells, u, pieces, count):
    """Mean displacement over a facet in lanes, by its pieces, see `find_pieces`."""
    way, hats = vector(0.0), pieces[1]
    for n in range(count):
        c = pieces[0][n]
        for corner in range(1 << D):
            way = hats[n, corner] * load_row(u, cells.corners[c, corner], 0) + way
    return way
