"""Rigid bodies as further velocity fields at a vertex, with infinite mass."""

from math import inf

from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.kernels.contact.fill import FAR, NEAR, fill
from pgimp.kernels.rigid.bodies import arm_of, position_of
from pgimp.kernels.rigid.ring_volume import ring_volume_factor


@inlined
def has_rigid_bodies(rigid_bodies):
    """Whether there are rigid bodies."""
    if is_record(rigid_bodies):
        return True
    return False


@inlined
def may_be_near(near, rigid_bodies, i, j, k, folded):
    """Whether rigid bodies may be near a vertex, given by its offsets in the window.

    Where mirrors are `folded` it may have mass only since they are.
    """
    if is_record(rigid_bodies):
        return near[i, j, k] == NEAR or (folded and near[i, j, k] != FAR)
    return False


@inlined
def load_rigid_bodies(contact, rigid_bodies, frame, number, sides, count, last):
    """Add the rigid bodies near a vertex to the `count` fields there; returns their number.

    The velocity from particles is paired with the rigid velocity at the step's beginning, after
    forces at its end. So the material gets its support's acceleration.
    """
    if not is_record(rigid_bodies):
        return 0
    found, point = count, rigid_bodies.point[0]
    for t in range(len(rigid_bodies.motion)):
        if (rigid_bodies.lattice[t].free >= 0 and not last) or not fill(
            rigid_bodies, t, frame, number, sides
        ):
            continue
        row = contact.fields[found]
        contact.offsets[found], contact.bodies[found] = -1, rigid_bodies.bodies + t
        row.mass, row.filled, row.curvature_gap = inf, point.filled, point.curvature_gap
        ring_factor = ring_volume_factor(frame, number, sides)
        for d in range(3):
            row.surface[d] = point.surface[d] * ring_factor
        set_rigid_velocity(row, rigid_bodies, t, frame, number, last)
        found += 1
    return found - count


@inner_kernel
def set_rigid_velocity(row, rigid_bodies, t, frame, number, last):
    """Set the velocity of a field, rigid body `t`, at a vertex; it is held there."""
    motion = rigid_bodies.motion[t]
    velocity = motion.velocity_after if last else motion.velocity_before
    arm = arm_of(rigid_bodies, t, position_of(frame, number))
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        v = velocity[d]
        v += velocity[3 + e] * arm[f] - velocity[3 + f] * arm[e]
        row.velocity[d] = row.velocity_before[d] = v
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0
