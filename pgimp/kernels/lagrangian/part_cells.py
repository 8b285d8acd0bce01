"""Forces of parts of particles cell by cell, from the vertices' displacements.

Bodies that are exact to their surface have parts of particles beside it, whose places in their cell
are their own. About a cell's lowest corner its displacements are, with t from 0 to 1,

    u = u0 + a_x t_x + a_y t_y + a_z t_z + a_yz t_y t_z + a_xz t_x t_z + a_xy t_x t_y
        + a_xyz t_x t_y t_z.

So means of the gradients over a part need the means of t and of its products there only. Sums of
their adjoint over the parts are a cell's forces. Elsewhere `pgimp.kernels.transfer.parts` has
the same means by vertex. Materials are elastic.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, is_record
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import join, load, number, stack, store, vector
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.lagrangian.cell_derivatives import load_corners, sizes_of
from pgimp.kernels.lagrangian.cell_matrices import (
    groups_of,
    keep_eight,
    keep_four,
    matrices,
    most_together,
    of_eight,
    of_four,
)
from pgimp.kernels.lagrangian.cells import add_corners, elastic_stresses, raise_rate, widened


class PartCells(NamedTuple):
    """Cells with parts of particles, as `Cells`, which have them as `parts`."""

    start: IntArray  #: (layers + 1,) int64: Beginning of each layer.
    place: IntArray  #: (cells,) int64: Offset of the lowest vertex in its plane.
    material: IntArray  #: (cells,) int64: Number of the material.
    first: IntArray  #: (cells + 1,) int64: First group of four particles of each cell.
    volumes: FloatArray  #: (4 groups,) float64: Initial volumes, 0 without a particle.
    #: (4 groups * `place_numbers`,) float64: By group, four times each: means of t_x, t_y, and in
    #: 3D of t_z, t_y t_z, t_x t_z and t_x t_y.
    places: FloatArray


@inlined
def place_numbers(D):
    """Numbers of a part's place."""
    return 6 if D == 3 else 2


