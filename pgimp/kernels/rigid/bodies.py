"""Rigid bodies for the kernels: how they move, and their distances at points."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel

#: Columns of `Tools.motion`: the reference point now and at the start, the matrix that turns the
#: body, distance of the lattice's points, its first point; velocity and angular velocity at the
#: step's beginning, both at its end; of those that move freely whether slip is viscous in this
#: iteration, and the compliance against held fields, see `pgimp.kernels.contact.law.softness`.
CENTRE, REFERENCE, TURN, SPACING, LOW, FORMER, LATTER, CAUTIOUS = 0, 3, 6, 15, 16, 19, 25, 31
YIELDS, MOTION = 32, 33

#: Columns of `Tools.about`: the lattice's points along each direction, where they begin, the least
#: and greatest vertex near the body, by direction, and its number among those that move freely, -1
#: of others.
SHAPE, FIRST, LEAST, MOST, FREE, ABOUT = 0, 3, 4, 7, 10, 11

#: Columns of `Tools.at`: distance, normal, and mean distance at a point; part filled, area with
#: outward normal, and what curvature adds to the mean gap from a plane.
DISTANCE, NORMAL, MEAN, FILLED, SURFACE, BENT, AT = 0, 1, 4, 5, 6, 9, 10

#: Columns of `Tools.answers`: impulse and moment on a free body in the step so far, those of the
#: last pass, and minus their derivatives by the velocities along and about x, y, z, a matrix of 6 x
#: 6; in its place `pgimp.kernels.contact.lagrangian.gauss_seidel` has the body's own response to
#: impulse and moment.
TAKEN, GIVEN, RESPONSE, ANSWER = 0, 6, 12, 48


class Tools(NamedTuple):
    """The rigid bodies of a scene, for kernels.

    Attributes
    ----------
    motion : (tools, MOTION) float64
        Motion of each in the step, and place of its lattice.
    about : (tools, ABOUT) int64
        The shape of its lattice, and the vertices near it.
    values : (points, 5) float64
        Those of `DistanceField`, of one body after the other.
    bodies : int
        Number of the bodies with particles, which come first.
    at : (AT,) float64
        Room for what was found last.
    answers : (planes, free bodies, ANSWER) float64 or ()
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
    row, about, at = tools.motion[t], tools.about[t], tools.at
    gap = (x - row[CENTRE], y - row[CENTRE + 1], z - row[CENTRE + 2])
    at[: MEAN + 1] = 0.0
    place, inside = 0, True
    part = (0.0, 0.0, 0.0)
    step = (0, 0, 0)
    for d in range(D):
        own = row[REFERENCE + d]  # the point in the body's own directions
        for k in range(3):
            own += row[TURN + 3 * k + d] * gap[k]
        s = (own - row[LOW + d]) / row[SPACING]
        most = about[SHAPE + d] - 2
        if not (s > -1e-6 and s < most + 1.000001):
            inside = False
        i = min(max(int(s), 0), most) if inside else 0
        f = s - i
        part = (f if d == 0 else part[0], f if d == 1 else part[1], f if d == 2 else part[2])
        place = place * about[SHAPE + d] + i
        stride = 1
        for k in range(d + 1, D):
            stride *= about[SHAPE + k]
        step = (
            stride if d == 0 else step[0], stride if d == 1 else step[1],
            stride if d == 2 else step[2],
        )  # fmt: skip
    if not inside:
        at[DISTANCE] = 1e300
        return
    own0, own1, own2 = 0.0, 0.0, 0.0
    for corner in range(1 << D):
        weight, where = 1.0, about[FIRST] + place
        for d in range(D):
            if corner >> d & 1:
                weight *= part[d]
                where += step[d]
            else:
                weight *= 1.0 - part[d]
        at[DISTANCE] += weight * tools.values[where, 0]
        own0 += weight * tools.values[where, 1]
        own1 += weight * tools.values[where, 2]
        own2 += weight * tools.values[where, 3]
        at[MEAN] += weight * tools.values[where, 4]
    length = sqrt(own0 * own0 + own1 * own1 + own2 * own2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    for d in range(3):
        n = row[TURN + 3 * d] * own0 + row[TURN + 3 * d + 1] * own1
        at[NORMAL + d] = (n + row[TURN + 3 * d + 2] * own2) * inverse


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
        out[p] = tools.at[DISTANCE]
