"""Disks that roll, slip and bounce with friction."""

from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
from studies.patches.impacts import C, SOLID, exact, parted
from studies.scenes import ball, box, case_of, core

#: Weight of a disk over its modulus times its radius, and times of waves through it until it rests.
WEIGHT = 5e-7


def motion_of(sim, body=0):
    """Mean velocity and rate of turning of a body, by its momenta, and its moment of inertia."""
    p, rows = sim.particles, sim.live()
    rows = rows[p.body[rows] == body]
    m, x, v = p.m[rows], p.x[rows], p.v[rows]
    x, mean = x - m @ x / m.sum(), m @ v / m.sum()
    v = v - mean
    inertia = (m * (x * x).sum(axis=1)).sum()
    return mean, (m * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])).sum() / inertia, inertia


def slope(R, angle, friction, radii=2.0):
    """Acceleration and spin over those of a rigid disk that rolls, or slips, down a plane."""
    young, g = 2e6 * R, 1.0
    solid = SOLID | {"young": young}
    c = C * sqrt(young / SOLID["young"])
    theta = radians(angle)
    rolls = tan(theta) <= 3.0 * friction
    a = g * (2.0 / 3.0 * sin(theta) if rolls else sin(theta) - friction * cos(theta))
    spin = -(a / R if rolls else 2.0 * friction * g * cos(theta) / R)
    settle, last = 60.0 * R / c, sqrt(2.0 * radii * R / g)
    way = 0.5 * a * last**2
    centre = np.array([R + 3.13, R + 3.21])
    floor = centre[1] - R - 1e-3
    bodies = {
        "disk": exact(ball(centre, R)),
        "floor": {"rigid": {}, "region": box([-20.3, floor - 3.0], [6.0 * R + way, floor])},
    }
    return solid, bodies, g, theta, (settle, last), a, spin
