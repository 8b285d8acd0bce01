"""Coupling matrix B between contact vertices and reference vertices, see `gauss_seidel`.

Each particle extrapolates its velocity to the contact vertex x_i with its velocity gradient:

    B_ij = sum_p m_p S_ip (S0_jp + grad S0_jp . F_p^-1 (x_i - x_p)) / sum_p m_p S_ip.

So an affine motion is exact at the vertex, instead of averaged to the mean position of the
particles around it. With the mean alone surfaces are stiff, and friction has too short a lever.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel, is_record, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import lane, vector, where
from pgimp.kernels.contact.lagrangian.hash_table import find
from pgimp.kernels.contact.lagrangian.reference_grid import (
    OF_INVERSE_MASS,
    image_of,
    is_turned,
    key_bits,
    key_of_vertex,
    reflection,
)
from pgimp.kernels.contact.lagrangian.reference_numbers import (
    WIDE,
    add_part,
    add_particle,
    by_axis,
    by_direction,
    fold_row,
)
from pgimp.kernels.contact.lagrangian.supports import from_centroid
from pgimp.kernels.contact.lagrangian.vertices import EXACT, number_of
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Least part of the squares of a row of B at free vertices. Below it the few free vertices would
#: have to compensate for the prescribed ones at many times the speed.
LEAST_FREE = 0.25


class Coupling(NamedTuple):
    """Rows of the coupling matrix B for the contact pairs."""

    start: IntArray  #: (rows + 1,) int64: First entry of each row.
    column: IntArray  #: (k,) int64: Numbers of reference vertices.
    #: (k, 1) or (k, 4) float64: The entries of B, with mirrors by component: they reverse the
    #: component across them.
    entry: FloatArray
    #: (rows, 3) float64: Inverse mass sum_j B_ij^2/m_j, by component, without held vertices, see
    #: `LEAST_FREE`.
    answer: FloatArray
    #: (rows, mirrors, 3) float64: Reversed share of an impulse, by mirror: the weight of the
    #: vertices beyond each mirror.
    beyond: FloatArray

    @classmethod
    def empty(cls) -> "Coupling":
        """No rows."""
        none = np.empty((0, 3))
        return cls(
            np.zeros(1, np.int64), np.empty(0, np.int64), np.empty((0, 1)), none, none[:, :, None]
        )


@inner_kernel
def set_answer(coupling, r, numbers):
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


@inner_kernel
def _number_after(references, key, j):
    """Number of the reference vertex with a key, -1 without one; `j` is that of the key before."""
    hashes, keys = references[0], references[1]
    if j + 1 < len(keys) and keys[j + 1] == key:  # mostly
        return j + 1
    return find(hashes, key)


@inner_kernel
def _keep_row(frame, references, mirrors, r, box, used, seen, coupling):
    """Append what is in a box to row `r`, and clear the box; returns the number of entries.

    The box has its sums from vertex `low` on, by axis, which are 0 before `begin` and from `end`
    on. `seen` has the last row of each reference vertex, and its entry there.
    """
    sums, low, begin, end = box
    _, _, bits, field = references
    column, entry, beyond, j = coupling.column, coupling.entry, coupling.beyond, -2
    for a in range(begin[0] - low[0], end[0] - low[0]):
        for b in range(begin[1] - low[1], end[1] - low[1]):
            row = a * WIDE + b
            number = by_direction(frame, (low[0] + a, low[1] + b, low[2]))
            line = key_of_vertex(bits, number, field)
            for c in range(begin[2] - low[2], end[2] - low[2]):
                share = sums[row, c]
                if share == 0.0:
                    continue
                if len(mirrors) == 0:  # keys ascend along the last axis
                    j = _number_after(references, line + (c << bits[2]), j)
                    if j >= 0 and seen[0, j] != r:
                        seen[0, j], seen[1, j], column[used], entry[used, 0] = r, used, j, share
                        used += 1
                    elif j >= 0:
                        entry[seen[1, j], 0] += share
                    continue
                number = by_direction(frame, (low[0] + a, low[1] + b, low[2] + c))
                image = image_of(mirrors, number)
                j = _number_after(references, key_of_vertex(bits, image, field), j)
                if j < 0:
                    continue
                if seen[0, j] != r:
                    seen[0, j], seen[1, j], column[used] = r, used, j
                    for d in range(entry.shape[1]):
                        entry[used, d] = 0.0
                    used += 1
                for d in range(3):
                    entry[seen[1, j], d] += share * reflection(mirrors, number, d, len(mirrors))
                for n in range(len(mirrors)):
                    if is_turned(mirrors, n, number):
                        for d in range(3):
                            beyond[r, n, d] += share * reflection(mirrors, number, d, n)
            store_row(sums, row, 0, vector(0.0))
            store_row(sums, row, 4, vector(0.0))
    return used


@inner_kernel
def _in_box(supports, i, middle):
    """Whether a particle's support begins near `middle`, so that a box round that contains it."""
    first = supports.first
    x, y, z = first[i, 0] - middle[0], first[i, 1] - middle[1], first[i, 2] - middle[2]
    return -2 <= x <= 2 and -2 <= y <= 2 and -2 <= z <= 2


