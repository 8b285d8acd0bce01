"""Rows of the coupling matrix B: what moves an end of a pair, see `gauss_seidel`."""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, vector, where
from pgimp.kernels.contact.impulses.reference_grid import OF_INVERSE_MASS
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Least part of the squares of a row of B at free vertices. Below it the few free vertices would
#: have to compensate for the prescribed ones at many times the speed.
LEAST_FREE = 0.25

#: Greatest component of a normal across which a patch counts as free, if any vertex is.
_ASKEW = 0.5


class Coupling(NamedTuple):
    """Rows of the coupling matrix B for the contact pairs."""

    start: IntArray  #: (rows + 1,) int64: First entry of each row.
    column: IntArray  #: (k,) int64: Numbers of reference vertices.
    entry: FloatArray  #: (k, 1) float64: The entries of B.
    #: (rows, 3) float64: Inverse mass sum_j B_ij^2/m_j, by component, without held vertices, see
    #: `LEAST_FREE`.
    answer: FloatArray

    @classmethod
    def empty(cls, rows: int, entries: int) -> "Coupling":
        """Allocate for so many rows and entries."""
        return cls(
            np.zeros(rows + 1, np.int64), np.empty(entries, np.int64), np.empty((entries, 1)),
            np.empty((rows, 3)),
        )  # fmt: skip


@inner_kernel
def set_answer(coupling, r, numbers):
    """Set the inverse mass of a contact vertex, sum_j B_ij^2/m_j; 0 if nearly all is held."""
    column, entry, start = coupling.column, coupling.entry, coupling.start
    found, gives, every = vector(0.0), vector(0.0), vector(0.0)
    for k in range(start[r], start[r + 1]):
        square = vector(entry[k, 0] ** 2)
        mobility = load_row(numbers, column[k], OF_INVERSE_MASS)
        found = square * mobility + found
        every = every + square
        gives = gives + where(mobility == 0.0, vector(0.0), square)
    for d in range(3):
        free = lane(gives, d) >= LEAST_FREE * lane(every, d)
        coupling.answer[r, d] = lane(found, d) if free else 0.0


@inner_kernel
def release_across(coupling, r, numbers, normal):
    """Restore the inverse mass of row `r` in directions nearly across the normal.

    There `set_answer` takes a patch for held whose vertices are so for the most part. The other
    half of a body, beyond a plane of symmetry, would move its free vertices all the same.
    """
    for d in range(3):
        if coupling.answer[r, d] != 0.0 or abs(normal[d]) > _ASKEW:
            continue
        found = 0.0
        for k in range(coupling.start[r], coupling.start[r + 1]):
            found += coupling.entry[k, 0] ** 2 * numbers[coupling.column[k], OF_INVERSE_MASS + d]
        coupling.answer[r, d] = found


@inner_kernel
def velocity_of(coupling, r, numbers, first):
    """Velocity at a contact vertex, by row `r` of B; that of vertices is from `first` on."""
    v = vector(0.0)
    for k in range(coupling.start[r], coupling.start[r + 1]):
        v = coupling.entry[k, 0] * load_row(numbers, coupling.column[k], first) + v
    return lane(v, 0), lane(v, 1), lane(v, 2)
