"""Disks that roll, slip and bounce with friction."""

from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
from studies.patches.impacts import SOLID, C, exact, parted
from studies.scenes import ball, box, case_of, core


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
    solid = SOLID | {"young": young, "density": 1000.0}
    c = C * sqrt(young / SOLID["young"] / 1000.0)
    theta = radians(angle)
    rolls = tan(theta) <= 3.0 * friction
    a = g * (2.0 / 3.0 * sin(theta) if rolls else sin(theta) - friction * cos(theta))
    spin = -(a / R if rolls else 2.0 * friction * g * cos(theta) / R)
    settle, last = 150.0 * R / c, sqrt(2.0 * radii * R / g)
    centre = np.array([R + 3.13, R + 3.21])
    floor = centre[1] - R - 1e-3
    bodies = {
        "disk": exact(ball(centre, R)),
        "floor": {"rigid": {}, "region": box([0.3, floor - 3.0], [6.0 * R + 9.0, floor])},
    }
    weight = [g * sin(theta), -g * cos(theta)]
    gravity = {"table": [[0.0, [0.0, 0.0]], [settle, weight]]}
    size = np.ceil([6.0 * R + 9.0, 2.0 * R + 8.0])
    case = case_of(size, 1.0, {"solid": solid}, bodies, settle, gravity=gravity,
                   contact=[{"bodies": ["disk", "floor"], "friction": friction}])  # fmt: skip
    case["time"]["end"] = settle + last
    sim, rows = core(case), []
    while not sim.finished:
        sim.advance()
        if sim.time > settle + 0.1 * last and sim.step % 20 == 0:
            v, w, _ = motion_of(sim)
            rows.append((sim.time, v[0], w))
    t, v, w = np.transpose(rows)
    return np.polyfit(t, v, 1)[0] / a, np.polyfit(t, w, 1)[0] / spin


def oblique(R, offset=(0.13, 0.21), angle=60.0, friction=0.2, v=0.01):
    """Rebound on a rigid plane, tangential impulse over mu times the normal one, and spin.

    The disk slips all the time; the spin is over that of a rigid one with this impulse.
    """
    centre = np.array([R + 3.0 + offset[0], R + 3.0 + offset[1]])
    floor = centre[1] - R - 0.3
    along = v * C * tan(radians(angle))
    end = (0.3 / v + 14.0 * R) / C
    bodies = {
        "disk": exact(ball(centre, R), [along, -v * C]),
        "floor": {"rigid": {}, "region": box([-3.0, floor - 2.6], [6.0 * R + 20.0, floor])},
    }
    size = np.ceil([3.0 * R + 8.0 + along * end, 2.0 * R + 8.0])
    sim = core(case_of(size, 1.0, {"solid": SOLID}, bodies, end,
                       contact=[{"bodies": ["disk", "floor"], "friction": friction}]))  # fmt: skip
    first, last, _ = parted(sim, ("disk", "floor"), 2.0 * R / C)
    mass = pi * R * R
    names = ("body.disk.momentum-x", "body.disk.momentum-y")
    change = np.array([last[n] - first[n] for n in names])
    _, spin, inertia = motion_of(sim)
    return {
        "rebound": last[names[1]] / (mass * v * C), "tangential": -change[0] / change[1] / friction,
        "spin": -spin * inertia / (friction * change[1] * R),
    }  # fmt: skip
