"""Contact of bodies in the initial configuration: projected Gauss-Seidel over all pairs.

The velocity w at a pair follows from those of the vertices j that move the body there:

    w_i = sum_j B_ij v_j,

with the weights of a patch (`pgimp.kernels.contact.surfaces.rows`). A body in the current
configuration has vertex i itself, B_ij = 1 for j = i. An impulse J_i changes v_j by B_ij J_i/m_j,
and the body's power by J_i . w_i. So momentum is conserved exactly. An impulse also moves
neighbouring pairs. So impulses are solved together: sweeps over all pairs, each with its true
inverse mass sum_j B_ij^2/m_j. Impulses accumulate, and the law holds for the accumulated impulses
(projected Gauss-Seidel). One rank does the sweeps for a group.
"""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.vectors.simd import lane
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.contact.lagrangian.rigid_ends import load_rigid, push_rigid
from pgimp.kernels.contact.lagrangian.rows import add_impulse, velocity_at
from pgimp.kernels.contact.law import exchange

#: Numbers of a pair's impulse: along the normal, and across it by component.
IMPULSES = 4


@inner_kernel
def load_field(contact, a, r, coupling, solved):
    """Load velocity, mass and inverse mass of an end of a pair, with row `r`, as field `a`."""
    row, most = contact.fields[a], 0.0
    v = velocity_at(r, coupling, solved)
    row.velocity[0], row.velocity[1], row.velocity[2] = lane(v, 0), lane(v, 1), lane(v, 2)
    for d in range(3):
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = coupling.answer[r, d]
        most = max(most, coupling.answer[r, d])
    row.mass = 1.0 / most if most > 0.0 else 1e300


@inlined
def load_pair(contact, contact_pairs, k, coupling, solved):
    """Load pair `k` as the first pair at a vertex."""
    end, rigid = contact_pairs.ends[k], contact_pairs.rigid[k]
    for a in range(2):
        s = end.rows[a]
        if s < 0:
            load_rigid(contact, contact.rigid_bodies, a, s, rigid)
        else:
            load_field(contact, a, s, coupling, solved)
            if len(solved.soft) > 0:
                for d in range(3):
                    J = (2.0 * a - 1.0) * impulse_of(contact_pairs.states[k], d)
                    contact.fields[a].velocity[d] += solved.soft[s, d] * J + rigid[a, d]
        contact.bodies[a], contact.ends[0].fields[a] = end.bodies[a], a
    contact.ends[0].law = end.law
    contact.pair_states[0] = contact_pairs.states[k]


@inlined
def apply_impulse(contact, contact_pairs, k, J, coupling, solved):
    """Apply an impulse to both ends of pair `k`, with opposite signs."""
    end, rigid = contact_pairs.ends[k], contact_pairs.rigid[k]
    for side in range(2):
        s, sign = end.rows[side], 2.0 * side - 1.0
        if s < 0:
            push_rigid(contact.rigid_bodies, s, rigid, J, sign)
        else:
            add_impulse(s, J, sign, coupling, solved)


@kernel
def solve_impulses(contact, free, contact_pairs, coupling, solved, changes, sweeps, tolerance):
    """Exchange impulses in all pairs until the law holds for all of them.

    Vertices round a corner have nearly the same particles, and sweeps alone converge slowly. After
    two of them, forwards and backwards, the impulses go on along their last changes, as in the
    method of conjugate gradients: Silcowitz, Niebe and Erleben, A nonsmooth nonlinear conjugate
    gradient method for interactive contact force problems, Visual Comput. 26, 893-901 (2010).

    Parameters
    ----------
    contact : Contact
        Laws and scratch.
    free : Holding
        No conditions: held components have zero inverse mass.
    contact_pairs : ContactPairs
        The pairs; `states` accumulates their impulses.
    coupling : Coupling
        The response to impulses.
    solved : Solved
        The reference vertices; their velocities are changed here.
    changes : (2, pairs, IMPULSES) float64
        Scratch.
    sweeps : int
        Maximum number of sweeps over all pairs, alternately forwards and backwards.
    tolerance : float
        Greatest change of an impulse in a sweep, relative to the greatest impulse. Both are times
        the root of the pair's inverse mass, so that energies are compared.

    Returns
    -------
    int
        Number of sweeps.
    """
    start, before = changes[0], -1.0
    changes[1, :, :] = 0.0
    for sweep in range(sweeps):
        if sweep % 2 == 0:
            for k in range(len(contact_pairs.ends)):
                _store_impulse(contact_pairs.states[k], start, k)
        change, most = _sweep(contact, free, contact_pairs, coupling, solved, sweep % 2 == 0)
        if change <= tolerance * most:
            return sweep + 1
        if sweep % 2 == 1 and sweep + 1 < sweeps:
            before = conjugate_step(contact, free, contact_pairs, coupling, solved, changes, before)
    return sweeps


