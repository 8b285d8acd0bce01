"""Rigid bodies that hold particles out.

Vertices near a surface have the velocity of all that is around them, and what fills little of their
neighbourhood has no gap to be found. So thin tongues of what flows, and single particles, would go
on into a rigid body. A particle whose centre has passed the surface is moved back onto it, and its
velocity into the body becomes the body's, with friction, as in an inelastic impact: an impulse of
the pair like those at the vertices, and booked like them.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.kernels.fours import take_row
from pgimp.kernels.ledger import (
    HEAT,
    IMPULSE,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
    TOOL_IMPULSE,
    TOOL_MOMENT,
    TOOL_WORK,
)
from pgimp.kernels.tools import (
    CENTRE,
    DISTANCE,
    FIRST,
    LATTER,
    LOW,
    NORMAL,
    REFERENCE,
    SHAPE,
    SPACING,
    TURN,
    look_up,
)
from pgimp.physics.contact import FRICTION, TIED, Pairs


class Keepers(NamedTuple):
    """What keeps particles out of rigid bodies in a step.

    Attributes
    ----------
    tools : Tools
        The rigid bodies where they are at the step's end.
    pairs : Pairs
        The laws of contact.
    impulses : (layers, free bodies, 6) float64
        Grows by impulse and moment on each body that moves freely.
    """

    tools: Any
    pairs: Pairs
    impulses: np.ndarray


def hold_outside(keepers, forcing, particles, batch, x, v, ledger):
    """Hold four particles, which have been stored, out of rigid bodies; return places, velocities.

    Parameters
    ----------
    keepers : Keepers or ()
        () in scenes without rigid bodies.
    forcing, particles, batch, ledger
        See `Forcing`, `Particles`, `Batch`, `Ledger`.
    x, v : tuple of D Vec4
        Their places and velocities.
    """


@specialise(hold_outside)
def _hold_outside(keepers, forcing, particles, batch, x, v, ledger):
    if not hasattr(keepers, "instance_class"):
        return lambda keepers, forcing, particles, batch, x, v, ledger: (x, v)

    def hold(keepers, forcing, particles, batch, x, v, ledger):
        held = 0
        for j in range(batch.size):
            for t in range(len(keepers.tools.motion)):
                held += _hold(keepers, forcing, particles, batch.rows[j], t, batch.layer, ledger)
        if held > 0:
            x = take_row(particles.x, batch.rows, 0, x)
            v = take_row(particles.v, batch.rows, 0, v)
        return x, v

    return hold


@inner_kernel
def _may_be_inside(tools, t, D, x):
    """Whether a point may be inside body `t`, by the distance of the nearest of its lattice."""
    row, about = tools.motion[t], tools.about[t]
    place = 0
    for d in range(D):
        own = row[REFERENCE + d]
        for k in range(3):
            own += row[TURN + 3 * k + d] * (x[k] - row[CENTRE + k])
        s = (own - row[LOW + d]) / row[SPACING]
        if not (s > -0.5 and s < about[SHAPE + d] - 0.5):
            return False
        place = place * about[SHAPE + d] + int(s + 0.5)
    return tools.values[about[FIRST] + place, 0] < row[SPACING]


@inner_kernel
def _hold(keepers, forcing, particles, p, t, layer, ledger):
    """Hold particle `p` out of body `t`; returns 1 if it was changed, else 0."""
    tools, pairs, D = keepers.tools, keepers.pairs, particles.x.shape[1]
    at, motion, second = tools.at, tools.motion[t], tools.bodies + t
    place = (
        particles.x[p, 0], particles.x[p, 1] if D > 1 else 0.0, particles.x[p, D - 1] if D > 2 else 0.0
    )
    if not _may_be_inside(tools, t, D, place):
        return 0
    look_up(tools, t, D, place[0], place[1], place[2])
    if not at[DISTANCE] < 0.0:
        return 0
    entry = abs(pairs.entry[min(particles.body[p], second), max(particles.body[p], second)])
    if entry == 0:
        return 0
    m, depth, normal = particles.m[p], -at[DISTANCE], 0.0
    w, n = (0.0, 0.0, 0.0), (at[NORMAL], at[NORMAL + 1], at[NORMAL + 2])
    arm = (place[0] + depth * n[0] - motion[CENTRE], place[1] + depth * n[1] - motion[CENTRE + 1],
           place[2] + depth * n[2] - motion[CENTRE + 2])
    for d in range(D):
        e, f = (d + 1) % 3, (d + 2) % 3
        particles.x[p, d] += depth * n[d]
        ledger.work[layer] += m * forcing.gravity[d] * depth * n[d]
        own = motion[LATTER + d] + motion[LATTER + 3 + e] * arm[f] - motion[LATTER + 3 + f] * arm[e]
        u = particles.v[p, d] - own
        w = (u if d == 0 else w[0], u if d == 1 else w[1], u if d == 2 else w[2])
        normal += u * n[d]
    if not normal < 0.0:
        return 1
    square = 0.0
    for d in range(D):
        square += (w[d] - normal * n[d]) ** 2
    length, part = sqrt(square), 1.0
    if pairs.law[entry - 1] == FRICTION:
        static, kinetic = pairs.coefficient[entry - 1, 0], pairs.coefficient[entry - 1, 1]
        if length > static * -normal:
            part = kinetic * -normal / length
    booked, mine, done = ledger.contact[layer, entry - 1], ledger.tools[layer, t], 0.0
    sign = 1.0 if pairs.entry[min(particles.body[p], second), max(particles.body[p], second)] > 0 else -1.0
    J = (0.0, 0.0, 0.0)
    for d in range(D):
        e, f = (d + 1) % 3, (d + 2) % 3
        across = w[d] - normal * n[d]
        change = -normal * n[d] - part * across
        own = particles.v[p, d] - w[d]
        particles.v[p, d] += change
        j = m * change
        J = (j if d == 0 else J[0], j if d == 1 else J[1], j if d == 2 else J[2])
        done += j * own
        booked[IMPULSE + d] += sign * j
        booked[HEAT] += m * part * across * (1.0 - part) * across
    booked[NORMAL_IMPULSE] -= m * normal
    booked[TANGENTIAL_IMPULSE] += m * part * length
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        mine[TOOL_IMPULSE + d] -= J[d]
        mine[TOOL_MOMENT + d] -= arm[e] * J[f] - arm[f] * J[e]
    mine[TOOL_WORK] += done
    ledger.work[layer] += done
    return 1
