"""Contact of bodies in the initial configuration: projected Gauss-Seidel over all pairs.

The velocity w at a pair follows from those of the vertices j that move the body there:

    w_i = sum_j B_ij v_j,

with the weights of a patch (`pgimp.kernels.contact.surfaces.patches.rows`). A body in the current
configuration has vertex i itself, B_ij = 1 for j = i. An impulse J_i changes v_j by B_ij J_i/m_j,
and the body's power by J_i . w_i. So momentum is conserved exactly. An impulse also moves
neighbouring pairs. So impulses are solved together: sweeps over all pairs, each with its true
inverse mass sum_j B_ij^2/m_j. Impulses accumulate, and the law holds for the accumulated impulses
(projected Gauss-Seidel). One rank does the sweeps for a group.
"""

from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.jit.vectors.simd import lane
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.contact.impulses.rigid_ends import load_rigid, push_rigid
from pgimp.kernels.contact.impulses.rows import add_impulse, velocity_at


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
