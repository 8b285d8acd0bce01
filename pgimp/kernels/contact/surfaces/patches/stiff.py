"""Patches of flat faces of two rigid bodies: where in them a force is.

Nothing yields there. One step's impulse stops what comes nearer, and turns what lands on one of its
faces about the edge that comes down. So a patch's weights are those of the gaps at the step's end,
as the bodies would move alone. They fade over next to nothing in a blow, and as `levels` says
at rest. They reach to the ends of facets.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.kernels.contact.surfaces.nearest import PLANE
from pgimp.kernels.contact.surfaces.patches.levels import FACET, GAP, NUMBER
from pgimp.kernels.rigid.bodies import arm_of, move_freely

#: As `FADES`, in cells, and over the way by which a patch comes nearer in a step: below that of an
#: edge that comes down, and above that by which a face that lands flat has turned by rounding.
_FADES, _FOLLOWS = 1e-6, 1e-3


@inlined
def rigid_velocity(rigid_bodies, s, place, before):
    """Velocity of a rigid end before the step or after it. Walls are at rest.

    `s` is as in `load_rigid`.
    """
    if not is_record(rigid_bodies):
        return 0.0, 0.0, 0.0
    t = -1 - s - rigid_bodies.bodies
    if t >= len(rigid_bodies.motion):
        return 0.0, 0.0, 0.0
    motion = rigid_bodies.motion[t]
    v = motion.velocity_before if before else motion.velocity_after
    r = arm_of(rigid_bodies, t, (place[0], place[1], place[2]))
    return (
        v[0] + v[4] * r[2] - v[5] * r[1],
        v[1] + v[5] * r[0] - v[3] * r[2],
        v[2] + v[3] * r[1] - v[4] * r[0],
    )


@inlined
def are_stiff(contact, surface, near):
    """Whether a facet near another, and this, are of flat faces of rigid bodies, or of a wall."""
    if not is_record(contact.rigid_bodies):
        return False
    s, f = near.facet, near.other
    if surface.cell[s] >= 0 or f >= len(surface.cell) or surface.tip[s] & PLANE == 0:
        return False
    return f < 0 or (surface.cell[f] < 0 and surface.tip[f] & PLANE != 0)


@inlined
def free_acceleration(rigid_bodies, end, force):
    """Acceleration apart that the force of a pair gives rigid bodies that move freely."""
    most = 0.0
    if move_freely(rigid_bodies):
        for side in range(2):
            t = end.bodies[side] - rigid_bodies.bodies
            if t < len(rigid_bodies.lattice) and rigid_bodies.lattice[t].free >= 0:
                C = rigid_bodies.responses[0, rigid_bodies.lattice[t].free].derivative
                most += max(C[0, 0], C[1, 1], C[2, 2])
    return most * sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)


@inlined
def foresee(contact, surface, group, cell, dt):
    """Let gathered gaps be those at the step's end, as both rigid bodies move alone.

    `group` are candidates, with those of the patch from `gather`. Returns the least gap, and
    the length over which weights fade.
    """
    (every, own, numbers, gathered), least, comes = group, inf, 0.0
    for m in range(gathered[0]):
        one, s = every[numbers[NUMBER, m]], numbers[FACET, m]
        v = rigid_velocity(contact.rigid_bodies, -1 - surface.body[s], surface.now[s], False)
        w = rigid_velocity(contact.rigid_bodies, -1 - one.body, surface.now[s], False)
        way = 0.0
        for d in range(3):
            way += dt * (v[d] - w[d]) * one.normal[d]
        own[GAP, m] += way
        least, comes = min(least, own[GAP, m]), max(comes, -way)
    return least, max(_FADES * cell, _FOLLOWS * comes)


@inner_kernel
def lean(surface, one, s, deep, w, place):
    """Add where a part w of a pressure is on facet `s`, as high as `deep` at its centroid.

    It is linear along the facet, and none where this is farther from the other body. Returns how
    much less the gap is there than at the centroid, times w; `place` has the sum for centroids.
    """
    less = 0.0
    for side in range(2):
        slope = 0.0
        for d in range(3):
            slope += surface.extent[s, side, d] * one.normal[d]
        over = deep / abs(slope) if slope != 0.0 else inf
        part = -1.0 / (3.0 * over) if over > 1.0 else (over - 2.0) / 3.0
        part = w * part if slope > 0.0 else -w * part
        for d in range(3):
            place[d] += part * surface.extent[s, side, d]
        less -= part * slope
    return less
