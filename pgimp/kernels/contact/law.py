"""The law of contact at a vertex: components that are held, and the impulses of pairs."""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.kernels.contact.data import (
    BILATERAL,
    CLING,
    DRAWN,
    GAP_RATE,
    MOBILITY,
    NORMAL,
    NOW,
    PULL,
    PUSH,
    SLIP,
    STUCK,
    WEIGHT,
)
from pgimp.kernels.grid.conditions import held_velocity
from pgimp.kernels.grid.constraints import is_marked
from pgimp.kernels.grid.faces import beyond_any, face_count
from pgimp.kernels.rigid.bodies import ANSWERS, FREE, YIELDS
from pgimp.physics.contact import TIED

#: Small and great changes of a velocity, relative to the greatest speed at a vertex: what is held
#: moves with neither. Against a great one a wall that lets go, or friction, holds nothing.
SMALL, GREAT = 2.0**-20, 2.0**10

#: Least part of a normal's square along which a field may move that meets a rigid body whose motion
#: is prescribed: with less, its few free components would have to take all, without bound.
LEAST_GIVEN = 0.01


@inner_kernel
def held_field_velocity(contact, holding, number, a, last):
    """Velocity of a field after faces and constraints.

    The velocity from particles meets constraints as at the step's beginning, that after forces as
    at its end, so that bodies they push get their acceleration.
    """
    row = contact.fields[a]
    v = (row[NOW], row[NOW + 1], row[NOW + 2])
    if row[WEIGHT] == inf:
        return v
    return held_velocity(holding, number, contact.places[a], v, last)


@inner_kernel
def find_held(contact, holding, number, count, rigid, last):
    """Set the mobilities of the fields at a vertex; returns whether any component is held.

    A component is held if it does not follow the velocity, to either side: also by a wall that lets
    go while the body presses on it, or by friction while it sticks, which `BILATERAL` excludes.
    There are `count` fields of bodies and `rigid` ones of rigid bodies.
    """
    some, speed = False, -1.0
    near = beyond_any(holding.faces, face_count(holding.faces), holding.frame, number)
    for a in range(count):
        row = contact.fields[a]
        row[MOBILITY : MOBILITY + 3] = row[BILATERAL : BILATERAL + 3] = 0.0
        for d in range(len(holding.frame.cell)):
            row[MOBILITY + d] = row[BILATERAL + d] = 1.0 / row[WEIGHT]
        if not (near or is_marked(holding.forcing.marked, contact.places[a])):
            continue
        if speed < 0.0:
            speed = _fastest(contact.fields, count + rigid)
        v = held_field_velocity(contact, holding, number, a, last)
        for d in range(len(holding.frame.cell)):
            held = True
            for sign in (-1.0, 1.0):
                held = held and v[d] == _changed(
                    contact, holding, number, a, last, d, sign * SMALL * speed
                )
            bilateral = held
            if held:
                row[MOBILITY + d] = 0.0
                for sign in (-1.0, 1.0):
                    bilateral = bilateral and v[d] == _changed(
                        contact, holding, number, a, last, d, sign * GREAT * speed
                    )
            if bilateral:
                row[BILATERAL + d] = 0.0
            some = some or held or v[d] != row[NOW + d]
    return some


@inner_kernel
def _changed(contact, holding, number, a, last, d, change):
    """Component `d` of a field's velocity after faces and constraints, if changed before."""
    own = contact.fields[a, NOW + d]
    contact.fields[a, NOW + d] = own + change
    v = held_field_velocity(contact, holding, number, a, last)[d]
    contact.fields[a, NOW + d] = own
    return v


@inner_kernel
def _fastest(fields, count):
    """Greatest component of the velocities of `count` fields; 1 if all are at rest."""
    most = 0.0
    for a in range(count):
        for d in range(3):
            most = max(most, abs(fields[a, NOW + d]))
    return most if most > 0.0 else 1.0


def softness(contact, tools, a, b):
    """Compliance of a free rigid body against a held field, by component: velocity per impulse.

    Held is what has 0 in `BILATERAL`. The impulse changes neither velocity, the body's not before
    the end of the step. To find it together with the body's velocity, a thousandth of the body's
    own response is added, see `pgimp.scene.rigid.rigid.SOFT`.
    """


