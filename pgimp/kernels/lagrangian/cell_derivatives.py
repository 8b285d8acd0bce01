"""Derivatives of the displacements at the particles of a lattice cell, direction by direction.

The derivative along a direction depends on the particle's place along the others only. So it is
found once for all particles that share these: with u = u0 + x u' along a direction, u' the
difference of the vertices over the length of the cell.

A slice is the particles of a plane across x in 3D, and all particles in 2D. Vectors hold a number
that is not used and three components.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import inlined, of_types
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, stack, store

#: Most particles of a cell along a direction.
MAX_PER_CELL = 4


class CellSizes(NamedTuple):
    """Numbers of particles of a cell, known to the compiler."""

    dimension: int  #: 2 or 3.
    #: slices, rows, columns: Slices of a cell, and particles of a slice along its `first` and
    #: `second` direction.
    slices: int
    rows: int
    columns: int
    groups: int  #: Groups of four particles of a slice.
    planes: int  #: Planes of the cell's vertices in a slice's sums: 2 in 3D, else 1.
    #: first, second: Directions of a slice.
    first: int
    second: int


@of_types
def sizes(per_cell) -> CellSizes:
    """Return the sizes for the Numba type of `Cells.per_cell`."""
    counts = [len(each) for each in per_cell]
    D = len(counts)
    groups = -(-counts[-2] * counts[-1] // 4)
    return CellSizes(
        D, counts[0] if D == 3 else 1, counts[-2], counts[-1], groups, D - 1, D - 2, D - 1
    )


@inlined
def sizes_of(cells) -> CellSizes:
    """Sizes of `Cells`."""
    return sizes(cells.per_cell)


class Derivatives(NamedTuple):
    """Buffers for the derivatives of a cell's displacements."""

    u: Any  #: buffer: Displacements of the corners.
    edges: Any  #: buffer: Derivatives along x on the cell's edges, in 3D.
    #: buffer: Derivatives along x by group of four particles of a slice, component by component, in
    #: 3D.
    across: Any
    first: Any  #: buffer: Derivatives along the first direction of a slice, by column.
    second: Any  #: buffer: Derivatives along the second direction of a slice, by row.
    scratch: Any  #: buffer: Values in between.


@inlined
def derivative_buffers():
    """Buffers of `Derivatives`."""
    return Derivatives(stack(32), stack(16), stack(48), stack(16), stack(16), stack(64))


@inlined
def load_corners(cells, motion, at, strides, u):
    """Load the displacements of a cell's corners, whose first is at `at`, into the buffer `u`."""
    planes = sizes_of(cells).planes
    sa, sb, sc = strides
    for a in range(planes):
        for i in range(4):
            r = at + a * sa + (i // 2) * sb + (i % 2) * sc
            store(u, 16 * a + 4 * i, load(motion, r))


@inlined
def derive_across(cells, buffers):
    """Derivatives along x of the corners' displacements, in 3D: at all slices the same."""
    D, _, rows, columns, groups, _, _, _ = sizes_of(cells)
    if D == 2:
        return None
    u, edges, places = buffers.u, buffers.edges, buffers.scratch
    inverse, fractions = cells.setting.frame.inverse[0], cells.fractions
    for i in range(4):
        store(edges, 4 * i, inverse * (load(u, 16 + 4 * i) - load(u, 4 * i)))
    low, high = load(edges, 0), load(edges, 4)
    rise, higher = load(edges, 8) - low, load(edges, 12) - high
    for r in range(rows):
        y = fractions[MAX_PER_CELL + r]
        left, right = y * rise + low, y * higher + high
        change = right - left
        for s in range(columns):
            store(places, 4 * (r * columns + s), fractions[2 * MAX_PER_CELL + s] * change + left)
    for group in range(groups):
        a, b, c, d = _of_slice(cells, group)
        found = _components(places, a, b, c, d)
        for k in range(3):
            store(buffers.across, 12 * group + 4 * k, found[k])


@inlined
def derive_slice(cells, q, buffers):
    """Derivatives of the displacements along the directions of slice `q`."""
    D, _, rows, columns, _, _, first, second = sizes_of(cells)
    three = D == 3
    u, values, frame = buffers.u, buffers.scratch, cells.setting.frame
    for i in range(4):
        value = load(u, 4 * i)
        if three:
            value = cells.distances[q] * load(buffers.edges, 4 * i) + value
        store(values, 4 * i, value)
    low, high, inverse = load(values, 0), load(values, 4), frame.inverse[first]
    rise, higher = inverse * (load(values, 8) - low), inverse * (load(values, 12) - high)
    change, inverse = higher - rise, frame.inverse[second]
    for s in range(columns):
        store(buffers.first, 4 * s, cells.fractions[second * MAX_PER_CELL + s] * change + rise)
    for r in range(rows):
        y = cells.distances[first * MAX_PER_CELL + r]
        store(buffers.second, 4 * r, inverse * ((y * higher + high) - (y * rise + low)))


@inlined
def deformations_of_four(cells, buffers, group):
    """Deformation gradients of four particles of a slice; beyond its last one, of that one."""
    D, _, _, columns, _, _, _, _ = sizes_of(cells)
    if D == 2:
        a, b, c, d = _of_slice(cells, group)
        X = _components(buffers.first, a % columns, b % columns, c % columns, d % columns)
        Y = _components(buffers.second, a // columns, b // columns, c // columns, d // columns)
        return 1.0 + X[0], Y[0], X[1], 1.0 + Y[1]
    a, b, c, d = _of_slice(cells, group)
    X, at = buffers.across, 12 * group
    Y = _components(buffers.first, a % columns, b % columns, c % columns, d % columns)
    Z = _components(buffers.second, a // columns, b // columns, c // columns, d // columns)
    return (
        1.0 + load(X, at), Y[0], Z[0],
        load(X, at + 4), 1.0 + Y[1], Z[1],
        load(X, at + 8), Y[2], 1.0 + Z[2],
    )  # fmt: skip


@inlined
def _of_slice(cells, group):
    """Numbers of the particles of a group of four in their slice, at most its last one's."""
    last = sizes_of(cells).rows * sizes_of(cells).columns - 1
    return (4 * group, min(4 * group + 1, last), min(4 * group + 2, last), min(4 * group + 3, last))


@inlined
def _components(buffer, a, b, c, d):
    """Components, each of four vectors of a buffer."""
    return transpose(
        load(buffer, 4 * a), load(buffer, 4 * b), load(buffer, 4 * c), load(buffer, 4 * d)
    )[1:]
