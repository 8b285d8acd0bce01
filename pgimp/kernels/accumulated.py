"""Contact of bodies in the initial configuration: impulses that all vertices agree upon.

A vertex i of the domain's grid sees what the vertices j of a body's own grid, that of the start,
give to the particles around it:

    w_i = sum_j B_ij v_j,    B_ij = sum_p m_p S_ip S0_jp / sum_p m_p S_ip,

S being weights at present, S0 those of the start. An impulse J_i changes v_j by B_ij J_i/m_j: what
it does to the power of the body is J_i . w_i, so that momentum is kept exactly, and so is angular
momentum but for what the two grids differ. One impulse moves its neighbours, too, the more so as
the two weights smooth it. So they are found together: sweeps over all pairs that may meet, each
with the true response sum_j B_ij^2/m_j, in which impulses accumulate and the law holds for what has
accumulated (projected Gauss-Seidel). All ranks do the same sweeps, with the same bits.
"""

from math import inf

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel, kernel, specialise
from pgimp.kernels.contact import (
    BEFORE,
    CLOSING,
    EXCESS,
    MOBILITY,
    NORMAL,
    NOW,
    OUTWARD,
    PART,
    PARTNERS,
    PUSH,
    SLIP,
    TOLD,
    WEIGHT,
    find_pairs,
)
from pgimp.kernels.contactbooks import book
from pgimp.kernels.contactlaw import exchange
from pgimp.kernels.faces import face_count, on_walls, side_of, wall_of, wall_sides
from pgimp.kernels.holding import Holding
from pgimp.kernels.meet import find_tools
from pgimp.kernels.present import (
    CURVED,
    FACES,
    FILLS,
    HEAVY,
    MORE,
    MOVES,
    OF_CUT,
    WEIGHS,
    WHOSE,
    YIELDS,
)
from pgimp.physics.contact import FRICTION

#: Columns of a pair's ends: of either one the number of its sums, or -1 - n of what is rigid, and
#: its body; the entry; the vertex.
SUMS, BODIES, ENTRY, VERTEX, ENDS = 0, 2, 4, 5, 8

#: Columns of a pair's velocities: those of the first and the second end if it is rigid.
RIGID = 6


#: Least part of a vertex's neighbourhood that either body must fill, or a rigid one. What a vertex
#: sees is a mean over the particles around it: one that lies deeper would hold what is below the
#: surface, and make the body stiff there. Wherever a surface lies, a vertex near it remains: with
#: the distances s and 1 - s in cells of two, (1 - s)^2/2 is filled.
LEAST_BEFORE, LEAST_RIGID = 0.1, 0.3


@inner_kernel
def _is_close(first, second):
    """Whether a vertex is close enough to the surfaces of two bodies to see how these move."""
    if second[WEIGHT] == inf:
        return second[PART] >= LEAST_RIGID
    if first[WEIGHT] == inf:
        return first[PART] >= LEAST_RIGID
    return min(first[PART], second[PART]) >= LEAST_BEFORE


@inner_kernel
def _copy(to, of):
    """Set an array to another."""
    for i in range(len(of)):
        to[i] = of[i]


@inner_kernel
def _load(contact, a, row, cell):
    """Put what a group has at a vertex into the room for field `a`."""
    fields = contact.fields
    fields[a, WEIGHT] = row[HEAVY]
    fields[a, PART] = (row[FILLS] + row[MORE]) / cell
    fields[a, EXCESS] = row[CURVED] / row[OF_CUT] if row[OF_CUT] > 0.0 else 0.0
    for d in range(3):
        fields[a, OUTWARD + d] = row[FACES + d]
        fields[a, NOW + d] = fields[a, BEFORE + d] = 0.0
    contact.bodies[a], contact.places[a] = int(row[WHOSE]), 0


@inner_kernel
def _keep_pairs(contact, number, first, count, pairs, found, ends, partners, rigid):
    """Keep the pairs that `find_pairs` has found at a vertex, as many as there is room for."""
    for k in range(pairs):
        one, other = contact.ends[k, 0], contact.ends[k, 1]
        if contact.pairs.law[contact.ends[k, 2] - 1] == FRICTION:
            if not _is_close(contact.fields[one], contact.fields[other]):
                continue
        found += 1
        if found > len(ends):
            continue
        end = ends[found - 1]
        _copy(partners[found - 1], contact.partners[k])
        rigid[found - 1, :] = 0.0
        end[ENTRY] = contact.ends[k, 2]
        for d in range(3):
            end[VERTEX + d] = number[d]
        for side in range(2):
            a = contact.ends[k, side]
            end[BODIES + side] = contact.bodies[a]
            end[SUMS + side] = first[a] if a < count else -1 - contact.bodies[a]
            if a >= count:
                for d in range(3):
                    rigid[found - 1, 3 * side + d] = contact.fields[a, NOW + d]
    return found


