"""Particles held out of rigid bodies.

Vertices near a surface have the mean velocity of all material around them, and small filled parts
give no gap. So thin tongues of a flow, and single particles, would penetrate a rigid body. A
particle whose centre has passed the surface is moved back onto it. Its velocity into the body
becomes the body's, with friction, as in an inelastic impact. The impulse counts for the pair like
impulses at the vertices, and is booked like them. Of a cut particle the centroid counts.
"""

from math import floor, inf, sqrt
from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.simd import lane, vector
from pgimp.kernels.contact.sliding import sliding_part
from pgimp.kernels.data.ledger import (
    HEAT,
    IMPULSE,
    NORMAL_IMPULSE,
    RIGID_IMPULSE,
    RIGID_MOMENT,
    RIGID_WORK,
    TANGENTIAL_IMPULSE,
)
from pgimp.kernels.grid.position_limits import free_part
from pgimp.kernels.rigid.bodies import (
    BLOCK,
    RigidBodies,
    arm_of,
    find_distance,
    place_in_lattice,
    repeat,
)
from pgimp.kernels.transfer.lane_io import take_row
from pgimp.physics.contact.base import UNILATERAL
from pgimp.physics.contact.pairs import Pairs

#: Least part of a normal's square that no constraint prescribes: with less nothing is held.
LEAST_FREE = 0.1


class PenetrationLimits(NamedTuple):
    """Data to hold particles out of rigid bodies in a step."""

    rigid_bodies: RigidBodies  #: The rigid bodies at their positions of the step's end.
    pairs: Pairs  #: The laws of contact.
    #: (rigid bodies, 6, 6) float64: Velocities along and about x, y, z of a free body per impulse
    #: and moment. They are times the greatest mass of the particles that it may hold; 0 for others.
    compliance: np.ndarray
    #: (layers, rigid bodies, 6) float64: Grows by impulse and moment on each body.
    impulses: np.ndarray


@inlined
def project_out(limits, forcing, particles, four, x, v, ledger):
    """Hold four stored particles out of rigid bodies; returns their positions and velocities.

    Parameters
    ----------
    limits : PenetrationLimits or ()
        () in scenes without rigid bodies.
    forcing, particles, four, ledger
        See `Forcing`, `Particles`, `FourParticles`, `Ledger`.
    x, v : tuple of D Vec4
        Their positions and velocities.
    """
    if not is_record(limits):
        return (x, v)
    near, held = 0, 0
    for t in range(len(limits.rigid_bodies.motion)):
        near |= _may_be_within(limits, t, x)
    if near != 0:
        for j in range(four.size):
            if near >> j & 1 == 0:
                continue
            for t in range(len(limits.rigid_bodies.motion)):
                held += _hold(limits, forcing, particles, four.rows[j], t, four.layer, ledger)
    if held > 0:
        x = take_row(particles.x, four.rows, 0, x)
        v = take_row(particles.v, four.rows, 0, v)
    return x, v


