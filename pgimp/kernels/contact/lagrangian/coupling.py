"""Coupling matrix B between contact vertices and reference vertices, see `gauss_seidel`.

Each particle extrapolates its velocity to the contact vertex x_i with its velocity gradient:

    B_ij = sum_p m_p S_ip (S0_jp + grad S0_jp . F_p^-1 (x_i - x_p)) / sum_p m_p S_ip.

So an affine motion is exact at the vertex, instead of averaged to the mean position of the
particles around it. With the mean alone surfaces are stiff, and friction has too short a lever.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel
from pgimp.kernels.contact.lagrangian.reference_grid import is_turned, reflection
from pgimp.kernels.contact.lagrangian.supports import vertex_at, weights_at
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
    entry : (k, 3) float64
        The entries of B, by component: a mirror reverses the component across it.
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
        return cls(np.zeros(1, np.int64), np.empty(0, np.int64), none, none, none[:, :, None])


@inner_kernel
def _answer(column, entry, first, last, values, part):
    """Inverse mass of a contact vertex, sum_j B_ij^2/m_j; 0 if nearly all of the row is held."""
    found, gives, every = 0.0, 0.0, 0.0
    for k in range(first, last):
        square = entry[k, part] ** 2
        found += square * values[column[k]].inverse_mass[part]
        every += square
        if values[column[k]].inverse_mass[part] != 0.0:
            gives += square
    return found if gives >= LEAST_FREE * every else 0.0


@inner_kernel
def _way(frame, row, number):
    """Vector from a particle to a vertex, pulled back to the initial configuration, in cells."""
    u, v, w = 0.0, 0.0, 0.0
    for d in range(len(frame.cell)):
        x = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d] - row.position[d]
        u += row.inverse_F[0, d] * x
        v += row.inverse_F[1, d] * x
        w += row.inverse_F[2, d] * x
    D = len(frame.cell)
    u, v = u * frame.inverse[0], v * frame.inverse[min(1, D - 1)]
    return u, v, w * frame.inverse[min(2, D - 1)]


@inner_kernel
def _value(before, i, q, way):
    """Weight of vertex `q` of a support at a vector from its particle, by the weight's gradient."""
    w, g, local = before.w[i], before.g[i], before.local[q]
    x, y, z = w[0, local[0]], w[1, local[1]], w[2, local[2]]
    flat = x * y + g[0, local[0]] * way[0] * y + x * g[1, local[1]] * way[1]
    return flat * z + x * y * g[2, local[2]] * way[2]


@allocating_kernel
def find_coupling(frame, table, now, before, mirrors, contact_pairs, sums, values) -> Coupling:
    """Find the rows of B for the contact pairs.

    Parameters
    ----------
    table : (n,) NEAR_PARTICLE
        The particles.
    now, before : Supports
        Supports of the particles at their current and at their initial positions.
    mirrors
        See `copy_reference_vertices`.
    contact_pairs : ContactPairs
        The pairs. Numbers of rows replace the entries of `sums` in them.
    sums : (m,) VERTEX_SUMS
        See `ContactVertices`.
    values : (k,) REFERENCE_VERTEX
        See `ReferenceVertices`.

    Returns
    -------
    Coupling
    """
    ends, at, at0 = contact_pairs.ends, now.at, before.at
    row_of = np.full(len(sums), -1, np.int64)
    slots = np.empty(2 * len(ends), np.int64)
    rows = 0
    for k in range(len(ends)):
        for side in range(2):
            s = ends[k].rows[side]
            if s >= 0:
                if row_of[s] < 0:
                    row_of[s], slots[rows] = rows, s
                    rows += 1
                ends[k].rows[side] = row_of[s]
    # The particles of each row, in canonical order.
    many = np.zeros(rows + 1, np.int64)
    for i in range(len(table)):
        for q in range(at.shape[1]):
            if at[i, q] >= 0 and row_of[at[i, q]] >= 0:
                many[row_of[at[i, q]] + 1] += 1
    for r in range(rows):
        many[r + 1] += many[r]
    who, vertex_in = np.empty(many[rows], np.int64), np.empty(many[rows], np.int64)
    filled = many[:rows].copy()
    for i in range(len(table)):
        for q in range(at.shape[1]):
            if at[i, q] >= 0 and row_of[at[i, q]] >= 0:
                r = row_of[at[i, q]]
                who[filled[r]], vertex_in[filled[r]] = i, q
                filled[r] += 1
    capacity, plain = 64 * rows + at0.shape[1], len(mirrors) == 0
    start = np.zeros(rows + 1, np.int64)
    column, entry = np.empty(capacity, np.int64), np.empty((capacity, 3))
    answer, beyond = np.zeros((rows, 3)), np.zeros((rows, len(mirrors), 3))
    seen, entry_of = np.full(len(values), -1, np.int64), np.empty(len(values), np.int64)
    used = 0
    for r in range(rows):
        for k in range(many[r], many[r + 1]):
            i = who[k]
            if used + at0.shape[1] > capacity:
                capacity *= 2
                longer, more = np.empty(capacity, np.int64), np.empty((capacity, 3))
                longer[:used], more[:used] = column[:used], entry[:used]
                column, entry = longer, more
            x, y, z = weights_at(now, i, vertex_in[k])
            part = table[i].mass * (x * y * z) / sums[slots[r]].mass
            moves = table[i].lagrangian == 0  # its own grid is the current one
            u, v, w = _way(frame, table[i], vertex_at(now, i, vertex_in[k]))
            for q in range(at0.shape[1]):
                j = at0[i, q]
                if j < 0 or (moves and q != vertex_in[k]):
                    continue
                if seen[j] != r:
                    seen[j], entry_of[j] = r, used
                    column[used], entry[used, :] = j, 0.0
                    used += 1
                share = part if moves else part * _value(before, i, q, (u, v, w))
                if plain:
                    entry[entry_of[j], 0] += share
                else:
                    number = vertex_at(before, i, q)
                    n = len(mirrors)
                    for d in range(3):
                        entry[entry_of[j], d] += share * reflection(mirrors, number, d, n)
                    for n in range(len(mirrors)):
                        if is_turned(mirrors, n, number):
                            for d in range(3):
                                beyond[r, n, d] += share * reflection(mirrors, number, d, n)
        if plain:
            for k in range(start[r], used):
                entry[k, 1] = entry[k, 2] = entry[k, 0]
        start[r + 1] = used
        for d in range(3):
            answer[r, d] = _answer(column, entry, start[r], used, values, d)
    return Coupling(start, column[:used], entry[:used], answer, beyond)