def _past_another(faces, axis, frame, number):
    """Whether a vertex is beyond a wall of another direction than `axis`."""


@specialise(_past_another)
def _past_any_other(faces, axis, frame, number):
    def past(faces, axis, frame, number):
        for n in range(face_count(faces)):
            other, end = side_of(faces, n)
            if other != axis and (number[other] - wall_of(faces, n, frame)) * end > 0:
                return True
        return False

    return past if len(faces) else lambda faces, axis, frame, number: False


@inner_kernel
def _wall_pair(contact, frame, faces, walls, w, number, sides, cell, first_wall):
    """Find the pair of the group in the first place and a wall that lets go; 0 if there is none.

    The wall is a rigid body that begins at it. Where other walls are, the neighbourhood ends.
    """
    axis, side = walls[w, 0], walls[w, 1]
    deep = (number[axis] - walls[w, 2]) * side
    if deep < 0:
        return 0
    if _past_another(faces, axis, frame, number):
        return 0
    row, area = contact.fields[1], cell * frame.inverse[axis]
    row[:] = 0.0
    row[WEIGHT], row[PART] = inf, 0.5 if deep == 0 else 1.0
    row[OUTWARD + axis] = -side * area * (1.0 if deep != 1 else 1e-3)
    contact.bodies[1] = first_wall + w
    along = (
        0 if axis == 0 else sides[0], 0 if axis == 1 else sides[1], 0 if axis == 2 else sides[2],
    )  # fmt: skip
    return find_pairs(contact, frame, along, 2, 1, 1.0)


@kernel
def find_contacts(contact, frame, faces, walls, first_wall, low, extent, groups, order, keys, sums,
                  places, dt, ends, partners, rigid):  # fmt: skip
    """Find the pairs that may act on each other at any vertex.

    Parameters
    ----------
    contact : Contact
        Laws, rigid bodies, and room for what meets at a vertex.
    faces : Faces or ()
        All walls that stand, where neighbourhoods end.
    walls : (walls, 3) int64
        Axis, side and vertex number of those that let go, which are bodies from `first_wall` on.
    low, extent, groups, keys, sums
        See `sum_present`.
    order : (m,) int64
        The numbers of what is in these, so that keys ascend.
    places : (groups,) int64
        Room.
    ends : (room, ENDS) int64
    partners : (room, PARTNERS) float64
    rigid : (room, RIGID) float64
        Set to what is known of the pairs.

    Returns
    -------
    int
        How many there are; more than there is room for are not kept.
    """
    found, i = 0, 0
    whole = 1.0
    for d in range(len(frame.cell)):
        whole *= frame.cell[d]
    while i < len(order):
        vertex = keys[order[i]] // groups
        rest = vertex // extent[2]
        number = (
            rest // extent[1] + low[0], rest % extent[1] + low[1], vertex % extent[2] + low[2],
        )  # fmt: skip
        count = 0
        while i < len(order) and keys[order[i]] // groups == vertex:
            places[count] = order[i]
            count += 1
            i += 1
        sides = wall_sides(faces, frame, number)
        cell = whole * 0.5 ** on_walls(faces, frame, number)
        for a in range(count):
            _load(contact, a, sums[places[a]], cell)
        tools = find_tools(contact, contact.tools, frame, number, sides, count, True)
        if count + tools > 1:
            pairs = find_pairs(contact, frame, sides, count + tools, tools, dt)
            found = _keep_pairs(
                contact, number, places, count, pairs, found, ends, partners, rigid
            )
        for w in range(len(walls)):
            for a in range(count):
                on = (number[walls[w, 0]] - walls[w, 2]) == 0
                half = cell * 2.0 if on else cell
                _load(contact, 0, sums[places[a]], half)
                pairs = _wall_pair(
                    contact, frame, faces, walls, w, number, sides, half, first_wall
                )
                if pairs > 0:
                    contact.partners[0, CLOSING] /= dt
                    found = _keep_pairs(
                        contact, number, places[a:], 1, pairs, found, ends, partners, rigid
                    )
    return found


