"""Rigid ends of contact pairs: prescribed bodies, and free ones, which impulses accelerate.

A free body has the velocity T V at a vertex, T = [1, -[r]x]. An impulse J there changes V, its
velocity and angular velocity, by C T^t J; C is the inverse of its mass matrix. All ranks apply the
same impulses, so that V and the accumulated impulses agree on all ranks.
"""

from math import inf, sqrt

from pgimp.geometry.distancefield import MARGIN
from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.jit.memory import structure
from pgimp.kernels.contact.fill import fill
from pgimp.kernels.contact.rigid_fields import set_rigid_velocity
from pgimp.kernels.rigid.bodies import arm_of, find_distance, lever, move_freely, position_of
from pgimp.kernels.rigid.ring_volume import ring_volume_factor

#: What a rigid body fills of the neighbourhood of a vertex: whether that is known, and whether it
#: is near; then as in `FIELD_STATE`. It lasts while the body rests.
RIGID_FILL = structure(
    ("state", "i8"), ("filled", "f8"), ("curvature_gap", "f8"), ("surface", "f8", 3)
)

#: States of a `RIGID_FILL`.
UNKNOWN, FAR, NEAR = 0, 1, 2


@inlined
def _arm(rigid_bodies, t, rigid):
    """Vector from the centre of a rigid body, or of its nearest image, to where a pair is."""
    return arm_of(rigid_bodies, t, (rigid[2, 0], rigid[2, 1], rigid[2, 2]))


@inner_kernel
def _free_number(rigid_bodies, s):
    """Number of a rigid end among the rigid bodies; -1 unless it moves freely."""
    t = -1 - s - rigid_bodies.bodies
    if (
        t >= len(rigid_bodies.lattice) or rigid_bodies.lattice[t].free < 0
    ):  # a wall, or a prescribed body
        return -1
    return t


@inner_kernel
def _prescribed(contact, a, rigid):
    """Load a prescribed rigid end as field `a`."""
    row = contact.fields[a]
    row.mass = inf
    for d in range(3):
        row.velocity[d] = rigid[a, d]
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0


@inlined
def load_rigid(contact, rigid_bodies, a, s, rigid):
    """Load a rigid end as field `a`: its velocity and, if it moves freely, its inverse mass.

    `s` is minus 1 minus its number among all bodies; `rigid` is the pair's, see `ContactPairs`.
    The inverse mass, by component, is a bound: absolute row sums of T C T^t.
    """
    if not move_freely(rigid_bodies):
        return _prescribed(contact, a, rigid)
    _prescribed(contact, a, rigid)
    t = _free_number(rigid_bodies, s)
    if t < 0:
        return
    row, motion, arm = (contact.fields[a], rigid_bodies.motion[t], _arm(rigid_bodies, t, rigid))
    C = rigid_bodies.responses[0, rigid_bodies.lattice[t].free]
    for d in range(3):
        v, bound = 0.0, 0.0
        for u in range(6):
            v += lever(arm, d, u) * motion.velocity_after[u]
        for e in range(3):
            K = 0.0
            for u in range(6):
                for w in range(6):
                    K += lever(arm, d, u) * C.derivative[u, w] * lever(arm, e, w)
            bound += abs(K)
        row.velocity[d] = v
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = bound


@inlined
def is_free(rigid_bodies, s):
    """Whether an end of a pair is a rigid body that moves freely. `s` is as in `load_rigid`."""
    if not move_freely(rigid_bodies):
        return False
    return s < 0 and _free_number(rigid_bodies, s) >= 0


@inlined
def free_velocity(rigid_bodies, s, rigid):
    """Velocity of a rigid end that moves freely; zero of others."""
    if not move_freely(rigid_bodies):
        return (0.0, 0.0, 0.0)
    t = _free_number(rigid_bodies, s)
    if t < 0:
        return (0.0, 0.0, 0.0)
    V, arm = rigid_bodies.motion[t].velocity_after, _arm(rigid_bodies, t, rigid)
    return tuple(sum(lever(arm, d, u) * V[u] for u in range(6)) for d in range(3))


@inlined
def push_rigid(rigid_bodies, s, rigid, J, sign):
    """Apply an impulse of a pair to a rigid end that moves freely."""
    if move_freely(rigid_bodies):
        t = _free_number(rigid_bodies, s)
        if t < 0:
            return
        motion, arm = rigid_bodies.motion[t], _arm(rigid_bodies, t, rigid)
        answer = rigid_bodies.responses[0, rigid_bodies.lattice[t].free]
        for w in range(6):
            given = 0.0
            for d in range(3):
                given += sign * lever(arm, d, w) * J[d]
            answer.trial_impulse[w] += given
            for u in range(6):
                motion.velocity_after[u] += answer.derivative[u, w] * given
    return None


@inlined
def may_fill(rigid_bodies, frame, number, slack):
    """Whether a rigid body that moves by up to `slack` cells may fill part of a vertex's reach."""
    if not is_record(rigid_bodies):
        return False
    square, least, D = 0.0, inf, len(frame.cell)
    for d in range(D):
        square += frame.cell[d] ** 2
        least = min(least, frame.cell[d])
    reach = (1.0 + slack) * sqrt(square)
    x, y, z = position_of(frame, number)
    for t in range(len(rigid_bodies.motion)):
        lattice, inside = rigid_bodies.lattice[t], True
        for d in range(D):
            near = lattice.least[d] - 1 <= number[d] <= lattice.most[d] + 1
            inside = inside and near
        if not inside:
            continue
        if reach > MARGIN * least:  # the lattice of distances may end before
            return True
        find_distance(rigid_bodies, t, D, x, y, z)
        if rigid_bodies.point[0].distance <= reach:
            return True
    return False


@inlined
def load_resting(contact, rigid_bodies, frame, number, sides, count, fills):
    """As `load_rigid_bodies`, with `fills` of the vertex, (rigid bodies,) RIGID_FILL."""
    if not is_record(rigid_bodies):
        return 0
    found, point = count, rigid_bodies.point[0]
    for t in range(len(rigid_bodies.motion)):
        kept = fills[t]
        if kept.state == UNKNOWN:
            kept.state = NEAR if fill(rigid_bodies, t, frame, number, sides) else FAR
            ring_factor = ring_volume_factor(frame, number, sides)
            kept.filled, kept.curvature_gap = point.filled, point.curvature_gap
            for d in range(3):
                kept.surface[d] = point.surface[d] * ring_factor
        if kept.state == FAR:
            continue
        row = contact.fields[found]
        contact.offsets[found], contact.bodies[found] = -1, rigid_bodies.bodies + t
        row.mass, row.filled, row.curvature_gap = inf, kept.filled, kept.curvature_gap
        for d in range(3):
            row.surface[d] = kept.surface[d]
        set_rigid_velocity(row, rigid_bodies, t, frame, number, True)
        found += 1
    return found - count
