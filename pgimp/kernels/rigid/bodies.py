"""Rigid bodies for the kernels: their motion, and signed distances at points."""

from math import floor, sqrt
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inlined, inner_kernel, is_array, is_record, kernel
from pgimp.jit.memory import structure

#: A rigid body in a step: current and initial reference point, matrix of rotation, spacing and
#: first point of the lattice. In periodic domains also the lattice's current middle, and the way
#: there from the reference point. Velocity and angular velocity are at the step's beginning and
#: end. For a free body, whether slip is viscous in this iteration, and its compliance against held
#: fields, see `pgimp.kernels.contact.law.held_compliance`.
MOTION = structure(
    ("centre", "f8", 3),
    ("reference", "f8", 3),
    ("rotation", "f8", (3, 3)),
    ("spacing", "f8"),
    ("low", "f8", 3),
    ("middle", "f8", 3),
    ("lever", "f8", 3),
    ("velocity_before", "f8", 6),
    ("velocity_after", "f8", 6),
    ("viscous_slip", "f8"),
    ("compliance", "f8"),
)

#: The lattice of a rigid body: its points by direction, their first offset, and the least and the
#: greatest vertex near the body. Then the body's number among the free ones, else -1, and its first
#: entry in `RigidBodies.blocks`.
LATTICE = structure(
    ("points", "i8", 3), ("first", "i8"), ("least", "i8", 3), ("most", "i8", 3), ("free", "i8"),
    ("first_block", "i8"),
)  # fmt: skip

#: Points by direction of a block of a lattice, see `RigidBodies.blocks`.
BLOCK = 2

#: A rigid body at a point: distance, normal and mean distance. At a vertex: filled part, area with
#: outward normal, and curvature's share of the mean gap from a plane.
POINT = structure(
    ("distance", "f8"),
    ("normal", "f8", 3),
    ("mean_distance", "f8"),
    ("filled", "f8"),
    ("surface", "f8", 3),
    ("curvature_gap", "f8"),
)

#: Impulses on a free rigid body: impulse and moment in the step so far and in the last pass. Then
#: minus their derivatives by the velocities along and about x, y, z. In place of the derivatives
#: `pgimp.kernels.contact.impulses.gauss_seidel` has the body's own response to both.
RESPONSE = structure(("impulse", "f8", 6), ("trial_impulse", "f8", 6), ("derivative", "f8", (6, 6)))


class RigidBodies(NamedTuple):
    """The rigid bodies of a scene, for kernels."""

    #: (rigid bodies,) MOTION: Motion of each in the step, and position of its lattice.
    motion: np.ndarray
    #: (rigid bodies,) LATTICE: The shape of its lattice, and the vertices near it.
    lattice: np.ndarray
    #: (points, 5) float64: Values of each `DistanceField`, one body after the other.
    values: np.ndarray
    #: (blocks,) float64: Least distance at the points of each block, and one point beside it.
    blocks: np.ndarray
    bodies: int  #: Number of the bodies with particles, which come first.
    point: np.ndarray  #: (1,) SURFACE: Scratch for the last result.
    #: (planes, free bodies) RESPONSE or (): Impulses on free rigid bodies in a step, and their
    #: derivatives.
    responses: Any
    #: (3,) float64 or (): Period by direction, 0 where there is none; () if no face is periodic.
    periods: Any


#: The rigid bodies of a scene; () without any.
AnyRigidBodies = RigidBodies | tuple[()]


@inlined
def repeat(rigid_bodies):
    """Whether some rigid bodies have images: in periodic domains."""
    return is_record(rigid_bodies) and is_array(rigid_bodies.periods)


@inlined
def move_freely(rigid_bodies):
    """Whether some rigid bodies move freely."""
    return is_record(rigid_bodies) and is_array(rigid_bodies.responses)


@inlined
def arm_of(rigid_bodies, t, x):
    """Vector from the centre of body `t`, or of its nearest image, to a point, a triple."""
    if repeat(rigid_bodies):
        gap, lever = _gap(rigid_bodies, t, x), rigid_bodies.motion[t].lever
        return gap[0] + lever[0], gap[1] + lever[1], gap[2] + lever[2]
    centre = rigid_bodies.motion[t].centre
    return x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]


@inlined
def place_in_lattice(rigid_bodies, t, x, d):
    """Coordinate of a point along `d` in the lattice of body `t`, or of its nearest image."""
    if repeat(rigid_bodies):
        row, gap, own = rigid_bodies.motion[t], _gap(rigid_bodies, t, x), 0.0
        for k in range(3):
            own += row.rotation[k, d] * gap[k]
        return own / row.spacing + 0.5 * (rigid_bodies.lattice[t].points[d] - 1)
    row = rigid_bodies.motion[t]
    own = row.reference[d]  # the point in the body's own directions
    for k in range(3):
        own += row.rotation[k, d] * (x[k] - row.centre[k])
    return (own - row.low[d]) / row.spacing