@allocating_kernel
def find_responses(table, vertices, dimensions, w, w0, at, at0, ends, sums, values):
    """Find the rows of B for what meets.

    Parameters
    ----------
    table, w, w0, at, at0
        The particles, their weights now and at the start, and the numbers of their vertices.
    vertices, dimensions : int
        Vertices a direction in a support.
    ends
        The pairs.
    values
        The vertices of the start.

    Returns
    -------
    row_of : (m,) int64
        The row of each group at a vertex; -1 without.
    start : (rows + 1,) int64
        Where each row begins.
    column : (k,) int64
        Numbers of vertices of the start.
    entry : (k,) float64
        What B has there.
    answer : (rows, 3) float64
        sum_j B_ij^2/m_j, by component; vertices that are held do not count.
    """
    row_of = np.full(len(sums), -1, np.int64)
    slots = np.empty(2 * len(ends), np.int64)
    rows = 0
    for k in range(len(ends)):
        for side in range(2):
            s = ends[k, SUMS + side]
            if s >= 0 and row_of[s] < 0:
                row_of[s], slots[rows] = rows, s
                rows += 1
    # The particles of each row, in canonical order.
    many = np.zeros(rows + 1, np.int64)
    for i in range(len(table)):
        for q in range(at.shape[1]):
            if at[i, q] >= 0 and row_of[at[i, q]] >= 0:
                many[row_of[at[i, q]] + 1] += 1
    for r in range(rows):
        many[r + 1] += many[r]
    who, weight = np.empty(many[rows], np.int64), np.empty(many[rows])
    filled = many[:rows].copy()
    my, mz = (vertices if dimensions > 1 else 1), (vertices if dimensions > 2 else 1)
    for i in range(len(table)):
        q = 0
        for a in range(vertices):
            for b in range(my):
                for c in range(mz):
                    if at[i, q] >= 0 and row_of[at[i, q]] >= 0:
                        r = row_of[at[i, q]]
                        who[filled[r]] = i
                        weight[filled[r]] = w[i, 0, a] * w[i, 1, b] * w[i, 2, c]
                        filled[r] += 1
                    q += 1
    room = 64 * rows + at0.shape[1]
    start = np.zeros(rows + 1, np.int64)
    column, entry = np.empty(room, np.int64), np.empty(room)
    answer = np.zeros((rows, 3))
    seen, place = np.full(len(values), -1, np.int64), np.empty(len(values), np.int64)
    used = 0
    for r in range(rows):
        for k in range(many[r], many[r + 1]):
            i = who[k]
            if used + at0.shape[1] > room:
                room *= 2
                longer, more = np.empty(room, np.int64), np.empty(room)
                longer[:used], more[:used] = column[:used], entry[:used]
                column, entry = longer, more
            part, q = table[i, WEIGHS] * weight[k] / sums[slots[r], HEAVY], 0
            for a in range(vertices):
                for b in range(my):
                    for c in range(mz):
                        j = at0[i, q]
                        if j >= 0:
                            if seen[j] != r:
                                seen[j], place[j] = r, used
                                column[used], entry[used] = j, 0.0
                                used += 1
                            entry[place[j]] += part * w0[i, 0, a] * w0[i, 1, b] * w0[i, 2, c]
                        q += 1
        start[r + 1] = used
        for k in range(start[r], used):
            for d in range(3):
                answer[r, d] += entry[k] ** 2 * values[column[k], YIELDS + d]
    return row_of, start, column[:used], entry[:used], answer


@inner_kernel
def _sees(contact, a, s, rigid, rows, values, column):
    """Put velocity, mass and mobility of an end of a pair into the room for field `a`."""
    row = contact.fields[a]
    row_of, start, columns, entry, answer = rows
    if s < 0:
        row[WEIGHT] = inf
        for d in range(3):
            row[NOW + d] = rigid[3 * a + d]
            row[MOBILITY + d] = row[TOLD + d] = 0.0
        return
    r = row_of[s]
    u, v, w, most = 0.0, 0.0, 0.0, 0.0
    for k in range(start[r], start[r + 1]):
        one = values[columns[k]]
        u += entry[k] * one[column]
        v += entry[k] * one[column + 1]
        w += entry[k] * one[column + 2]
    row[NOW], row[NOW + 1], row[NOW + 2] = u, v, w
    for d in range(3):
        row[MOBILITY + d] = row[TOLD + d] = answer[r, d]
        most = max(most, answer[r, d])
    row[WEIGHT] = 1.0 / most if most > 0.0 else 1e300