@kernel
def find_coupling(frame, particles, initial, mirrors, slots, contact_vertices, scratch, coupling):
    """Find the rows of B for the contact pairs.

    The particles round a vertex are near each other in the initial configuration, too, so that all
    of their reference vertices are in one box. Where parts of a body meet there are several boxes.

    Parameters
    ----------
    particles : (NEAR_PARTICLE, NEAR_MOTION), each (n,)
    initial : (ReferenceSupports, (slots, 2) int64, (k,) int64, int, Parts or ())
        The particles' supports at their initial positions; hash table and keys of the reference
        vertices; number of velocity fields; parts of cells and slaves.
    mirrors
        See `number_reference_vertices`.
    slots : (rows,) int64
        The entry of each row in `contact_vertices`.
    contact_vertices : ContactVertices
        The entries, with their sums.
    scratch : ((k, NUMBERS) float64, (2, k) int64, (n,) int64, (WIDE^2, WIDE) float64)
        The records of `ReferenceVertices`, and scratch; the last is zero before and after.
    coupling : Coupling
        Filled; `beyond` is zero before.

    Returns
    -------
    int
        Number of entries of all rows: if there are more than `coupling` has room for, it is not
        filled.
    """
    (table, motion), supports = particles, initial[0]
    numbers, seen, left, box = scratch
    sums, reached, start = contact_vertices.sums, contact_vertices.reached, coupling.start
    used, most, bits, parts = 0, WIDE**3, key_bits(frame, initial[3]), initial[4]
    seen[0, :] = -1
    start[0] = 0
    for r in range(len(slots)):
        s = slots[r]
        vertex = number_of(contact_vertices, contact_vertices.keys[s] // contact_vertices.groups)
        head, waiting, inverse = contact_vertices.start[s], 0, 1.0 / sums[s].mass
        for k in range(head, reached.end[s]):
            left[waiting] = k
            waiting += 1
        some = table[reached.particle[head]]
        references = (initial[1], initial[2], bits, some.field)
        if some.lagrangian == 0:  # as the whole group: its own grid is the current one
            low, whole = by_axis(frame, vertex), 0.0
            for k in range(head, reached.end[s]):
                whole += table[reached.particle[k]].mass * reached.weight[k] * inverse
            box[0, 0], end, waiting = whole, (low[0] + 1, low[1] + 1, low[2] + 1), 0
            if used + most > len(coupling.column):
                box[:, :] = 0.0
                return 2 * len(coupling.column) + most
            used = _keep_row(
                frame, references, mirrors, r, (box, low, low, end), used, seen, coupling
            )
        while waiting > 0:
            i = reached.particle[left[0]]
            middle = supports.first[i, 0], supports.first[i, 1], supports.first[i, 2]
            low, begin, end = (middle[0] - 2, middle[1] - 2, middle[2] - 2), middle, middle
            others = 0
            for n in range(waiting):
                k = left[n]
                i = reached.particle[k]
                if not _in_box(supports, i, middle):
                    left[others] = k
                    others += 1
                    continue
                part = table[i].mass * reached.weight[k] * inverse
                way = _way(frame, motion[i], vertex)
                if is_record(parts) and table[i].lagrangian == EXACT:
                    way = by_axis(frame, way)
                    add_part(box, supports, i, low, part, way, parts.parts)
                elif is_record(parts):  # beside them particles have the weights of points
                    add_particle(box, supports, i, low, part, by_axis(frame, way))
                else:
                    way = by_axis(frame, from_centroid(frame, table[i], way))
                    add_particle(box, supports, i, low, part, way)
                first, many = supports.first[i], supports.many[i]
                begin = tuple(min(begin[d], first[d]) for d in range(3))
                end = tuple(max(end[d], first[d] + many[d]) for d in range(3))
            if used + most > len(coupling.column):
                box[:, :] = 0.0
                return 2 * len(coupling.column) + most
            used = _keep_row(
                frame, references, mirrors, r, (box, low, begin, end), used, seen, coupling
            )
            waiting = others
        if is_record(parts):
            if used + (used - start[r]) * parts.of.shape[1] > len(coupling.column):
                return 2 * len(coupling.column) + most
            used = fold_row(parts, r, used, seen, coupling)
        start[r + 1] = used
        set_answer(coupling, r, numbers)
    return used
