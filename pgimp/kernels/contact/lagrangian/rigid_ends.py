"""Rigid ends of encounters: bodies that move as prescribed, and those that impulses move.

A free body has the velocity T V at a vertex, T = [1, -[r]x], and answers an impulse J there by the
change C T^t J of V, its velocity and angular velocity; C is the inverse of its mass matrix. All
ranks apply the same impulses, so that V, and the impulses so far, are the same on all.
"""

from math import inf

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.kernels.rigid.bodies import (
    ANSWERS,
    lever,
    place_of,
)


def _moves(tools):
    """Whether some rigid bodies, given by their Numba type, move freely."""
    return hasattr(tools, "instance_class") and hasattr(tools.types[ANSWERS], "ndim")


@inner_kernel
def _arm(tools, t, frame, number):
    """From the centre of a rigid body to a vertex."""
    x, motion = place_of(frame, number), tools.motion[t]
    return x[0] - motion.centre[0], x[1] - motion.centre[1], x[2] - motion.centre[2]


@inner_kernel
def _free_number(tools, s):
    """Number of a rigid end among the rigid bodies; -1 unless it moves freely."""
    t = -1 - s - tools.bodies
    if t >= len(tools.about) or tools.about[t].free < 0:  # a wall, or as prescribed
        return -1
    return t


@inner_kernel
def _prescribed(contact, a, rigid):
    """Load a rigid end that moves as prescribed as field `a`."""
    row = contact.fields[a]
    row.mass = inf
    for d in range(3):
        row.velocity[d] = rigid[a, d]
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0


def load_rigid(contact, tools, frame, a, s, number, rigid):
    """Load a rigid end as field `a`: its velocity and, if it moves freely, its mobility.

    `s` is minus 1 minus its number among all bodies, `rigid` the velocities of the pair's ends.
    The mobility, by component, is a bound: rows of T C T^t by their sums of absolute values.
    """


@specialise(load_rigid)
def _load_rigid(contact, tools, frame, a, s, number, rigid):
    if not _moves(tools):
        return lambda contact, tools, frame, a, s, number, rigid: _prescribed(contact, a, rigid)

    def load(contact, tools, frame, a, s, number, rigid):
        _prescribed(contact, a, rigid)
        t = _free_number(tools, s)
        if t < 0:
            return
        row, motion, arm = contact.fields[a], tools.motion[t], _arm(tools, t, frame, number)
        C = tools.answers[0, tools.about[t].free]
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

    return load


def push_rigid(tools, frame, s, number, J, sign):
    """Apply an impulse at a vertex to a rigid end that moves freely."""


@specialise(push_rigid)
def _push_rigid(tools, frame, s, number, J, sign):
    def push(tools, frame, s, number, J, sign):
        t = _free_number(tools, s)
        if t < 0:
            return
        motion, arm = tools.motion[t], _arm(tools, t, frame, number)
        answer = tools.answers[0, tools.about[t].free]
        for w in range(6):
            given = 0.0
            for d in range(3):
                given += sign * lever(arm, d, w) * J[d]
            answer.trial_impulse[w] += given
            for u in range(6):
                motion.velocity_after[u] += answer.derivative[u, w] * given

    return push if _moves(tools) else lambda tools, frame, s, number, J, sign: None