@inner_kernel
def _gives(s, J, sign, rows, values):
    """Give an impulse to the vertices of the start that an end of a pair is made of."""
    if s < 0:
        return
    row_of, start, columns, entry, _ = rows
    r = row_of[s]
    for k in range(start[r], start[r + 1]):
        one = values[columns[k]]
        for d in range(3):
            one[MOVES + d] += sign * entry[k] * J[d] * one[YIELDS + d]


@inner_kernel
def _impulse(row, d):
    """Component `d` of what a pair has exchanged."""
    return row[SLIP + d] + row[PUSH] * row[NORMAL + d]


@kernel
def settle_contacts(contact, frame, forcing, ends, partners, rigid, rows, values, sweeps, enough):
    """Let all pairs exchange impulses until the law holds for all of them.

    Parameters
    ----------
    contact, frame, forcing
        Laws and room; see `exchange`.
    ends, partners, rigid
        The pairs; what they have exchanged is added up in `partners`.
    rows : tuple
        What `find_responses` gives.
    values : (m, STARTED) float64
        The vertices of the start; their velocities are changed here.
    sweeps : int
        The most sweeps over all pairs, forwards and backwards by turns.
    enough : float
        Part of the greatest impulse; it is enough when none changes by more in a sweep.

    Returns
    -------
    int
        Sweeps that were done.
    """
    number, holding = (0, 0, 0), Holding((), frame, forcing, contact.unbooked)
    for sweep in range(sweeps):
        change, most = 0.0, 0.0
        for n in range(len(ends)):
            k = n if sweep % 2 == 0 else len(ends) - 1 - n
            end, row = ends[k], partners[k]
            for a in range(2):
                _sees(contact, a, end[SUMS + a], rigid[k], rows, values, MOVES)
                contact.bodies[a], contact.ends[0, a] = end[BODIES + a], a
            contact.ends[0, 2] = end[ENTRY]
            before = (_impulse(row, 0), _impulse(row, 1), _impulse(row, 2))
            _copy(contact.partners[0], row)
            exchange(contact, holding, number, False, 0, True)
            _copy(row, contact.partners[0])
            J = (
                _impulse(row, 0) - before[0], _impulse(row, 1) - before[1],
                _impulse(row, 2) - before[2],
            )  # fmt: skip
            _gives(end[SUMS], J, -1.0, rows, values)
            _gives(end[SUMS + 1], J, 1.0, rows, values)
            for d in range(3):
                change = max(change, abs(J[d]))
                most = max(most, abs(_impulse(row, d)))
        if change <= enough * most:
            return sweep + 1
    return sweeps


@kernel
def book_contacts(contact, frame, forcing, ends, partners, rigid, rows, values, first_wall, numbers,
                  ledger):  # fmt: skip
    """Book what has been exchanged, in the first plane of the grid, whose owner calls this.

    Parameters
    ----------
    numbers : (walls,) int64
        Those of the walls that let go among the faces.
    """
    holding = Holding((), frame, forcing, contact.unbooked)
    for k in range(len(ends)):
        end, row = ends[k], partners[k]
        wall = max(end[BODIES], end[BODIES + 1]) - first_wall
        if wall >= 0:
            sign = -1.0 if end[BODIES] < end[BODIES + 1] else 1.0
            for d in range(3):
                ledger.impulse[0, numbers[wall], d] += sign * _impulse(row, d)
            continue
        for a in range(2):
            _sees(contact, a, end[SUMS + a], rigid[k], rows, values, MOVES)
            contact.bodies[a], contact.ends[0, a] = end[BODIES + a], a
        contact.ends[0, 2] = end[ENTRY]
        _copy(contact.partners[0], row)
        number = (end[VERTEX], end[VERTEX + 1], end[VERTEX + 2])
        book(contact, holding, number, 0, 1.0, True, ledger, 0)


__all__ = [
    "ENDS", "PARTNERS", "RIGID", "book_contacts", "find_contacts", "find_responses",
    "settle_contacts",
]  # fmt: skip
