"""Rigid ends of contact pairs: prescribed bodies, and free ones, which impulses accelerate.

A free body has the velocity T V at a vertex, T = [1, -[r]x]. An impulse J there changes V, its
velocity and angular velocity, by C T^t J; C is the inverse of its mass matrix. All ranks apply the
same impulses, so that V and the accumulated impulses agree on all ranks.
"""

from math import inf

from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.kernels.rigid.bodies import arm_of, lever, move_freely


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
