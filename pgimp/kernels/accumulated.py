"""Contact of bodies in the initial configuration: impulses found for all vertices together.

A vertex i of the domain's grid sees the velocity that the vertices j of a body's own grid, that of
the start, give to the particles around it:

    w_i = sum_j B_ij v_j,    B_ij = sum_p m_p S_ip S0_jp / sum_p m_p S_ip,

S being weights at present, S0 those of the start. A body in the current configuration has vertex i
itself, B_ij = 1 for j = i. An impulse J_i changes v_j by B_ij J_i/m_j: it
changes the body's power by J_i . w_i, so that momentum is conserved exactly, and angular momentum
up to the difference between the two grids. An impulse also moves its neighbours, the more so as
the two weights smooth it. So impulses are found together: sweeps over all pairs that may meet, each
with the true response sum_j B_ij^2/m_j, in which impulses accumulate and the law holds for the
accumulated ones (projected Gauss-Seidel). All ranks do the same sweeps, with the same bits.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel, kernel, specialise
from pgimp.kernels.contact import BILATERAL, MOBILITY, NORMAL, NOW, PUSH, SLIP, WEIGHT
from pgimp.kernels.contactlaw import exchange
from pgimp.kernels.encounters import BODIES, ENTRY, SUMS, VERTEX, copy
from pgimp.kernels.particles import FloatArray, IntArray
from pgimp.kernels.present import BEGUN, HEAVY, WEIGHS
from pgimp.kernels.rigidends import load_rigid, push_rigid
from pgimp.kernels.startgrid import LOST, MOVES, YIELDS, is_turned, reflection
from pgimp.kernels.support import vertex_at, weights_at

#: Least part of the squares of a row of B at free vertices. Below it the few free ones would have
#: to compensate for the others, which are prescribed, at many times the speed.
LEAST_FREE = 0.25


class Responses(NamedTuple):
    """Responses of the vertices of the start to impulses: the rows of B for the encounters.

    Attributes
    ----------
    row_of : (m,) int64
        The row of each entry of `Present`; -1 without.
    start : (rows + 1,) int64
        Where each row begins.
    column : (k,) int64
        Numbers of vertices of the start.
    entry : (k, 3) float64
        The entries of B, by component: a mirror turns that across it round.
    answer : (rows, 3) float64
        sum_j B_ij^2/m_j, by component, without vertices that are held, see `LEAST_FREE`.
    beyond : (rows, mirrors) float64
        Shares of the vertices beyond each mirror: what it turns round of an impulse.
    """

    row_of: IntArray
    start: IntArray
    column: IntArray
    entry: FloatArray
    answer: FloatArray
    beyond: FloatArray


@inner_kernel
def _answer(column, entry, first, last, values, part, free):
    """Sum of B_ij^2/m_j over a row's free vertices; 0 if nearly all of it is held."""
    found, gives, every = 0.0, 0.0, 0.0
    for k in range(first, last):
        square = entry[k, part] ** 2
        found += square * values[column[k], free]
        every += square
        if values[column[k], free] != 0.0:
            gives += square
    return found if gives >= LEAST_FREE * every else 0.0


@allocating_kernel
def find_responses(table, now, before, mirrors, encounters, sums, values):
    """Find the rows of B for the encounters.

    Parameters
    ----------
    table : (n, NEAR) float64
        The particles.
    now, before : Supports
        Theirs, at their present places and at those of the start.
    mirrors
        As of `take_vertices`.
    encounters : Encounters
        The pairs.
    sums : (m, SUMMED) float64
        See `Present`.
    values : (k, STARTED) float64
        See `StartVertices`.

    Returns
    -------
    Responses
    """
    ends, at, at0 = encounters.ends, now.at, before.at
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
    place_in = np.empty(many[rows], np.int64)
    filled = many[:rows].copy()
    for i in range(len(table)):
        for q in range(at.shape[1]):
            if at[i, q] >= 0 and row_of[at[i, q]] >= 0:
                r = row_of[at[i, q]]
                x, y, z = weights_at(now, i, q)
                who[filled[r]], weight[filled[r]], place_in[filled[r]] = i, x * y * z, q
                filled[r] += 1
    capacity = 64 * rows + at0.shape[1]
    start = np.zeros(rows + 1, np.int64)
    column, entry = np.empty(capacity, np.int64), np.empty((capacity, 3))
    answer, beyond = np.zeros((rows, 3)), np.zeros((rows, len(mirrors)))
    seen, place = np.full(len(values), -1, np.int64), np.empty(len(values), np.int64)
    used = 0
    for r in range(rows):
        for k in range(many[r], many[r + 1]):
            i = who[k]
            if used + at0.shape[1] > capacity:
                capacity *= 2
                longer, more = np.empty(capacity, np.int64), np.empty((capacity, 3))
                longer[:used], more[:used] = column[:used], entry[:used]
                column, entry = longer, more
            part = table[i, WEIGHS] * weight[k] / sums[slots[r], HEAVY]
            moves = table[i, BEGUN] == 0.0  # its own grid is the present one
            for q in range(at0.shape[1]):
                j = at0[i, q]
                if j < 0 or (moves and q != place_in[k]):
                    continue
                if seen[j] != r:
                    seen[j], place[j] = r, used
                    column[used], entry[used, :] = j, 0.0
                    used += 1
                x, y, z = weights_at(before, i, q)
                share = part if moves else part * x * y * z
                number = vertex_at(before, i, q)
                for d in range(3):
                    entry[place[j], d] += share * reflection(mirrors, number, d)
                for n in range(len(mirrors)):
                    if is_turned(mirrors, n, number):
                        beyond[r, n] += share
        start[r + 1] = used
        for d in range(3):
            answer[r, d] = _answer(column, entry, start[r], used, values, d, YIELDS + d)
    return Responses(row_of, start, column[:used], entry[:used], answer, beyond)


