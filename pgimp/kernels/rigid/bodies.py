"""Rigid bodies for the kernels: how they move, and their distances at points."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel

#: A rigid body in a step: its reference point now and at the start, the matrix that turns it, the
#: lattice's spacing and first point, and velocity and angular velocity at the step's beginning and
#: end. Of one that moves freely, whether slip is viscous in this iteration, and its compliance
#: against held fields, see `pgimp.kernels.contact.law.softness`.
MOTION = np.dtype([
    ("centre", "f8", 3),
    ("reference", "f8", 3),
    ("rotation", "f8", (3, 3)),
    ("spacing", "f8"),
    ("low", "f8", 3),
    ("velocity_before", "f8", 6),
    ("velocity_after", "f8", 6),
    ("viscous_slip", "f8"),
    ("compliance", "f8"),
], align=True)  # fmt: skip

#: The lattice of a rigid body: its points by direction and where they begin, the least and the
#: greatest vertex near the body, and the body's number among those that move freely, else -1.
LATTICE = np.dtype([
    ("points", "i8", 3),
    ("first", "i8"),
    ("least", "i8", 3),
    ("most", "i8", 3),
    ("free", "i8"),
], align=True)  # fmt: skip

#: A rigid body at a point: distance, normal and mean distance; at a vertex the filled part, the
#: area with outward normal, and what curvature adds to the mean gap from a plane.
SURFACE = np.dtype([
    ("distance", "f8"),
    ("normal", "f8", 3),
    ("mean_distance", "f8"),
    ("filled", "f8"),
    ("surface", "f8", 3),
    ("curvature_gap", "f8"),
], align=True)  # fmt: skip

#: What a free rigid body receives: impulse and moment in the step so far, those of the last pass,
#: and minus their derivatives by the velocities along and about x, y, z. In place of these
#: `pgimp.kernels.contact.lagrangian.gauss_seidel` has the body's own response to both.
RESPONSE = np.dtype([
    ("impulse", "f8", 6), ("trial_impulse", "f8", 6), ("derivative", "f8", (6, 6))
], align=True)  # fmt: skip


class Tools(NamedTuple):
    """The rigid bodies of a scene, for kernels.

    Attributes
    ----------
    motion : (tools,) MOTION
        Motion of each in the step, and place of its lattice.
    about : (tools,) LATTICE
        The shape of its lattice, and the vertices near it.
    values : (points, 5) float64
        Those of `DistanceField`, of one body after the other.
    bodies : int
        Number of the bodies with particles, which come first.
    at : (1,) SURFACE
        What was found last.
    answers : (planes, free bodies) RESPONSE or ()
        What free rigid bodies get in a step, and would get.
    """

    motion: np.ndarray
    about: np.ndarray
    values: np.ndarray
    bodies: int
    at: np.ndarray
    answers: Any


#: Place of the answers of free bodies in `Tools`.
ANSWERS = Tools._fields.index("answers")


@inner_kernel
def look_up(tools, t, D, x, y, z):
    """Set distance and normal of body `t` at a point."""
    row, about, at = tools.motion[t], tools.about[t], tools.at[0]
    gap = (x - row.centre[0], y - row.centre[1], z - row.centre[2])
    at.distance = at.mean_distance = at.normal[0] = at.normal[1] = at.normal[2] = 0.0
    place, inside = 0, True
    part = (0.0, 0.0, 0.0)
    step = (0, 0, 0)
    for d in range(D):
        own = row.reference[d]  # the point in the body's own directions
        for k in range(3):
            own += row.rotation[k, d] * gap[k]
        s = (own - row.low[d]) / row.spacing
        most = about.points[d] - 2
        if not (s > -1e-6 and s < most + 1.000001):
            inside = False
        i = min(max(int(s), 0), most) if inside else 0
        f = s - i
        part = (f if d == 0 else part[0], f if d == 1 else part[1], f if d == 2 else part[2])
        place = place * about.points[d] + i
        stride = 1
        for k in range(d + 1, D):
            stride *= about.points[k]
        step = (
            stride if d == 0 else step[0], stride if d == 1 else step[1],
            stride if d == 2 else step[2],
        )  # fmt: skip
    if not inside:
        at.distance = 1e300
        return
    own0, own1, own2 = 0.0, 0.0, 0.0
    for corner in range(1 << D):
        weight, where = 1.0, about.first + place
        for d in range(D):
            if corner >> d & 1:
                weight *= part[d]
                where += step[d]
            else:
                weight *= 1.0 - part[d]
        at.distance += weight * tools.values[where, 0]
        own0 += weight * tools.values[where, 1]
        own1 += weight * tools.values[where, 2]
        own2 += weight * tools.values[where, 3]
        at.mean_distance += weight * tools.values[where, 4]
    length = sqrt(own0 * own0 + own1 * own1 + own2 * own2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    for d in range(3):
        n = row.rotation[d, 0] * own0 + row.rotation[d, 1] * own1
        at.normal[d] = (n + row.rotation[d, 2] * own2) * inverse


@inner_kernel
def lever(arm, d, u):
    """Velocity along `d` of a point at `arm` per unit velocity along, or from 3 on about, `u`."""
    if u < 3:
        return 1.0 if d == u else 0.0
    if d == (u + 1) % 3:
        return -arm[(u + 2) % 3]
    if d == (u + 2) % 3:
        return arm[(u + 1) % 3]
    return 0.0


@inner_kernel
def place_of(frame, number):
    """Place of a vertex, three coordinates."""
    x, y, z = 0.0, 0.0, 0.0
    for d in range(len(frame.cell)):
        place = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d]
        x, y, z = place if d == 0 else x, place if d == 1 else y, place if d == 2 else z
    return x, y, z


@kernel
def distances(tools, t, frame, x, out):
    """Set the distances of points `x`, (n, D), from body `t`; 1e300 of those that are far away."""
    for p in range(len(x)):
        D = len(frame.cell)
        y = x[p, 1] if D > 1 else 0.0
        z = x[p, D - 1] if D > 2 else 0.0
        look_up(tools, t, D, x[p, 0], y, z)
        out[p] = tools.at[0].distance
