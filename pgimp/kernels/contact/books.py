"""Bookkeeping of contact: impulses, heat and losses of pairs; impulses and work of rigid bodies."""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.kernels.contact.data import fields_of, impulse_of
from pgimp.kernels.contact.law import held_field_velocity
from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    HEAT,
    IMPULSE,
    LOSS,
    NORMAL_IMPULSE,
    RIGID_IMPULSE,
    RIGID_MOMENT,
    RIGID_WORK,
    TANGENTIAL_IMPULSE,
)
from pgimp.kernels.rigid.bodies import arm_of, move_freely


@inner_kernel
def losses_of(row, u, v):
    """Heat of friction and loss along the normal of a pair whose ends have velocities u and v.

    Energy is impulse times the velocity after it, as the work of all other forces.
    """
    heat, normal = 0.0, 0.0
    for d in range(3):
        w = v[d] - u[d]
        normal += w * row.normal[d]
        heat -= row.tangential_impulse[d] * w
    return heat, -row.normal_impulse * normal


@inner_kernel
def book(contact, holding, at, pair, part, last, ledger, plane):
    """Book what a pair has exchanged in a pass, times `part`, in `plane`.

    `at` has the numbers of its vertex, and its position.
    """
    number, x = at
    row, entry = contact.pair_states[pair], contact.ends[pair].law - 1
    a, b = fields_of(contact, pair)
    booked = ledger.contact[plane, entry]
    u = held_field_velocity(contact, holding, number, a, last)
    v = held_field_velocity(contact, holding, number, b, last)
    heat, loss = losses_of(row, u, v)
    square = 0.0
    for d in range(3):
        booked[IMPULSE + d] -= part * impulse_of(row, d)
        square += row.tangential_impulse[d] ** 2
    booked[NORMAL_IMPULSE] += part * row.normal_impulse
    booked[TANGENTIAL_IMPULSE] += part * sqrt(square)
    booked[HEAT] += part * heat
    booked[LOSS] += part * loss
    if last and row.normal_impulse != 0.0:
        booked[CONTACT_AREA] += row.area
    booked[LOSS] += book_rigid_bodies(
        contact, contact.rigid_bodies, x, pair, part, (u, v), ledger, plane
    )


@inlined
def book_rigid_bodies(contact, rigid_bodies, x, pair, part, velocities, ledger, plane):
    """Book the impulse on a pair's rigid body, its moment, and its work on the other body.

    `x` is the vertex's position; `velocities` has both ends of the pair. Returns the energy that
    free rigid bodies lose at once.
    """
    if not is_record(rigid_bodies):
        return 0.0
    every = 0.0
    row, (u, v), (a, b) = contact.pair_states[pair], velocities, fields_of(contact, pair)
    for sign, end, w, other, s in ((-part, a, u, b, v), (part, b, v, a, u)):
        t = contact.bodies[end] - rigid_bodies.bodies
        if contact.fields[end].mass < inf or t >= len(rigid_bodies.motion):  # or a wall
            continue
        booked, arm = ledger.rigid_bodies[plane, t], arm_of(rigid_bodies, t, x)
        J = (sign * impulse_of(row, 0), sign * impulse_of(row, 1), sign * impulse_of(row, 2))
        done = -(J[0] * w[0] + J[1] * w[1] + J[2] * w[2])
        lost = _lost(rigid_bodies, t, arm, J, w)
        done += lost
        every += lost + _lost_beside(contact, rigid_bodies, t, other, J, s)
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            booked[RIGID_IMPULSE + d] += J[d]
            booked[RIGID_MOMENT + d] += arm[e] * J[f] - arm[f] * J[e]
        booked[RIGID_WORK] += done
        ledger.work[plane] += done
        _take(rigid_bodies, t, plane, arm, J)
    return every


@inlined
def _lost(rigid_bodies, t, arm, J, w):
    """Energy lost by a free rigid body through an impulse, besides the impulse's work at `w`.

    The body was faster before the step's impulses. Over all vertices its loss is the impulse times
    its mean velocity over the step.
    """
    if not move_freely(rigid_bodies):
        return 0.0
    found, former = 0.0, rigid_bodies.motion[t].velocity_before
    if rigid_bodies.lattice[t].free < 0:
        return found
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        before = former[d]
        before += former[3 + e] * arm[f] - former[3 + f] * arm[e]
        found += 0.5 * J[d] * (w[d] - before)
    return found


@inlined
def _lost_beside(contact, rigid_bodies, t, other, J, w):
    """As `_lost`, of the material that a free rigid body acts on, field `other`, with velocity `w`.

    Bodies that stay in touch change their velocities alike: of both shares nothing is left then.
    """
    if not move_freely(rigid_bodies):
        return 0.0
    field, found = contact.fields[other], 0.0
    if field.mass < inf and rigid_bodies.lattice[t].free >= 0:
        for d in range(3):
            found -= 0.5 * J[d] * (w[d] - field.velocity_before[d])
    return found


@inlined
def _take(rigid_bodies, t, plane, arm, J):
    """Apply an impulse to a rigid body that moves freely."""
    if not move_freely(rigid_bodies):
        return None
    free = rigid_bodies.lattice[t].free
    if free < 0:
        return
    taken = rigid_bodies.responses[plane, free]
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        taken.impulse[d] += J[d]
        taken.impulse[3 + d] += arm[e] * J[f] - arm[f] * J[e]