@inner_kernel
def _see(contact, a, s, responses, values):
    """Load velocity, mass and mobility of an end of a pair that is not rigid as field `a`."""
    row = contact.fields[a]
    r, start, entry = responses.row_of[s], responses.start, responses.entry
    u, v, w, most = 0.0, 0.0, 0.0, 0.0
    for k in range(start[r], start[r + 1]):
        one = values[responses.column[k]]
        u += entry[k, 0] * one[MOVES]
        v += entry[k, 1] * one[MOVES + 1]
        w += entry[k, 2] * one[MOVES + 2]
    row[NOW], row[NOW + 1], row[NOW + 2] = u, v, w
    for d in range(3):
        row[MOBILITY + d] = row[BILATERAL + d] = responses.answer[r, d]
        most = max(most, responses.answer[r, d])
    row[WEIGHT] = 1.0 / most if most > 0.0 else 1e300


def take_up(contact, frame, encounters, k, responses, values):
    """Load pair `k` as the first pair at a vertex."""


@specialise(take_up)
def _take_up_pair(contact, frame, encounters, k, responses, values):
    def take_up(contact, frame, encounters, k, responses, values):
        end, rigid = encounters.ends[k], encounters.rigid[k]
        number = (end[VERTEX], end[VERTEX + 1], end[VERTEX + 2])
        for a in range(2):
            s = end[SUMS + a]
            if s < 0:
                load_rigid(contact, contact.tools, frame, a, s, number, rigid)
            else:
                _see(contact, a, s, responses, values)
            contact.bodies[a], contact.ends[0, a] = end[BODIES + a], a
        contact.ends[0, 2] = end[ENTRY]
        copy(contact.partners[0], encounters.partners[k])

    return take_up


@inner_kernel
def _give(s, J, sign, responses, values):
    """Apply an impulse to the vertices that make up an end of a pair that is not rigid."""
    r, start, entry = responses.row_of[s], responses.start, responses.entry
    for k in range(start[r], start[r + 1]):
        one = values[responses.column[k]]
        for d in range(3):
            one[MOVES + d] += sign * entry[k, d] * J[d] * one[YIELDS + d]
            if one[YIELDS + d] == 0.0:
                one[LOST + d] += sign * entry[k, d] * J[d]


def _give_both(contact, frame, end, J, responses, values):
    """Apply an impulse to both ends of a pair, with opposite signs."""


@specialise(_give_both)
def _give_to_both(contact, frame, end, J, responses, values):
    def give(contact, frame, end, J, responses, values):
        number = (end[VERTEX], end[VERTEX + 1], end[VERTEX + 2])
        for side in range(2):
            s, sign = end[SUMS + side], 2.0 * side - 1.0
            if s < 0:
                push_rigid(contact.tools, frame, s, number, J, sign)
            else:
                _give(s, J, sign, responses, values)

    return give


@inner_kernel
def impulse_of(row, d):
    """Component `d` of the impulse that a pair has exchanged."""
    return row[SLIP + d] + row[PUSH] * row[NORMAL + d]


@kernel
def solve_impulses(contact, free, encounters, responses, values, sweeps, enough):
    """Exchange impulses in all pairs until the law holds for all of them.

    Parameters
    ----------
    contact : Contact
        Laws and scratch.
    free : Holding
        The empty one: what is held has no mobility.
    encounters : Encounters
        The pairs; their impulses are added up in `partners`.
    responses : Responses
        The response to impulses.
    values : (m, STARTED) float64
        The vertices of the start; their velocities are changed here.
    sweeps : int
        The most sweeps over all pairs, forwards and backwards by turns.
    enough : float
        Tolerance: greatest change of an impulse in a sweep, relative to the greatest impulse.

    Returns
    -------
    int
        Number of sweeps.
    """
    number, pairs = (0, 0, 0), len(encounters.ends)
    for sweep in range(sweeps):
        change, most = 0.0, 0.0
        for n in range(pairs):
            k = n if sweep % 2 == 0 else pairs - 1 - n
            end, row = encounters.ends[k], encounters.partners[k]
            take_up(contact, free.frame, encounters, k, responses, values)
            before = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
            exchange(contact, free, number, False, 0, True)
            copy(row, contact.partners[0])
            J = (
                impulse_of(row, 0) - before[0], impulse_of(row, 1) - before[1],
                impulse_of(row, 2) - before[2],
            )  # fmt: skip
            _give_both(contact, free.frame, end, J, responses, values)
            for d in range(3):
                change = max(change, abs(J[d]))
                most = max(most, abs(impulse_of(row, d)))
        if change <= enough * most:
            return sweep + 1
    return sweeps
