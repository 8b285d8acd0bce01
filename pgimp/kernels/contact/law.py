"""Contact law at a vertex: held components of fields, and the impulses of pairs."""

from math import copysign, inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.kernels.contact.data import fields_of, impulse_of
from pgimp.kernels.contact.sliding import acts_apart, sliding_part
from pgimp.kernels.grid.conditions import held_velocity
from pgimp.kernels.grid.constraints import is_marked
from pgimp.kernels.grid.faces import beyond_any, face_count
from pgimp.kernels.rigid.bodies import move_freely
from pgimp.physics.contact.base import TIED

#: Small and great changes of a velocity, relative to the greatest speed at a vertex. Held
#: components follow neither. A unilateral wall, or friction, does not hold against a great one.
SMALL, GREAT = 2.0**-20, 2.0**10

#: Least part of a normal's square along free directions of a field in contact with a prescribed
#: rigid body. With less, its few free components would have to take all, without bound.
LEAST_GIVEN = 0.01


@inner_kernel
def held_field_velocity(contact, holding, number, a, last):
    """Velocity of a field after faces and constraints.

    Constraints apply to the velocity from particles at the step's beginning, after forces at its
    end. So bodies that they push get their acceleration.
    """
    row = contact.fields[a]
    v = (row.velocity[0], row.velocity[1], row.velocity[2])
    if row.mass == inf:
        return v
    return held_velocity(holding, number, contact.offsets[a], v, last)


@inner_kernel
def find_held(contact, holding, number, count, rigid, last):
    """Set the inverse masses of the fields at a vertex; returns whether any component is held.

    A component is constrained if perturbing the velocity does not change the result. Unilateral
    walls under pressure, and sticking friction, count too. The bilateral inverse mass excludes
    these. Of the fields `count` are bodies and `rigid` are rigid bodies.
    """
    some, speed = False, -1.0
    near = beyond_any(holding.faces, face_count(holding.faces), holding.frame, number)
    for a in range(count):
        row = contact.fields[a]
        inverse = 1.0 / row.mass
        for d in range(3):
            moves = d < len(holding.frame.cell)
            row.inverse_mass[d] = row.bilateral_inverse_mass[d] = inverse if moves else 0.0
        if not (near or is_marked(holding.forcing.marked, contact.offsets[a])):
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
                row.inverse_mass[d] = 0.0
                for sign in (-1.0, 1.0):
                    bilateral = bilateral and v[d] == _changed(
                        contact, holding, number, a, last, d, sign * GREAT * speed
                    )
            if bilateral:
                row.bilateral_inverse_mass[d] = 0.0
            some = some or held or v[d] != row.velocity[d]
    return some


@inner_kernel
def _changed(contact, holding, number, a, last, d, change):
    """Component `d` of a field's velocity after faces and constraints, if perturbed before."""
    own = contact.fields[a].velocity[d]
    contact.fields[a].velocity[d] = own + change
    v = held_field_velocity(contact, holding, number, a, last)[d]
    contact.fields[a].velocity[d] = own
    return v


@inner_kernel
def _fastest(fields, count):
    """Greatest velocity component of `count` fields; 1 with all at rest."""
    most = 0.0
    for a in range(count):
        for d in range(3):
            most = max(most, abs(fields[a].velocity[d]))
    return most if most > 0.0 else 1.0


@inlined
def held_compliance(contact, rigid_bodies, a, b):
    """Compliance of a free rigid body against a held field, by component: velocity per impulse.

    Held components have no bilateral inverse mass. The impulse changes neither velocity, the
    body's not before the end of the step. To solve for both together, a thousandth of the body's
    own compliance is added, see `pgimp.scene.rigid.rigid.SOFT`.
    """
    if not move_freely(rigid_bodies):
        return (0.0, 0.0, 0.0)
    fields, rigid, other = contact.fields, b, a
    if fields[a].mass == inf:
        rigid, other = a, b
    if fields[rigid].mass < inf:
        return 0.0, 0.0, 0.0
    if rigid_bodies.lattice[contact.bodies[rigid] - rigid_bodies.bodies].free < 0:
        return 0.0, 0.0, 0.0
    soft = rigid_bodies.motion[contact.bodies[rigid] - rigid_bodies.bodies].compliance
    held = fields[other].bilateral_inverse_mass
    return tuple(soft if held[d] == 0.0 else 0.0 for d in range(3))


@inner_kernel
def _inverse_mass(field, bilateral, d):
    """Inverse mass of a field along `d`, or the bilateral one."""
    return field.bilateral_inverse_mass[d] if bilateral else field.inverse_mass[d]


@inner_kernel
def parts(pairs, entry):
    """Whether a pair's law has no ties, no adhesion, and acts on surfaces that touch alone."""
    if pairs.kind[entry] == TIED or pairs.adhesion[entry, 2] > 0.0:
        return False
    return not acts_apart(pairs, entry)


@inner_kernel
def rests_apart(pairs, entry, row):
    """Whether a pair exchanges nothing unless its surfaces reach each other."""
    if pairs.kind[entry] == TIED or row.adhesion + row.shear_adhesion != 0.0:
        return False
    return not acts_apart(pairs, entry)