@inlined
def add_parts(cells, field, layer, span):
    """Add the forces of the parts of a layer to its planes; see `add_cells`."""
    if not is_record(cells):
        return span
    if not is_record(cells.parts):
        return span
    D, _, _, _, _, _, first, second = sizes_of(cells)
    parts, window = cells.parts, field.window
    strides = window.stride[0], window.stride[first], window.stride[second]
    inverse = 0.0
    for d in range(D):
        inverse = max(inverse, cells.setting.frame.inverse[d])
    fastest = join(vector(0.0), vector(0.0))
    u, a, f, sums, P = stack(32), stack(32), stack(32), stack(84), matrices(cells)
    low, high = strides[0], -1
    cell, end = parts.start[layer], parts.start[layer + 1]
    while cell < end:
        behind = _end_together(cells, cell, end)
        begin, groups = parts.first[cell], parts.first[behind] - parts.first[cell]
        for k in range(cell, behind):
            at = layer * strides[0] + parts.place[k]
            load_corners(cells, field.motion.values, at, strides, u)
            _expand(D, u, a)
            for group in range(parts.first[k], parts.first[k + 1]):
                keep_four(P, group - begin, _deformations(cells, a, 4 * group))
        for pair in range((groups + 1) // 2):
            slot = 4 * (begin + 2 * pair)
            V, more = load(parts.volumes, slot), vector(0.0)
            if 2 * pair + 1 < groups:
                more = load(parts.volumes, slot + 4)
            stress, fastest = elastic_stresses(
                cells, parts.material[cell], len(cells.volumes) + slot, join(V, more),
                of_eight(cells, P, pair), inverse, fastest,
            )  # fmt: skip
            keep_eight(P, pair, stress)
        for k in range(cell, behind):
            for i in range(0, 84, 4):
                store(sums, i, vector(0.0))
            for group in range(parts.first[k], parts.first[k + 1]):
                _sum_four(cells, of_four(cells, P, group - begin), 4 * group, sums)
            _contract(D, sums, f)
            low, high = min(low, parts.place[k]), max(high, parts.place[k])
            add_corners(cells, field.scratch, parts.place[k], strides, f)
        cell = behind
    raise_rate(cells, fastest)
    return widened(window, D, low, high, span)


@inlined
def _end_together(cells, cell, end):
    """Cell behind those whose stresses are found together, from `cell` on and below `end`."""
    sizes, parts = sizes_of(cells), cells.parts
    most = parts.first[cell] + groups_of(sizes) * most_together(sizes)
    behind = cell + 1
    while (
        behind < end
        and parts.first[behind + 1] <= most
        and parts.material[behind] == parts.material[cell]
    ):
        behind += 1
    return behind


@inlined
def _expand(D, u, a):
    """Coefficients a of the displacements `u` of a cell's corners, in the order of the formula."""
    u0, z, y = load(u, 0), load(u, 4), load(u, 8)
    if D == 2:
        store(a, 0, y - u0)
        store(a, 4, z - u0)
        store(a, 8, (load(u, 12) - y) - (z - u0))
    else:
        yz, x, xz, xy = load(u, 12), load(u, 16), load(u, 20), load(u, 24)
        store(a, 0, x - u0)
        store(a, 4, y - u0)
        store(a, 8, z - u0)
        store(a, 12, (yz - y) - (z - u0))
        store(a, 16, (xz - x) - (z - u0))
        store(a, 20, (xy - x) - (y - u0))
        store(a, 24, ((load(u, 28) - xy) - (xz - x)) - ((yz - y) - (z - u0)))


@inlined
def _deformations(cells, a, slot):
    """Deformation gradients of four particles from `slot` on, row-major."""
    D, inverse, places = sizes_of(cells).dimension, cells.setting.frame.inverse, cells.parts.places
    at = place_numbers(D) * slot
    x, y = load(places, at), load(places, at + 4)
    if D == 2:
        X = tuple(inverse[0] * (y * number(a, 9 + i) + number(a, 1 + i)) for i in range(2))
        Y = tuple(inverse[1] * (x * number(a, 9 + i) + number(a, 5 + i)) for i in range(2))
        return 1.0 + X[0], Y[0], X[1], 1.0 + Y[1]
    z, yz, xz, xy = tuple(load(places, at + 4 * i) for i in range(2, 6))
    X = tuple(
        inverse[0] * ((z * number(a, 17 + i) + number(a, 1 + i))
                      + (yz * number(a, 25 + i) + y * number(a, 21 + i)))
        for i in range(3)
    )  # fmt: skip
    Y = tuple(
        inverse[1] * ((z * number(a, 13 + i) + number(a, 5 + i))
                      + (xz * number(a, 25 + i) + x * number(a, 21 + i)))
        for i in range(3)
    )  # fmt: skip
    Z = tuple(
        inverse[2] * ((y * number(a, 13 + i) + number(a, 9 + i))
                      + (xy * number(a, 25 + i) + x * number(a, 17 + i)))
        for i in range(3)
    )  # fmt: skip
    return 1.0 + X[0], Y[0], Z[0], X[1], 1.0 + Y[1], Z[1], X[2], Y[2], 1.0 + Z[2]


@inlined
def _add(sums, k, i, value):
    """Add a vector to the sums of component `i` for coefficient `k`."""
    at = 12 * k + 4 * i
    store(sums, at, load(sums, at) + value)


@inlined
def _sum_four(cells, P, slot, sums):
    """Add what -V0 P of four particles does at the coefficients a, particle by particle."""
    D, inverse, places = sizes_of(cells).dimension, cells.setting.frame.inverse, cells.parts.places
    at = place_numbers(D) * slot
    x, y = load(places, at), load(places, at + 4)
    if D == 2:
        for i in range(2):
            X, Y = inverse[0] * P[2 * i], inverse[1] * P[2 * i + 1]
            _add(sums, 0, i, X)
            _add(sums, 1, i, Y)
            _add(sums, 2, i, y * X + x * Y)
        return
    z, yz, xz, xy = tuple(load(places, at + 4 * i) for i in range(2, 6))
    for i in range(3):
        X, Y, Z = inverse[0] * P[3 * i], inverse[1] * P[3 * i + 1], inverse[2] * P[3 * i + 2]
        _add(sums, 0, i, X)
        _add(sums, 1, i, Y)
        _add(sums, 2, i, Z)
        _add(sums, 3, i, z * Y + y * Z)
        _add(sums, 4, i, z * X + x * Z)
        _add(sums, 5, i, y * X + x * Y)
        _add(sums, 6, i, (yz * X + xz * Y) + xy * Z)


@inlined
def _total(D, sums, k):
    """Sum over the four particles at coefficient `k`, a vector behind a number not used."""
    third = load(sums, 12 * k + 8) if D == 3 else vector(0.0)
    a, b, c, d = transpose(vector(0.0), load(sums, 12 * k), load(sums, 12 * k + 4), third)
    return (a + b) + (c + d)


@inlined
def _contract(D, sums, f):
    """Forces at a cell's corners, into the buffer `f`: the adjoint of `_expand`."""
    x, y, z = tuple(_total(D, sums, k) for k in range(3))
    if D == 2:  # there z is of t_x t_y
        store(f, 0, z - (x + y))
        store(f, 4, y - z)
        store(f, 8, x - z)
        store(f, 12, z)
    else:
        yz, xz, xy, xyz = tuple(_total(D, sums, k) for k in range(3, 7))
        store(f, 0, ((yz + xz) + (xy - xyz)) - ((x + y) + z))
        store(f, 4, z - ((yz - xyz) + xz))
        store(f, 8, y - ((yz - xyz) + xy))
        store(f, 12, yz - xyz)
        store(f, 16, x - ((xz - xyz) + xy))
        store(f, 20, xz - xyz)
        store(f, 24, xy - xyz)
        store(f, 28, xyz)
