"""Forces of a lattice cell's particles at its corners: the adjoint of the derivatives.

A stress along a direction acts on the particle's line along it as a whole, so that it is summed
over the line first; see `pgimp.kernels.lagrangian.cell_derivatives`.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.simd import load, stack, store
from pgimp.kernels.lagrangian.cell_derivatives import MAX_PER_CELL, sizes_of
from pgimp.kernels.lagrangian.cell_matrices import of_four
from pgimp.kernels.update.piola import keep_vectors


class Stresses(NamedTuple):
    """Buffers for -V0 P of a cell's particles, P the first Piola-Kirchhoff stress."""

    across: Any  #: buffer: Column of x summed over slices, as in `Derivatives.across`, in 3D.
    #: first, second: buffer: Columns of both directions of a slice, by particle.
    first: Any
    second: Any
    lines: Any  #: buffer: Forces of a slice at the four lines of the cell along x.
    sums: Any  #: buffer: These of all slices, and their moments about the lower ends.


@inlined
def stress_buffers():
    """Buffers of `Stresses`."""
    return Stresses(stack(48), stack(64), stack(64), stack(16), stack(32))


@inlined
def _keep_stresses(stresses, q, group, P):
    """Store -V0 P of a group of four particles of slice `q`, row-major matrices of vectors."""
    if len(P) == 4:
        keep_vectors(stresses.first, 16 * group, P[0], P[2], 0.0)
        keep_vectors(stresses.second, 16 * group, P[1], P[3], 0.0)
    else:
        at = 16 * group
        _sum(stresses.across, 12 * group, q, P[0])
        _sum(stresses.across, 12 * group + 4, q, P[3])
        _sum(stresses.across, 12 * group + 8, q, P[6])
        keep_vectors(stresses.first, at, P[1], P[4], P[7])
        keep_vectors(stresses.second, at, P[2], P[5], P[8])


@inlined
def _sum(buffer, at, q, value):
    """Add a vector of slice `q` to a sum, which the first slice begins."""
    if q > 0:
        value = load(buffer, at) + value
    store(buffer, at, value)


@inlined
def _add_slice(cells, q, stresses):
    """Add the forces of slice `q` along its directions to the sums at the lines along x."""
    D, _, rows, columns, _, _, first, second = sizes_of(cells)
    three = D == 3
    frame, lines = cells.setting.frame, stresses.lines
    fractions, distances = cells.fractions, cells.distances
    whole = _along_first(cells, stresses, 0)
    high = fractions[second * MAX_PER_CELL] * whole
    for s in range(1, columns):
        force = _along_first(cells, stresses, s)
        whole, high = whole + force, fractions[second * MAX_PER_CELL + s] * force + high
    end = _along_second(cells, stresses, 0)
    moment = distances[first * MAX_PER_CELL] * end
    for r in range(1, rows):
        force = _along_second(cells, stresses, r)
        end, moment = end + force, distances[first * MAX_PER_CELL + r] * force + moment
    inverse = frame.inverse[second]
    end, moment, inverse = inverse * end, inverse * moment, frame.inverse[first]
    low, high = inverse * ((whole - high) - moment), inverse * (high + moment)
    store(lines, 0, -low - end)
    store(lines, 4, end - high)
    store(lines, 8, low)
    store(lines, 12, high)
    for i in range(4):
        force = load(lines, 4 * i)
        _sum(stresses.sums, 4 * i, q, force)
        if three:
            moment = distances[q] * force
            if q > 0:
                moment = distances[q] * force + load(stresses.sums, 16 + 4 * i)
            store(stresses.sums, 16 + 4 * i, moment)


@inlined
def _along_first(cells, stresses, s):
    """Sum of the stresses on a line along the first direction, of column `s` of a slice."""
    _, _, rows, columns, _, _, _, _ = sizes_of(cells)
    force = load(stresses.first, 4 * s)
    for r in range(1, rows):
        force = force + load(stresses.first, 4 * (r * columns + s))
    return force


@inlined
def _along_second(cells, stresses, r):
    """Sum of the stresses on a line along the second direction, of row `r` of a slice."""
    columns = sizes_of(cells).columns
    force = load(stresses.second, 4 * r * columns)
    for s in range(1, columns):
        force = force + load(stresses.second, 4 * (r * columns + s))
    return force


@inlined
def cell_forces(cells, P, group, stresses, f):
    """Forces at the corners of a cell, into the buffer `f`.

    `P` has -V0 P, see `pgimp.kernels.lagrangian.cell_matrices`, from group number `group` on.
    """
    _, slices, _, _, groups, _, _, _ = sizes_of(cells)
    for q in range(slices):
        for i in range(groups):
            _keep_stresses(stresses, q, i, of_four(cells, P, group + q * groups + i))
        _add_slice(cells, q, stresses)
    _end_cell(cells, stresses, f)


@inlined
def _end_cell(cells, stresses, f):
    """Forces at the corners of a cell from those at its lines along x."""
    D, _, rows, columns, groups, _, _, _ = sizes_of(cells)
    if D == 2:
        for i in range(4):
            store(f, 4 * i, load(stresses.sums, 4 * i))
        return
    fractions, sums, at = cells.fractions, stresses.sums, stresses.first
    for group in range(groups):
        X, i = stresses.across, 12 * group
        keep_vectors(at, 16 * group, load(X, i), load(X, i + 4), load(X, i + 8))
    f00, f01, f10, f11 = load(sums, 16), load(sums, 20), load(sums, 24), load(sums, 28)
    for r in range(rows):
        whole = load(at, 4 * r * columns)
        high = fractions[2 * MAX_PER_CELL] * whole
        for s in range(1, columns):
            force = load(at, 4 * (r * columns + s))
            whole, high = whole + force, fractions[2 * MAX_PER_CELL + s] * force + high
        y, low = fractions[MAX_PER_CELL + r], whole - high
        a, b = y * low, y * high
        f00, f01, f10, f11 = f00 + (low - a), f01 + (high - b), f10 + a, f11 + b
    inverse = cells.setting.frame.inverse[0]
    store(f, 16, inverse * f00)
    store(f, 20, inverse * f01)
    store(f, 24, inverse * f10)
    store(f, 28, inverse * f11)
    for i in range(4):
        store(f, 4 * i, load(sums, 4 * i) - load(f, 16 + 4 * i))
