"""Rows of the coupling matrix B in the sweeps: the velocities there, and impulses by rows."""

from typing import NamedTuple, Self

import numpy as np
from numpy import uint64  # of offsets: numbers below 0 would be looked for
from numpy.typing import NDArray

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import bits, pack, vector, where
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.reference_grid import OF_INVERSE_MASS
from pgimp.kernels.data.particles import FloatArray


class Solved(NamedTuple):
    """Reference vertices as the sweeps read and change them, four solved a row."""

    #: velocity, inverse_mass, held_impulse: (m, 4) float64: See `REFERENCE_VERTEX`; the last is
    #: the contact impulse that faces and constraints bear.
    velocity: FloatArray
    inverse_mass: FloatArray
    held_impulse: FloatArray
    #: (k,) float64: Change of each entry's vertex by a unit impulse, for the rows that are `free`.
    #: There may be room for more entries and rows.
    moved: FloatArray
    free: NDArray  #: (rows,) bool: Whether all components of a row's vertices are free.
    #: (rows, 3) float64: Compliance of the pairs' own, by row; none, of 0 rows, on the grid.
    soft: FloatArray

    @classmethod
    def empty(cls, vertices: int, coupling: Coupling) -> Self:
        """Allocate for so many vertices, for `begin_solution`."""
        entries, rows = len(coupling.column), len(coupling.answer)
        parts = np.empty((3, vertices, 4))
        return cls(*parts, np.empty(entries), np.empty(rows, np.bool_), np.empty((0, 3)))


@inner_kernel
def _uniform(frame, inverse_mass, j):
    """Inverse mass of a vertex that is free and has one for all components; else -1."""
    mobility = inverse_mass[j, 0]
    for d in range(len(frame.cell)):
        if not 0.0 != inverse_mass[j, d] == mobility:
            return -1.0
    return mobility


@kernel
def begin_solution(frame, values, coupling, solved):
    """Copy the vertices; find the rows whose vertices are free, and how an impulse moves these.

    Parameters
    ----------
    values : (m, NUMBERS) float64
        The records of `ReferenceVertices`.
    """
    start, column, entry = coupling.start, coupling.column, coupling.entry
    inverse_mass, zero = solved.inverse_mass, vector(0.0)
    for j in range(len(values)):
        store_row(solved.velocity, j, 0, load_row(values, j, 0))
        store_row(inverse_mass, j, 0, load_row(values, j, OF_INVERSE_MASS))
        # Until the rows are found, the last one of the four, which nothing reads.
        store_row(solved.held_impulse, j, 0, zero)
        solved.held_impulse[j, 3] = _uniform(frame, inverse_mass, j)
    for r in range(len(coupling.answer)):
        free = True
        for k in range(start[r], start[r + 1]):
            mobility = solved.held_impulse[column[k], 3]
            free = free and mobility >= 0.0
            solved.moved[k] = entry[k, 0] * mobility
        solved.free[r] = free


@inner_kernel
def velocity_at(r, coupling, solved):
    """Velocity at a contact vertex by row `r` of B, in lanes."""
    column, entry, velocity = coupling.column, coupling.entry, solved.velocity
    k, end, v = coupling.start[r], coupling.start[r + 1], vector(0.0)
    a, b, c = vector(0.0), vector(0.0), vector(0.0)
    while k + 4 <= end:  # four sums: none waits for another
        m, n, o, p = uint64(k), uint64(k + 1), uint64(k + 2), uint64(k + 3)
        v = entry[m, 0] * load_row(velocity, column[m], 0) + v
        a = entry[n, 0] * load_row(velocity, column[n], 0) + a
        b = entry[o, 0] * load_row(velocity, column[o], 0) + b
        c = entry[p, 0] * load_row(velocity, column[p], 0) + c
        k += 4
    v = (v + a) + (b + c)
    while k < end:
        v = entry[k, 0] * load_row(velocity, column[k], 0) + v
        k += 1
    return v


@inner_kernel
def _add_held_impulse(r, every, stiff, coupling, solved):
    """Apply an impulse by a row of which nearly all is held, in the components of the mask `stiff`.

    Its inverse mass is zero in these, so none of its vertices moves: what holds the others bears
    all of the impulse, by the squares of their entries. Else the sweeps would not converge.
    """
    start, column, entry = coupling.start, coupling.column, coupling.entry
    whole, square = vector(0.0), vector(0.0)
    for k in range(start[r], start[r + 1]):
        b = vector(entry[k, 0])
        held = load_row(solved.inverse_mass, column[k], 0) == 0.0
        whole, square = whole + b, where(held, square + b * b, square)
    for k in range(start[r], start[r + 1]):
        j, b = column[k], vector(entry[k, 0])
        mobility = load_row(solved.inverse_mass, j, 0)
        v, lost = load_row(solved.velocity, j, 0), load_row(solved.held_impulse, j, 0)
        store_row(solved.velocity, j, 0, where(stiff, v, v + b * every * mobility))
        borne = where(stiff, whole * b * b / square, b) * every
        store_row(solved.held_impulse, j, 0, where(mobility == 0.0, lost + borne, lost))


@inner_kernel
def add_impulse(r, J, sign, coupling, solved):
    """Apply an impulse to the reference vertices of an end of a pair, with row `r`."""
    start, column, entry = coupling.start, coupling.column, coupling.entry
    every, answer, velocity = pack(J[0], J[1], J[2], 0.0), coupling.answer, solved.velocity
    if solved.free[r]:
        every = sign * every
        for k in range(start[r], start[r + 1]):
            n = uint64(k)
            j = column[n]
            store_row(velocity, j, 0, solved.moved[n] * every + load_row(velocity, j, 0))
        return
    stiff = pack(answer[r, 0], answer[r, 1], answer[r, 2], 1.0) == 0.0
    if bits(stiff) != 0:
        _add_held_impulse(r, sign * every, stiff, coupling, solved)
        return
    for k in range(start[r], start[r + 1]):
        j = column[k]
        given = (sign * entry[k, 0]) * every
        mobility = load_row(solved.inverse_mass, j, 0)
        v = given * mobility + load_row(solved.velocity, j, 0)
        store_row(solved.velocity, j, 0, v)
        held = mobility == 0.0
        if bits(held) & 7 != 0:
            lost = load_row(solved.held_impulse, j, 0)
            store_row(solved.held_impulse, j, 0, where(held, given + lost, lost))
