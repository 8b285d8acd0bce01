"""Rest of particles on walls: velocities that the grid cannot remove.

Held vertices have no acceleration, whatever momentum particles bring there: otherwise a wall would
brake every motion that grows from it. So a particle whose support is mostly on held vertices keeps
its former velocity, though it does not move. Sand at rest on a fixed floor keeps the speed of its
fall.

Such a particle of a flowing material (`Material.RESTS`) loses the difference between its velocity
and its actual motion, over part of a cell. A difference d falls as exp(-STOPS (1 - 2 z/h) s/h), s
being the distance by d, and z < h/2 the particle's distance from the wall. About 1 - z/h of its
support is held, more than half. Elastic materials keep the difference: they do not come to rest in
this way. The wall takes the momentum, does work only where it moves, and books the remaining loss.
Kinetic energy relative to the wall never grows.
"""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_empty
from pgimp.jit.tuples import plus_scaled
from pgimp.jit.vectors.lanes import of_lane
from pgimp.jit.vectors.simd import bits, vector, with_lane
from pgimp.kernels.data.ledger import WALL_LOSS
from pgimp.kernels.grid.position_limits import COORDINATE, HOLDS, MOTION, NUMBER
from pgimp.kernels.transfer.lane_io import LANES, coordinates

#: The inverse of the distance, in cells, over which the difference falls by a factor of e.
STOPS = 10.0

#: Distance from a wall, in cells, within which a particle is mostly held.
NEAR = 0.5


@inlined
def _any_near(frame, walls, x, d):
    """Bit j is set where particle j is near a wall that holds every component, from axis `d` on."""
    if len(x) == 0:
        return 0
    found = _any_near(frame, walls, x[1:], d + 1)
    for end in range(2):
        wall = walls[2 * d + end]
        if wall[HOLDS] > 0.0:
            far = (x[0] - wall[COORDINATE]) * frame.inverse[d]
            found |= bits(far * far < NEAR * NEAR)
    return found


@inner_kernel
def _nearest(frame, walls, x):
    """The nearest wall that holds every component, and its distance from x in cells; -1: none."""
    found, least = -1, NEAR
    for d in range(len(x)):
        for end in range(2):
            wall = walls[2 * d + end]
            far = abs(x[d] - wall[COORDINATE]) * frame.inverse[d]
            if wall[HOLDS] > 0.0 and far < least:
                found, least = 2 * d + end, far
    return found, least


@inner_kernel
def _lost_part(frame, dt, far, wall, u, v):
    """Part of the difference v - u that a particle loses in a step, `far` from a wall in cells."""
    rate, square, along = 0.0, 0.0, 0.0
    for d in range(len(u)):
        off = v[d] - u[d]
        rate += (off * frame.inverse[d]) ** 2
        square += off * off
        along += off * (v[d] - wall[MOTION + d])
    if not along > 0.0:
        return 0.0
    most = min(along / square, 1.0)
    return min(STOPS * (1.0 - far / NEAR) * dt * sqrt(rate), most)


@inner_kernel
def _settled_part(frame, forcing, m, x, motion, ledger, layer):
    """Part of the difference that a particle of mass m at x loses in a step; books the loss.

    `motion` is its velocity and the velocity of its motion.
    """
    n, far = _nearest(frame, forcing.position_limits, x)
    if n < 0:
        return 0.0
    (v, u), wall = motion, forcing.position_limits[n]
    lost, face = _lost_part(frame, forcing.dt, far, wall, u, v), int(wall[NUMBER])
    for d in range(len(x)):
        change = lost * (u[d] - v[d])
        ledger.impulse[layer, face, d] += m * change
        ledger.work[layer] += m * change * wall[MOTION + d]
        against = v[d] + 0.5 * change - wall[MOTION + d]
        ledger.wall_energy[layer, face, WALL_LOSS] -= m * change * against
    return lost


@inlined
def settle(rest, frame, forcing, particles, four, motion, ledger):
    """Velocities of four particles, reduced for held ones.

    Parameters
    ----------
    rest
        See `Loads`.
    frame, forcing, particles, four, ledger
        See `Frame`, `Forcing`, `Particles`, `FourParticles`, `Ledger`.
    motion : tuple
        Their velocities, and the velocities of their motion.
    """
    if is_empty(rest):
        return motion[0]
    v, u = motion
    x = coordinates(frame, particles, four.rows)
    if _any_near(frame, forcing.position_limits, x, 0) == 0:
        return v
    lost, part = vector(0.0), 0.0
    for j in range(LANES):
        if j < four.size:  # else a repetition of the last one
            p, part = four.rows[j], 0.0
            if rest[particles.body[p]]:
                part = _settled_part(
                    frame,
                    forcing,
                    particles.m[p],
                    of_lane(x, j),
                    of_lane(motion, j),
                    ledger,
                    four.layer,
                )
        lost = with_lane(lost, j, part)
    return plus_scaled(lost, u, plus_scaled(-lost, v, v))