@inner_kernel
def _sweep(contact, free, contact_pairs, coupling, solved, forwards):
    """Exchange impulses once in all pairs; greatest change and impulse, as in `solve_impulses`."""
    number, pairs, change, most = (0, 0, 0), len(contact_pairs.ends), 0.0, 0.0
    for n in range(pairs):
        k = n if forwards else pairs - 1 - n
        row = contact_pairs.states[k]
        load_pair(contact, contact_pairs, k, coupling, solved)
        before = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        inverse = 0.0
        for d in range(3):
            both = contact.fields[0].inverse_mass[d] + contact.fields[1].inverse_mass[d]
            inverse = max(inverse, both)
        exchange(contact, free, number, False, 0, True)
        contact_pairs.states[k] = contact.pair_states[0]
        J = tuple(impulse_of(row, d) - before[d] for d in range(3))
        if J[0] != 0.0 or J[1] != 0.0 or J[2] != 0.0:
            apply_impulse(contact, contact_pairs, k, J, coupling, solved)
        for d in range(3):
            change = max(change, abs(J[d]) * sqrt(inverse))
            most = max(most, abs(impulse_of(row, d)) * sqrt(inverse))
    return change, most


@inner_kernel
def _store_impulse(row, into, k):
    """Store a pair's impulse, along and across its normal, in row `k`."""
    into[k, 0] = row.normal_impulse
    for d in range(3):
        into[k, 1 + d] = row.tangential_impulse[d]


@inner_kernel
def conjugate_step(contact, free, contact_pairs, coupling, solved, changes, before):
    """Go on along the last changes of all impulses.

    `changes` are the impulses before the last two sweeps, and the direction so far, which is set.
    `before` is the square of the changes by the two sweeps before these, below 0 without any.
    Returns the square of the last ones.
    """
    start, direction, square = changes[0], changes[1], 0.0
    for k in range(len(contact_pairs.ends)):
        row = contact_pairs.states[k]
        start[k, 0] = row.normal_impulse - start[k, 0]
        for d in range(3):
            start[k, 1 + d] = row.tangential_impulse[d] - start[k, 1 + d]
        for n in range(IMPULSES):
            square += start[k, n] ** 2
    part = square / before if before > 0.0 else 0.0
    for k in range(len(contact_pairs.ends)):
        row = contact_pairs.states[k]
        if part > 1.0:
            for n in range(IMPULSES):
                direction[k, n] = 0.0
            continue
        old = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        for n in range(IMPULSES):
            direction[k, n] *= part
        row.normal_impulse += direction[k, 0]
        for d in range(3):
            row.tangential_impulse[d] += direction[k, 1 + d]
        J = (impulse_of(row, 0) - old[0], impulse_of(row, 1) - old[1], impulse_of(row, 2) - old[2])
        if J[0] != 0.0 or J[1] != 0.0 or J[2] != 0.0:
            apply_impulse(contact, contact_pairs, k, J, coupling, solved)
        for n in range(IMPULSES):
            direction[k, n] += start[k, n]
    return square
