"""Forces of a lattice cell's particles at its corners: the adjoint of the derivatives.

A stress along a direction acts on the particle's line along it as a whole, so that it is summed
over the line first; see `pgimp.kernels.lagrangian.cell_derivatives`.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import specialise
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, stack, store, vector
from pgimp.kernels.lagrangian.cell_derivatives import MOST, sizes_of


class Stresses(NamedTuple):
    """Buffers for -V0 P of a cell's particles, P the first Piola-Kirchhoff stress.

    Attributes
    ----------
    across : buffer
        Column of x summed over slices, as in `Derivatives.across`, in 3D.
    first, second : buffer
        Columns of both directions of a slice, by particle.
    lines : buffer
        Forces of a slice at the four lines of the cell along x.
    sums : buffer
        These of all slices, and their moments about the lower ends.
    """

    across: Any
    first: Any
    second: Any
    lines: Any
    sums: Any


def stress_buffers():
    """Buffers of `Stresses`."""


@specialise(stress_buffers)
def _stress_buffers():
    return lambda: Stresses(stack(48), stack(64), stack(64), stack(16), stack(32))


def begin_stresses(cells, stresses):
    """Set the sums over slices to zero."""


@specialise(begin_stresses)
def _begin_stresses(cells, stresses):
    D, _, _, _, groups, _, _, _ = sizes_of(cells)
    three = D == 3

    def begin(cells, stresses):
        for i in range(8):
            store(stresses.sums, 4 * i, vector(0.0))
        for i in range(3 * groups if three else 0):
            store(stresses.across, 4 * i, vector(0.0))

    return begin


def keep_stresses(stresses, group, P):
    """Store -V0 P of a group of four particles of a slice, row-major matrices of vectors."""


@specialise(keep_stresses)
def _keep_stresses(stresses, group, P):
    def plane(stresses, group, P):
        _keep(stresses.first, 16 * group, P[0], P[2], 0.0)
        _keep(stresses.second, 16 * group, P[1], P[3], 0.0)

    def space(stresses, group, P):
        X, at = stresses.across, 12 * group
        store(X, at, load(X, at) + P[0])
        store(X, at + 4, load(X, at + 4) + P[3])
        store(X, at + 8, load(X, at + 8) + P[6])
        _keep(stresses.first, 16 * group, P[1], P[4], P[7])
        _keep(stresses.second, 16 * group, P[2], P[5], P[8])

    return plane if len(P) == 4 else space


def _keep(buffer, at, x, y, z):
    """Store the vectors (0, x, y, z) of four particles."""


@specialise(_keep)
def _keep_transposed(buffer, at, x, y, z):
    def keep(buffer, at, x, y, z):
        of = transpose(vector(0.0), vector(x), vector(y), vector(z))
        store(buffer, at, of[0])
        store(buffer, at + 4, of[1])
        store(buffer, at + 8, of[2])
        store(buffer, at + 12, of[3])

    return keep


def add_slice(cells, q, stresses):
    """Add the forces of slice `q` along its directions to the sums at the lines along x."""


@specialise(add_slice)
def _add_slice(cells, q, stresses):
    D, _, rows, columns, _, _, first, second = sizes_of(cells)
    three = D == 3

    def add(cells, q, stresses):
        frame, sums = cells.setting.frame, stresses.sums
        whole, high = vector(0.0), vector(0.0)
        for s in range(columns):
            along = load(stresses.first, 4 * s)
            for r in range(1, rows):
                along = along + load(stresses.first, 4 * (r * columns + s))
            whole = whole + along
            high = cells.fractions[second * MOST + s] * along + high
        end, moment = vector(0.0), vector(0.0)
        for r in range(rows):
            along = load(stresses.second, 4 * r * columns)
            for s in range(1, columns):
                along = along + load(stresses.second, 4 * (r * columns + s))
            end = end + along
            moment = cells.distances[first * MOST + r] * along + moment
        inverse = frame.inverse[second]
        end, moment, inverse = inverse * end, inverse * moment, frame.inverse[first]
        low, high = inverse * ((whole - high) - moment), inverse * (high + moment)
        lines = stresses.lines
        store(lines, 0, -low - end)
        store(lines, 4, end - high)
        store(lines, 8, low)
        store(lines, 12, high)
        for i in range(4):
            f = load(lines, 4 * i)
            store(sums, 4 * i, load(sums, 4 * i) + f)
            if three:
                store(sums, 16 + 4 * i, cells.distances[q] * f + load(sums, 16 + 4 * i))

    return add


def cell_forces(cells, stresses, f):
    """Forces at the corners of a cell, into the buffer `f`."""


@specialise(cell_forces)
def _cell_forces(cells, stresses, f):
    D, _, rows, columns, groups, _, _, _ = sizes_of(cells)

    def plane(cells, stresses, f):
        for i in range(4):
            store(f, 4 * i, load(stresses.sums, 4 * i))

    def space(cells, stresses, f):
        fractions, sums, at = cells.fractions, stresses.sums, stresses.first
        for group in range(groups):
            X, i = stresses.across, 12 * group
            _keep(at, 16 * group, load(X, i), load(X, i + 4), load(X, i + 8))
        f00, f01, f10, f11 = load(sums, 16), load(sums, 20), load(sums, 24), load(sums, 28)
        for r in range(rows):
            whole, high = vector(0.0), vector(0.0)
            for s in range(columns):
                of = load(at, 4 * (r * columns + s))
                whole = whole + of
                high = fractions[2 * MOST + s] * of + high
            y, low = fractions[MOST + r], whole - high
            a, b = y * low, y * high
            f00, f01, f10, f11 = f00 + (low - a), f01 + (high - b), f10 + a, f11 + b
        inverse = cells.setting.frame.inverse[0]
        store(f, 16, inverse * f00)
        store(f, 20, inverse * f01)
        store(f, 24, inverse * f10)
        store(f, 28, inverse * f11)
        for i in range(4):
            store(f, 4 * i, load(sums, 4 * i) - load(f, 16 + 4 * i))

    return plane if D == 2 else space
