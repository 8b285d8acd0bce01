"""The corners of four particles' parallelograms, in the buffer for supports on the stack.

Transfers by them are in `pgimp.kernels.transfer.cornertransfer`.
"""

from math import floor

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.jit.vectors.simd import store, vector
from pgimp.kernels.transfer.first_vertex import first_vertex
from pgimp.physics.shapes.base import edges, size

#: In the buffer for supports each corner has 16 numbers, four for each of four particles. They are
#: the position in its cell along each direction, and from `CELL` on the offset of the cell's first
#: vertex from the support's. The rows of A^-1, per length, and the half edges, in cells, come after
#: the numbers of `pgimp.kernels.transfer.supports`.
CORNER, CELL, INVERSE, EDGES = 16, 12, 152, 188


@inlined
def _inverse(E):
    """Rows of the inverse of the matrix with the columns `E`."""
    if len(E) == 2:
        a, b = E
        r = 1.0 / (a[0] * b[1] - a[1] * b[0])
        return (r * b[1], -r * b[0]), (-r * a[1], r * a[0])
    a, b, c = E
    n = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
    m = (c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0])
    k = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    r = 1.0 / (a[0] * n[0] + a[1] * n[1] + a[2] * n[2])
    return scaled(r, n), scaled(r, m), scaled(r, k)


@inlined
def _keep_rows(buffer, at, rows, factors):
    """Store rows, their entries multiplied by `factors`, one after the other."""
    for k, row in enumerate(rows):
        for i, each in enumerate(row):
            store(buffer, at + 4 * (k * len(factors) + i), each * factors[i])


@inlined
def cell_of(f):
    """Number of the cell, counted from the support's first vertex, of a corner at `f`; and t.

    Rounding may put a corner at an end of the support beyond it.
    """
    i = min(max(floor(f), 0.0), 2.0)
    return i, min(max(f - i, 0.0), 1.0)


@inlined
def _keep_corner(buffer, at, d, f, stride):
    """Store a corner's positions along the directions from `d` on; returns the cell's offset."""
    if len(f) == 0:
        return vector(0.0)
    i, t = cell_of(f[0])
    store(buffer, at + 4 * d, t)
    return i * stride[0] + _keep_corner(buffer, at, d + 1, f[1:], stride[1:])


@inlined
def _keep_each(buffer, c, f, E, stride):
    """Store the corners c, c + 1, ... at f - and + each of the half edges `E`."""
    if len(E) == 0:
        at = CORNER * c
        store(buffer, at + CELL, _keep_corner(buffer, at, 0, f, stride))
    else:
        _keep_each(buffer, 2 * c, plus_scaled(-1.0, E[0], f), E[1:], stride)
        _keep_each(buffer, 2 * c + 1, plus_scaled(1.0, E[0], f), E[1:], stride)


@inlined
def _from_first(frame, window, d, half, x, vertex):
    """Coordinates relative to the support's first vertices, and the offset of these.

    Along direction `d` the first vertex is `vertex`.
    """
    if len(x) == 1:
        f = (x[0] - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
        return (f,), vector(0.0)
    first = first_vertex(frame, d + 1, half[1], x[1])
    rest, offset = _from_first(frame, window, d + 1, half[1:], x[1:], first)
    f = (x[0] - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
    return (f, *rest), offset + (first - window.lower[d + 1]) * window.stride[d + 1]


@inlined
def keep_corners(shape, frame, window, F, x, layer, buffer, arms):
    """Store the supports of four particles in a buffer; returns the offsets of first vertices.

    See `pgimp.kernels.transfer.supports.supports`, which calls this.
    """
    armed = not is_empty(arms)
    ones = (1.0,) * len(x)
    E = edges(shape, F)
    f, offset = _from_first(frame, window, 0, size(shape, frame.cell, F)[0], x, layer)
    _keep_each(buffer, 0, f, E, window.stride)
    _keep_rows(buffer, INVERSE, _inverse(E), frame.inverse)
    if armed:
        _keep_rows(buffer, EDGES, E, ones)
    return offset
