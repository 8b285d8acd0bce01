"""Bookkeeping of contact: impulses, heat and losses of pairs; impulses and work of rigid bodies."""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.kernels.contact.data import AREA, NORMAL, PUSH, SLIP, WEIGHT
from pgimp.kernels.contact.law import held_field_velocity
from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    HEAT,
    IMPULSE,
    LOSS,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
    TOOL_IMPULSE,
    TOOL_MOMENT,
    TOOL_WORK,
)
from pgimp.kernels.rigid.bodies import ANSWERS, CENTRE, FORMER, FREE, TAKEN, place_of


@inner_kernel
def losses_of(row, u, v):
    """Heat of friction and loss along the normal of a pair whose ends have velocities u and v.

    Energy is impulse times the velocity after it, as the work of all other forces.
    """
    heat, normal = 0.0, 0.0
    for d in range(3):
        w = v[d] - u[d]
        normal += w * row[NORMAL + d]
        heat -= row[SLIP + d] * w
    return heat, -row[PUSH] * normal


@inner_kernel
def book(contact, holding, number, pair, part, last, ledger, plane):
    """Book what a pair has exchanged in a pass, times `part`, at a vertex of `plane`."""
    row, entry = contact.partners[pair], contact.ends[pair, 2] - 1
    a, b = contact.ends[pair, 0], contact.ends[pair, 1]
    booked = ledger.contact[plane, entry]
    u = held_field_velocity(contact, holding, number, a, last)
    v = held_field_velocity(contact, holding, number, b, last)
    heat, loss = losses_of(row, u, v)
    square = 0.0
    for d in range(3):
        booked[IMPULSE + d] -= part * (row[SLIP + d] + row[PUSH] * row[NORMAL + d])
        square += row[SLIP + d] ** 2
    booked[NORMAL_IMPULSE] += part * row[PUSH]
    booked[TANGENTIAL_IMPULSE] += part * sqrt(square)
    booked[HEAT] += part * heat
    booked[LOSS] += part * loss
    if last and row[PUSH] != 0.0:
        booked[CONTACT_AREA] += row[AREA]
    x = place_of(holding.frame, number)
    book_tools(contact, contact.tools, x, pair, part, (u, v), ledger, plane)


def book_tools(contact, tools, x, pair, part, velocities, ledger, plane):
    """Book the impulse on the rigid body of a pair, its moment, and its work on what it met.

    `x` is the vertex's place; `velocities` are those of the pair.
    """


@specialise(book_tools)
def _book_tools(contact, tools, x, pair, part, velocities, ledger, plane):
    if not hasattr(tools, "instance_class"):
        return lambda contact, tools, x, pair, part, velocities, ledger, plane: None

    def book_each(contact, tools, x, pair, part, velocities, ledger, plane):
        row, (u, v) = contact.partners[pair], velocities
        for sign, end, w in ((-part, contact.ends[pair, 0], u), (part, contact.ends[pair, 1], v)):
            if contact.fields[end, WEIGHT] < inf:
                continue
            t = contact.bodies[end] - tools.bodies
            booked, motion = ledger.tools[plane, t], tools.motion[t]
            arm = (x[0] - motion[CENTRE], x[1] - motion[CENTRE + 1], x[2] - motion[CENTRE + 2])
            J = (
                sign * (row[SLIP] + row[PUSH] * row[NORMAL]),
                sign * (row[SLIP + 1] + row[PUSH] * row[NORMAL + 1]),
                sign * (row[SLIP + 2] + row[PUSH] * row[NORMAL + 2]),
            )
            done = -(J[0] * w[0] + J[1] * w[1] + J[2] * w[2])
            lost = _lost(tools, t, arm, J, w)
            done += lost
            ledger.contact[plane, contact.ends[pair, 2] - 1, LOSS] += lost
            for d in range(3):
                e, f = (d + 1) % 3, (d + 2) % 3
                booked[TOOL_IMPULSE + d] += J[d]
                booked[TOOL_MOMENT + d] += arm[e] * J[f] - arm[f] * J[e]
            booked[TOOL_WORK] += done
            ledger.work[plane] += done
            _take(tools, t, plane, arm, J)

    return book_each


def _lost(tools, t, arm, J, w):
    """Energy that a rigid body that moves freely loses by an impulse, besides its work at `w`.

    Before the step's impulses it was faster: over all vertices it loses the impulse times the mean
    of its velocities at the step's beginning and end.
    """


@specialise(_lost)
def _lost_of_free(tools, t, arm, J, w):
    if not hasattr(tools.types[ANSWERS], "ndim"):
        return lambda tools, t, arm, J, w: 0.0

    def lost(tools, t, arm, J, w):
        found, motion = 0.0, tools.motion[t]
        if tools.about[t, FREE] < 0:
            return found
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            before = motion[FORMER + d]
            before += motion[FORMER + 3 + e] * arm[f] - motion[FORMER + 3 + f] * arm[e]
            found += 0.5 * J[d] * (w[d] - before)
        return found

    return lost


def _take(tools, t, plane, arm, J):
    """Apply an impulse to a rigid body that moves freely."""


@specialise(_take)
def _take_free(tools, t, plane, arm, J):
    if not hasattr(tools.types[ANSWERS], "ndim"):
        return lambda tools, t, plane, arm, J: None

    def take(tools, t, plane, arm, J):
        free = tools.about[t, FREE]
        if free < 0:
            return
        taken = tools.answers[plane, free]
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            taken[TAKEN + d] += J[d]
            taken[TAKEN + 3 + d] += arm[e] * J[f] - arm[f] * J[e]

    return take
