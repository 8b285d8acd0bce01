"""Coupling matrix B between contact vertices and reference vertices, see `gauss_seidel`.

Each particle extrapolates its velocity to the contact vertex x_i with its velocity gradient:

    B_ij = sum_p m_p S_ip (S0_jp + grad S0_jp . F_p^-1 (x_i - x_p)) / sum_p m_p S_ip.

So an affine motion is exact at the vertex, instead of averaged to the mean position of the
particles around it. With the mean alone surfaces are stiff, and friction has too short a lever.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel, specialise
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, vector, where
from pgimp.kernels.contact.lagrangian.reference_grid import OF_INVERSE_MASS, is_turned, reflection
from pgimp.kernels.contact.lagrangian.supports import vertex_at
from pgimp.kernels.contact.lagrangian.vertices import number_of
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Least part of the squares of a row of B at free vertices. Below it the few free vertices would
#: have to compensate for the prescribed ones at many times the speed.
LEAST_FREE = 0.25


class Coupling(NamedTuple):
    """Rows of the coupling matrix B for the contact pairs.

    Attributes
    ----------
    start : (rows + 1,) int64
        First entry of each row.
    column : (k,) int64
        Numbers of reference vertices.
    entry : (k, 1) or (k, 4) float64
        The entries of B, with mirrors by component: they reverse the component across them.
    answer : (rows, 3) float64
        Inverse mass sum_j B_ij^2/m_j, by component, without held vertices, see `LEAST_FREE`.
    beyond : (rows, mirrors, 3) float64
        Reversed share of an impulse, by mirror: the weight of the vertices beyond each mirror.
    """

    start: IntArray
    column: IntArray
    entry: FloatArray
    answer: FloatArray
    beyond: FloatArray

    @classmethod
    def empty(cls) -> "Coupling":
        """No rows."""
        none = np.empty((0, 3))
        return cls(
            np.zeros(1, np.int64), np.empty(0, np.int64), np.empty((0, 1)), none, none[:, :, None]
        )


@inner_kernel
def _answer(coupling, r, numbers):
    """Set the inverse mass of a contact vertex, sum_j B_ij^2/m_j; 0 if nearly all is held."""
    column, entry, start = coupling.column, coupling.entry, coupling.start
    found, gives, every = vector(0.0), vector(0.0), vector(0.0)
    for k in range(start[r], start[r + 1]):
        if entry.shape[1] == 1:
            square = vector(entry[k, 0] ** 2)
        else:
            square = load_row(entry, k, 0) * load_row(entry, k, 0)
        mobility = load_row(numbers, column[k], OF_INVERSE_MASS)
        found = square * mobility + found
        every = every + square
        gives = gives + where(mobility == 0.0, vector(0.0), square)
    for d in range(3):
        free = lane(gives, d) >= LEAST_FREE * lane(every, d)
        coupling.answer[r, d] = lane(found, d) if free else 0.0


@inner_kernel
def _way(frame, moved, number):
    """Vector from a particle to a vertex, pulled back to the initial configuration, in cells."""
    u, v, w = 0.0, 0.0, 0.0
    for d in range(len(frame.cell)):
        x = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d] - moved.position[d]
        u += moved.inverse_F[0, d] * x
        v += moved.inverse_F[1, d] * x
        w += moved.inverse_F[2, d] * x
    D = len(frame.cell)
    u, v = u * frame.inverse[0], v * frame.inverse[min(1, D - 1)]
    return u, v, w * frame.inverse[min(2, D - 1)]


def _value(w, g, local, way):
    """Weight of a vertex of a support at a vector from its particle, by the weight's gradient.

    `w` and `g` are the particle's, `local` is the vertex, see `Supports`.
    """


@specialise(_value)  # passing all arrays of the supports to a function would cost more than it does
def _value_at(w, g, local, way):
    def value(w, g, local, way):
        x, y, z = w[0, local[0]], w[1, local[1]], w[2, local[2]]
        flat = x * y + g[0, local[0]] * way[0] * y + x * g[1, local[1]] * way[1]
        return flat * z + x * y * g[2, local[2]] * way[2]

    return value


@kernel
def number_rows(contact_pairs, row_of, slots):
    """Replace the entries of `VERTEX_SUMS` in pairs by numbers of rows; returns their number.

    `row_of` gets the row of each entry, -1 without one, and `slots` the entry of each row.
    """
    row_of[:] = -1
    rows, ends = 0, contact_pairs.ends
    for k in range(len(ends)):
        for side in range(2):
            s = ends[k].rows[side]
            if s >= 0:
                if row_of[s] < 0:
                    row_of[s], slots[rows] = rows, s
                    rows += 1
                ends[k].rows[side] = row_of[s]
    return rows


@kernel
def find_coupling(frame, particles, initial, mirrors, slots, contact_vertices, vertices, coupling):
    """Find the rows of B for the contact pairs.

    Parameters
    ----------
    particles : (NEAR_PARTICLE, NEAR_MOTION), each (n,)
        The particles.
    initial : (Supports, Numbers)
        Supports of the particles at their initial positions, and their reference vertices.
    mirrors
        See `number_reference_vertices`.
    slots : (rows,) int64
        The entry of each row in `contact_vertices`.
    contact_vertices : ContactVertices
        The entries, with their sums.
    vertices : ((k, NUMBERS) float64, (2, k) int64)
        The records of `ReferenceVertices`, and scratch.
    coupling : Coupling
        Filled; `beyond` is zero before.

    Returns
    -------
    int
        Number of entries of all rows: if there are more than `coupling` has room for, it is not
        filled.
    """
    (table, motion), (before, (count, vertex_of, local)) = particles, initial
    numbers, kept = vertices
    places = before.local
    sums, reached, most = contact_vertices.sums, contact_vertices.reached, vertex_of.shape[1]
    column, entry, start, beyond = coupling.column, coupling.entry, coupling.start, coupling.beyond
    used, plain, (seen, entry_of) = 0, len(mirrors) == 0, (kept[0], kept[1])
    seen[:] = -1
    start[0] = 0
    for r in range(len(slots)):
        s = slots[r]
        vertex = number_of(contact_vertices, contact_vertices.keys[s] // contact_vertices.groups)
        for k in range(contact_vertices.start[s], reached.end[s]):
            i = reached.particle[k]
            if used + most > len(column):
                return 2 * len(column) + most
            part = table[i].mass * reached.weight[k] / sums[s].mass
            moves = table[i].lagrangian == 0  # its own grid is the current one
            way = _way(frame, motion[i], vertex)
            for o in range(count[i]):
                j, q = vertex_of[i, o], local[i, o]
                if moves and q != reached.local[k]:
                    continue
                if seen[j] != r:
                    seen[j], entry_of[j] = r, used
                    column[used] = j
                    for d in range(entry.shape[1]):
                        entry[used, d] = 0.0
                    used += 1
                share = part if moves else part * _value(before.w[i], before.g[i], places[q], way)
                if plain:
                    entry[entry_of[j], 0] += share
                    continue
                number = vertex_at(before, i, q)
                for d in range(3):
                    entry[entry_of[j], d] += share * reflection(mirrors, number, d, len(mirrors))
                for n in range(len(mirrors)):
                    if is_turned(mirrors, n, number):
                        for d in range(3):
                            beyond[r, n, d] += share * reflection(mirrors, number, d, n)
        start[r + 1] = used
        _answer(coupling, r, numbers)
    return used
