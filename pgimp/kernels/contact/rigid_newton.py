"""Derivative of the impulses on free rigid bodies by their velocities at the step's end.

A body's impulse in the last pass depends on its velocity V and angular velocity w at the step's
end. These depend on the impulse. Let T = [1, -[r]x], with r from its centre to a vertex. Let K be
minus the derivative of the impulse at the vertex by the velocity there. Impulse and moment have the
derivative sum of T^t K T. K is n n^t/m^-1 on a slipping surface, with more across the normal n on a
sticking one.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.data import fields_of
from pgimp.kernels.contact.law import held_compliance
from pgimp.kernels.contact.sliding import sliding_slope
from pgimp.kernels.contact.vertex import contact_at_vertex
from pgimp.kernels.contact.vertex_list import vertex_number
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.rigid.bodies import arm_of, lever, position_of
from pgimp.physics.contact.base import TIED

#: Least impulse across the normal; squares of smaller ones underflow.
NONE = 1e-120


@kernel
def find_rigid_impulses(contact, faces, frame, field, forcing):
    """Set the impulses on free rigid bodies in the last pass, and their derivatives by velocity.

    Parameters
    ----------
    contact : Contact
        With trial velocities of the rigid bodies at the step's end.
    faces, frame, field, forcing
        As in `update_momentum`, after its beginning.
    """
    rigid_bodies = contact.rigid_bodies
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    for i in range(field.owned):
        for free in range(rigid_bodies.responses.shape[1]):
            _clear(rigid_bodies.responses[i, free])
        for n in range(contact.listed.start[i], contact.listed.start[i + 1]):
            number = vertex_number(contact, n)
            if not _some_free(rigid_bodies, len(frame.cell), number):
                continue
            count, pairs, _ = contact_at_vertex(contact, holding, field, n, True)
            for pair in range(pairs):
                _add(contact, rigid_bodies, holding, number, pair, count if pairs > 1 else 1, i)


@inner_kernel
def _clear(response):
    """Set the impulse on a free rigid body in the last pass, and its derivative, to zero."""
    for u in range(6):
        response.trial_impulse[u] = 0.0
        for v in range(6):
            response.derivative[u, v] = 0.0


@inner_kernel
def _some_free(rigid_bodies, D, number):
    """Whether a vertex may be near a rigid body that moves freely."""
    for t in range(len(rigid_bodies.lattice)):
        lattice = rigid_bodies.lattice[t]
        near = lattice.free >= 0
        for d in range(D):
            near = near and lattice.least[d] <= number[d] <= lattice.most[d]
        if near:
            return True
    return False


@inner_kernel
def _add(contact, rigid_bodies, holding, number, pair, count, plane):
    """Add the impulse on a pair's rigid body at a vertex, if it moves freely.

    `count` is the number of fields that may respond together.
    """
    row, (a, b) = contact.pair_states[pair], fields_of(contact, pair)
    rigid, other = (a, b) if contact.fields[a].mass == inf else (b, a)
    if contact.fields[rigid].mass < inf:
        return
    t = contact.bodies[rigid] - rigid_bodies.bodies
    free = rigid_bodies.lattice[t].free
    if free < 0:
        return
    # Where other fields push back, the response is stiffer: as if all fields there moved as one.
    mass = contact.fields[other].mass
    if count > 1:
        mass = 0.0
        for one in range(count):
            mass += contact.fields[one].mass
    n = (row.normal[0], row.normal[1], row.normal[2])
    s = (row.tangential_impulse[0], row.tangential_impulse[1], row.tangential_impulse[2])
    push, slip = row.normal_impulse, sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    tied = contact.pairs.kind[contact.ends[pair].law - 1] == TIED
    mobility = _mobility(contact, rigid_bodies, a, b, other, contact.fields[other].mass / mass)
    along, across, drag, turn = _slopes(contact, pair, other, mobility, holding.forcing.dt)
    inverse = 1.0 / slip if slip > NONE else 0.0
    drag, turn = inverse * drag, inverse / slip * turn if slip > NONE else 0.0
    if rigid_bodies.motion[t].viscous_slip != 0.0:  # a bounded impulse as viscous: never overshoots
        drag, turn = 0.0, 0.0
        if push < 0.0:
            along = _pulled(row, mobility)
    sign = -1.0 if rigid == a else 1.0
    answer = rigid_bodies.responses[plane, free]
    arm = arm_of(rigid_bodies, t, position_of(holding.frame, number))
    for d in range(3):
        J = sign * (s[d] + push * n[d])
        for u in range(6):
            answer.trial_impulse[u] += lever(arm, d, u) * J
        for e in range(3):
            K = ((along - across) * n[d] + drag * s[d]) * n[e] - turn * s[d] * s[e]
            if d == e:
                K += 1.0 / mobility[d] if tied else across
            for u in range(6):
                for v in range(6):
                    answer.derivative[u, v] += lever(arm, d, u) * K * lever(arm, e, v)


@inner_kernel
def _mobility(contact, rigid_bodies, a, b, other, part):
    """Inverse mass against a free rigid body at a vertex, by component.

    `part` is the field's share of the mass that may respond together. Held fields respond singly.
    """
    soft, own = held_compliance(contact, rigid_bodies, a, b), contact.fields[other]
    free = own.bilateral_inverse_mass
    return part * free[0] + soft[0], part * free[1] + soft[1], part * free[2] + soft[2]


@inner_kernel
def _pulled(row, mobility):
    """Adhesive impulse along the normal, over the velocity that it opposes."""
    answer = 0.0
    for d in range(3):
        answer += row.normal[d] ** 2 * mobility[d]
    return row.adhesion_used / answer if answer > 0.0 else 0.0


@inner_kernel
def _slopes(contact, pair, other, mobility, dt):
    """Derivatives of the impulse on a rigid body by its velocity, with the sign turned.

    Returns four: along the normal; across it; of the slip impulse by the normal velocity; the
    reduction of the second along the slip itself. Tied bodies have none of these: their impulse is
    the velocity over the inverse mass, by component.
    """
    entry, row = contact.ends[pair].law - 1, contact.pair_states[pair]
    push = row.normal_impulse
    answer, most = 0.0, 0.0
    for d in range(3):
        answer += row.normal[d] ** 2 * mobility[d]
        most = max(most, mobility[d])
    if contact.pairs.kind[entry] == TIED or not (push != 0.0 or row.shear_adhesion > 0.0):
        return 0.0, 0.0, 0.0, 0.0
    held = answer > 0.0 and push != 0.0 and push > -row.adhesion  # else it pulls at its limit
    along, across = 1.0 / answer if held else 0.0, row.sticking / most
    if row.sticking == 1.0:
        return along, across, 0.0, 0.0
    if push < 0.0:
        return along, across, 0.0, across
    slip = 0.0
    for d in range(3):
        slip += row.tangential_impulse[d] ** 2
    slip = sqrt(slip) * most / row.sticking if row.sticking > 0.0 else 0.0
    slope = sliding_slope(contact.pairs, entry, push, row.area * dt, slip)
    return along, across, slope * along, across