@inner_kernel
def _gap(rigid_bodies, t, x):
    """Vector from the middle of body `t`, or of its nearest image, to a point."""
    periods, middle = rigid_bodies.periods, rigid_bodies.motion[t].middle
    return tuple(_nearest(x[d] - middle[d], periods[d]) for d in range(3))


@inner_kernel
def _nearest(gap, period):
    """Return a coordinate less the whole periods in it."""
    return gap - floor(gap / period + 0.5) * period if period > 0.0 else gap


@inner_kernel
def _locate(rigid_bodies, t, D, x, y, z):
    """Find the cell of the lattice of body `t` that a point is in.

    Returns whether there is one, its first point, the distances of its points along each
    direction, and the point's place between them.
    """
    lattice = rigid_bodies.lattice[t]
    offset, inside = 0, True
    part = (0.0, 0.0, 0.0)
    step = (0, 0, 0)
    for d in range(D):
        s = place_in_lattice(rigid_bodies, t, (x, y, z), d)
        most = lattice.points[d] - 2
        if not (s > -1e-6 and s < most + 1.000001):
            inside = False
        i = min(max(int(s), 0), most) if inside else 0
        f = s - i
        part = (f if d == 0 else part[0], f if d == 1 else part[1], f if d == 2 else part[2])
        offset = offset * lattice.points[d] + i
        stride = 1
        for k in range(d + 1, D):
            stride *= lattice.points[k]
        step = (
            stride if d == 0 else step[0],
            stride if d == 1 else step[1],
            stride if d == 2 else step[2],
        )
    return inside, lattice.first + offset, step, part


@inlined
def turns_back(rigid_bodies):
    """Whether a line of vertices comes from one image of a body to the next."""
    if repeat(rigid_bodies):
        return True
    return False


@inner_kernel
def least_distance(rigid_bodies, t, D, x, y, z):
    """Least distance from body `t` on the lattice's points around a point; 1e300 if far from it."""
    inside, first, step, _ = _locate(rigid_bodies, t, D, x, y, z)
    if not inside:
        return 1e300
    least = rigid_bodies.values[first, 0]
    for corner in range(1, 1 << D):
        where = first
        for d in range(D):
            where += step[d] if corner >> d & 1 else 0
        least = min(least, rigid_bodies.values[where, 0])
    return least


@inner_kernel
def find_distance(rigid_bodies, t, D, x, y, z):
    """Set distance and normal of body `t` at a point."""
    row, point = rigid_bodies.motion[t], rigid_bodies.point[0]
    point.distance = point.mean_distance = point.normal[0] = point.normal[1] = point.normal[2] = 0.0
    inside, first, step, part = _locate(rigid_bodies, t, D, x, y, z)
    if not inside:
        point.distance = 1e300
        return
    own0, own1, own2 = 0.0, 0.0, 0.0
    for corner in range(1 << D):
        weight, where = 1.0, first
        for d in range(D):
            if corner >> d & 1:
                weight *= part[d]
                where += step[d]
            else:
                weight *= 1.0 - part[d]
        point.distance += weight * rigid_bodies.values[where, 0]
        own0 += weight * rigid_bodies.values[where, 1]
        own1 += weight * rigid_bodies.values[where, 2]
        own2 += weight * rigid_bodies.values[where, 3]
        point.mean_distance += weight * rigid_bodies.values[where, 4]
    length = sqrt(own0 * own0 + own1 * own1 + own2 * own2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    for d in range(3):
        n = row.rotation[d, 0] * own0 + row.rotation[d, 1] * own1
        point.normal[d] = (n + row.rotation[d, 2] * own2) * inverse


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
def position_of(frame, number):
    """Position of a vertex, three coordinates."""
    x, y, z = 0.0, 0.0, 0.0
    for d in range(len(frame.cell)):
        here = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d]
        x, y, z = here if d == 0 else x, here if d == 1 else y, here if d == 2 else z
    return x, y, z


@kernel
def distances(rigid_bodies, t, frame, x, out):
    """Set the distances of points `x`, (n, D), from body `t`; 1e300 for distant points."""
    for p in range(len(x)):
        D = len(frame.cell)
        y = x[p, 1] if D > 1 else 0.0
        z = x[p, D - 1] if D > 2 else 0.0
        find_distance(rigid_bodies, t, D, x[p, 0], y, z)
        out[p] = rigid_bodies.point[0].distance