@inlined
def _may_be_within(limits, t, x):
    """Bits of those of four points that may be within a lattice's spacing of body `t`.

    Blocks of its lattice tell: of few numbers, which stay in the cache. `x` is a tuple of D Vec4.
    """
    if repeat(limits.rigid_bodies):
        return 15
    row, lattice, at = limits.rigid_bodies.motion[t], limits.rigid_bodies.lattice[t], vector(0.0)
    by = 1.0 / (BLOCK * row.spacing)
    for d in range(len(x)):
        place = vector((row.reference[d] - row.low[d]) * by + 0.5 / BLOCK)
        for k in range(len(x)):
            place = place + row.rotation[k, d] * by * (x[k] - row.centre[k])
        count = float((lattice.points[d] + BLOCK - 1) // BLOCK)
        at = at * count + min(max(floor(place), 0.0), count - 1.0)
    found = 0
    for j in range(4):
        first = lattice.first_block + int(lane(at, j))
        found |= (limits.rigid_bodies.blocks[first] < row.spacing) << j
    return found


@inner_kernel
def _is_within(rigid_bodies, t, D, x, reach):
    """Whether a point may be within `reach` of body `t`, by the nearest point of its lattice."""
    row, lattice = rigid_bodies.motion[t], rigid_bodies.lattice[t]
    offset = 0
    for d in range(D):
        s = place_in_lattice(rigid_bodies, t, x, d)
        if not (s > -0.5 and s < lattice.points[d] - 0.5):
            return False
        offset = offset * lattice.points[d] + int(s + 0.5)
    return rigid_bodies.values[lattice.first + offset, 0] < row.spacing + reach


@inner_kernel
def position_of_particle(particles, p):
    """Position of a particle, three coordinates."""
    D = particles.x.shape[1]
    return (
        particles.x[p, 0],
        particles.x[p, 1] if D > 1 else 0.0,
        particles.x[p, D - 1] if D > 2 else 0.0,
    )


@kernel
def count_near(rigid_bodies, particles, rows, reach, counts, most):
    """Count the particles within `reach` of each free body; find the greatest mass.

    Parameters
    ----------
    rows : (n,) int32
        The particles.
    counts, most : (rigid bodies,) int64, (rigid bodies,) float64
        Set here.
    """
    counts[:], most[:] = 0, 0.0
    for t in range(len(rigid_bodies.motion)):
        if rigid_bodies.lattice[t].free < 0:
            continue
        for p in rows:
            if _is_within(
                rigid_bodies, t, particles.x.shape[1], position_of_particle(particles, p), reach
            ):
                counts[t] += 1
                most[t] = max(most[t], particles.m[p])


@kernel
def count_inside(rigid_bodies, pairs, particles, rows, depth, counts):
    """Count the particles whose centroids are deeper than `depth` in each rigid body.

    Particles that pass through it, by `law: ignore`, do not count.

    Parameters
    ----------
    rows : (n,) int32
        The particles.
    counts : (rigid bodies,) int64
        Set here.
    """
    counts[:] = 0
    for t in range(len(rigid_bodies.motion)):
        for p in rows:
            D, x = particles.x.shape[1], position_of_particle(particles, p)
            if (
                pairs.entry[particles.body[p], rigid_bodies.bodies + t] == 0
            ):  # bodies of a material first
                continue
            if _is_within(rigid_bodies, t, D, x, 0.0):
                find_distance(rigid_bodies, t, D, x[0], x[1], x[2])
                n = (
                    rigid_bodies.point[0].normal[0],
                    rigid_bodies.point[0].normal[1],
                    rigid_bodies.point[0].normal[2],
                )
                counts[t] += rigid_bodies.point[0].distance + _material(particles, p, n) < -depth


@inner_kernel
def _material(particles, p, n):
    """Distance along `n` from a cut particle's position to its centroid, at most initially."""
    D, along, square = particles.x.shape[1], 0.0, 0.0
    for d in range(D):
        square += particles.offset[p, d] ** 2
        for e in range(D):
            along += n[d] * particles.F[p, d * D + e] * particles.offset[p, e]
    return min(max(along, 0.0), sqrt(square))


@inner_kernel
def _answer(compliance, arm):
    """Trace of the velocities of a point per impulse there, at `arm`, along x, y, z."""
    found = 0.0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        found += compliance[
            d, d
        ]  # an impulse along d has the moment -arm[e] about f, arm[f] about e
        found += compliance[3 + f, 3 + f] * arm[e] ** 2 + compliance[3 + e, 3 + e] * arm[f] ** 2
        found -= (compliance[3 + e, 3 + f] + compliance[3 + f, 3 + e]) * arm[e] * arm[f]
    return found


@inner_kernel
def _hold(limits, forcing, particles, p, t, layer, ledger):
    """Hold particle `p` out of body `t`; returns 1 if it was changed, else 0."""
    rigid_bodies, D = limits.rigid_bodies, particles.x.shape[1]
    point, motion = rigid_bodies.point[0], rigid_bodies.motion[t]
    x = position_of_particle(particles, p)
    if not _is_within(rigid_bodies, t, D, x, 0.0):
        return 0
    find_distance(rigid_bodies, t, D, x[0], x[1], x[2])
    if not point.distance < 0.0:
        return 0
    n = (point.normal[0], point.normal[1], point.normal[2])
    depth = -point.distance - _material(particles, p, n)
    one, other = particles.body[p], rigid_bodies.bodies + t
    entry = limits.pairs.entry[min(one, other), max(one, other)]
    g = free_part(forcing.constraints, particles, p, n)
    square = g[0] ** 2 + g[1] ** 2 + g[2] ** 2
    if not depth > 0.0 or entry == 0 or square < LEAST_FREE:
        return 0
    for d in range(D):
        way = depth / square * g[d]
        particles.x[p, d] += way
        ledger.work[layer] += particles.m[p] * forcing.gravity[d] * way
    on = (x[0] + depth * n[0], x[1] + depth * n[1], x[2] + depth * n[2])
    arm = arm_of(rigid_bodies, t, on)
    moving = motion.velocity_after
    own = (
        moving[0] + moving[4] * arm[2] - moving[5] * arm[1],
        moving[1] + moving[5] * arm[0] - moving[3] * arm[2],
        moving[2] + moving[3] * arm[1] - moving[4] * arm[0],
    )
    free = free_part(forcing.constraints, particles, p, (1.0, 1.0, 1.0))
    _stop(limits, particles, p, t, (entry, layer), (n, free, square), (arm, own), ledger)
    return 1


@inner_kernel
def _stop(limits, particles, p, t, booking, normals, point, ledger):
    """Remove the velocity of particle `p` into body `t`, and the friction's part across it."""
    (entry, layer), (n, free, square), (arm, own) = booking, normals, point
    pairs, m, D = limits.pairs, particles.m[p], particles.x.shape[1]
    normal, across = 0.0, 0.0
    for d in range(D):
        normal += (particles.v[p, d] - own[d]) * n[d]
    if not normal < 0.0:
        return
    for d in range(D):
        across += (particles.v[p, d] - own[d] - normal * n[d]) ** 2
    across = sqrt(across)
    mass = m / (1.0 + _answer(limits.compliance[t], arm))  # never too much for all of them together
    part, law = 1.0, abs(entry) - 1
    if pairs.kind[law] == UNILATERAL:
        part = sliding_part(pairs, law, 0.0, -normal, inf, across, across)
    booked, mine = ledger.contact[layer, law], ledger.rigid_bodies[layer, t]
    J, done, heat = (0.0, 0.0, 0.0), 0.0, 0.0
    for d in range(D):
        slip = particles.v[p, d] - own[d] - normal * n[d]
        stick = -mass * part * slip * free[d]
        j = stick - mass * normal / square * n[d] * free[d]
        J = (j if d == 0 else J[0], j if d == 1 else J[1], j if d == 2 else J[2])
        particles.v[p, d] += j / m
        done += j * own[d]
        heat -= stick * (slip + stick / m)
        booked[IMPULSE + d] += j if entry > 0 else -j
    booked[NORMAL_IMPULSE] -= mass * normal
    booked[TANGENTIAL_IMPULSE] += mass * part * across
    booked[HEAT] += heat
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        moment = arm[e] * J[f] - arm[f] * J[e]
        mine[RIGID_IMPULSE + d] -= J[d]
        mine[RIGID_MOMENT + d] -= moment
        limits.impulses[layer, t, d] -= J[d]
        limits.impulses[layer, t, 3 + d] -= moment
    if limits.rigid_bodies.lattice[t].free < 0:  # else known when all impulses are
        mine[RIGID_WORK] += done
        ledger.work[layer] += done