@specialise(softness)
def _softness(contact, tools, a, b):
    if not hasattr(tools, "instance_class") or not hasattr(tools.types[ANSWERS], "ndim"):
        return lambda contact, tools, a, b: (0.0, 0.0, 0.0)

    def of_free(contact, tools, a, b):
        fields, rigid, other = contact.fields, b, a
        if fields[a, WEIGHT] == inf:
            rigid, other = a, b
        if fields[rigid, WEIGHT] < inf:
            return 0.0, 0.0, 0.0
        if tools.about[contact.bodies[rigid] - tools.bodies, FREE] < 0:
            return 0.0, 0.0, 0.0
        soft = tools.motion[contact.bodies[rigid] - tools.bodies, YIELDS]
        return (
            soft if fields[other, BILATERAL] == 0.0 else 0.0,
            soft if fields[other, BILATERAL + 1] == 0.0 else 0.0,
            soft if fields[other, BILATERAL + 2] == 0.0 else 0.0,
        )

    return of_free


@inner_kernel
def exchange(contact, holding, number, held, pair, last):
    """Exchange between the fields of a pair the rest of the impulse that the law requires."""
    row = contact.partners[pair]
    a, b, entry = contact.ends[pair, 0], contact.ends[pair, 1], contact.ends[pair, 2] - 1
    first, second = contact.fields[a], contact.fields[b]
    u = (first[NOW], first[NOW + 1], first[NOW + 2])
    v = (second[NOW], second[NOW + 1], second[NOW + 2])
    if held:
        u = held_field_velocity(contact, holding, number, a, last)
        v = held_field_velocity(contact, holding, number, b, last)
    tied = contact.pairs.law[entry] == TIED
    # A rigid body may overcome a wall that lets go, or its friction.
    rigid = first[WEIGHT] == inf or second[WEIGHT] == inf
    column = BILATERAL if tied or rigid else MOBILITY
    soft = (0.0, 0.0, 0.0)
    if held:
        soft = softness(contact, contact.tools, a, b)
    if tied:
        for d in range(len(holding.frame.cell)):
            mobility = first[BILATERAL + d] + second[BILATERAL + d] + soft[d]
            if not mobility > 0.0:  # both are prescribed
                continue
            # A prescribed field carries the other along; walls that let go act on both.
            w = u[d] if first[BILATERAL + d] == 0.0 else first[NOW + d]
            w -= v[d] if second[BILATERAL + d] == 0.0 else second[NOW + d]
            _give(first, second, row, d, (w - soft[d] * row[SLIP + d]) / mobility)
        return
    w = (
        v[0] - u[0] + soft[0] * (row[SLIP] + row[PUSH] * row[NORMAL]),
        v[1] - u[1] + soft[1] * (row[SLIP + 1] + row[PUSH] * row[NORMAL + 1]),
        v[2] - u[2] + soft[2] * (row[SLIP + 2] + row[PUSH] * row[NORMAL + 2]),
    )
    normal, most, answer = 0.0, 0.0, 0.0
    for d in range(3):
        mobility = first[column + d] + second[column + d] + soft[d]
        answer += row[NORMAL + d] ** 2 * mobility
        most = max(most, mobility)
        normal += w[d] * row[NORMAL + d]
    prescribed = rigid and soft[0] + soft[1] + soft[2] == 0.0  # not a body that moves freely
    if not most > 0.0 or (prescribed and answer < LEAST_GIVEN * most):
        return
    push, square = row[PUSH], 0.0
    if answer > 0.0:
        row[PUSH] = max(0.0, push - (normal + row[GAP_RATE]) / answer)
        if row[PUSH] == 0.0 and row[PULL] > 0.0:
            required = min(0.0, push - normal / answer)
            row[PUSH] = max(-row[PULL], required)
            row[DRAWN] = row[PUSH] / required if required < 0.0 else 1.0
    for d in range(3):
        stick = row[SLIP + d] - (w[d] - normal * row[NORMAL + d]) / most
        square += stick * stick
    static, kinetic = contact.pairs.coefficient[entry, 0], contact.pairs.coefficient[entry, 1]
    length, pressed, cling = sqrt(square), max(row[PUSH], 0.0), row[CLING]
    if row[PUSH] < 0.0:
        cling *= sqrt(1.0 - (row[PUSH] / row[PULL]) ** 2)
    part = 1.0
    if length > static * pressed + cling:
        part = (kinetic * pressed + cling) / length
    row[STUCK] = part
    for d in range(3):
        stick = row[SLIP + d] - (w[d] - normal * row[NORMAL + d]) / most
        J = (row[PUSH] - push) * row[NORMAL + d]
        first[NOW + d] -= J / first[WEIGHT]
        second[NOW + d] += J / second[WEIGHT]
        _give(first, second, row, d, part * stick - row[SLIP + d])


@inner_kernel
def _give(first, second, row, d, J):
    """Change component `d` of two fields' velocities by an impulse across the normal."""
    row[SLIP + d] += J
    first[NOW + d] -= J / first[WEIGHT]
    second[NOW + d] += J / second[WEIGHT]