@inner_kernel
def _stay_apart(pairs, entry, row, u, v):
    """Whether surfaces with velocities u and v that exchange nothing so far need no impulse."""
    apart, reach = row.gap_rate, row.adhesion + row.shear_adhesion
    for d in range(3):
        apart += (v[d] - u[d]) * row.normal[d]
    for d in range(3):
        reach += abs(row.tangential_impulse[d])
    if not (apart >= 0.0 and reach == 0.0 and row.normal_impulse == 0.0):
        return False
    return not acts_apart(pairs, entry)


@inner_kernel
def exchange(contact, holding, number, held, pair, last):
    """Exchange the rest of the impulse that the law requires between the fields of a pair.

    Returns whether anything changes: without any change in a whole sweep, further ones have none.
    """
    row = contact.pair_states[pair]
    (a, b), entry = fields_of(contact, pair), contact.ends[pair].law - 1
    first, second = contact.fields[a], contact.fields[b]
    u = (first.velocity[0], first.velocity[1], first.velocity[2])
    v = (second.velocity[0], second.velocity[1], second.velocity[2])
    if held:
        u = held_field_velocity(contact, holding, number, a, last)
        v = held_field_velocity(contact, holding, number, b, last)
    tied = contact.pairs.kind[entry] == TIED
    if not tied and _stay_apart(contact.pairs, entry, row, u, v):
        return False
    # A rigid body may overcome a unilateral wall, or its friction.
    rigid = first.mass == inf or second.mass == inf
    bilateral = tied or rigid
    soft = (0.0, 0.0, 0.0)
    if held:
        soft = held_compliance(contact, contact.rigid_bodies, a, b)
    changed, inverse = False, (1.0 / first.mass, 1.0 / second.mass)
    if tied:
        for d in range(len(holding.frame.cell)):
            mobility = first.bilateral_inverse_mass[d] + second.bilateral_inverse_mass[d] + soft[d]
            if not mobility > 0.0:  # both are prescribed
                continue
            # A prescribed field moves the other; unilateral walls act on both.
            w = u[d] if first.bilateral_inverse_mass[d] == 0.0 else first.velocity[d]
            w -= v[d] if second.bilateral_inverse_mass[d] == 0.0 else second.velocity[d]
            J = (w - soft[d] * row.tangential_impulse[d]) / mobility
            changed = _give(first, second, inverse, row, d, J, J) or changed
        return changed
    w = tuple(v[d] - u[d] + soft[d] * impulse_of(row, d) for d in range(3))
    normal, most, answer = 0.0, 0.0, 0.0
    for d in range(3):
        mobility = _inverse_mass(first, bilateral, d) + _inverse_mass(second, bilateral, d)
        mobility += soft[d]
        answer += row.normal[d] ** 2 * mobility
        most = max(most, mobility)
        normal += w[d] * row.normal[d]
    prescribed = rigid and soft[0] + soft[1] + soft[2] == 0.0  # not a body that moves freely
    if not most > 0.0 or (prescribed and answer < LEAST_GIVEN * most):
        return False
    push, square = row.normal_impulse, 0.0
    if answer > 0.0:
        row.normal_impulse = max(0.0, push - (normal + row.gap_rate) / answer)
        if row.normal_impulse == 0.0 and row.adhesion > 0.0:
            required = min(0.0, push - normal / answer)
            row.normal_impulse = max(-row.adhesion, required)
            row.adhesion_used = row.normal_impulse / required if required < 0.0 else 1.0
    by = 1.0 / most
    stick = tuple(
        row.tangential_impulse[d] - (w[d] - normal * row.normal[d]) * by for d in range(3)
    )
    for d in range(3):
        square += stick[d] * stick[d]
    length, pressed, shear_adhesion = sqrt(square), max(row.normal_impulse, 0.0), row.shear_adhesion
    if row.normal_impulse < 0.0:
        shear_adhesion *= sqrt(1.0 - (row.normal_impulse / row.adhesion) ** 2)
    stress = row.area * holding.forcing.dt
    slip = length * most
    part = sliding_part(contact.pairs, entry, shear_adhesion, pressed, stress, length, slip)
    row.sticking = part
    for d in range(3):
        across = part * stick[d] - row.tangential_impulse[d]
        J = (row.normal_impulse - push) * row.normal[d] + across
        changed = _give(first, second, inverse, row, d, across, J) or changed
    return changed or _differ(push, row.normal_impulse)


@inner_kernel
def _give(first, second, inverse, row, d, across, J):
    """Change component `d` of two fields' velocities by the impulse J, `across` it tangentially.

    Their masses are 1 over those `inverse`. Returns whether this changes anything.
    """
    before = (row.tangential_impulse[d], first.velocity[d], second.velocity[d])
    row.tangential_impulse[d] += across
    first.velocity[d] -= J * inverse[0]
    second.velocity[d] += J * inverse[1]
    return (
        _differ(before[0], row.tangential_impulse[d])
        or _differ(before[1], first.velocity[d])
        or _differ(before[2], second.velocity[d])
    )


@inner_kernel
def _differ(a, b):
    """Whether two numbers have different bits; NaN differs from itself."""
    return a != b or (a == 0.0 and copysign(1.0, a) != copysign(1.0, b))
