"""Velocities of particles that walls hold: what the grid cannot take from them.

Vertices that a wall holds have no acceleration, whatever momentum particles bring there: otherwise
a wall would brake every motion that grows from it. So a particle whose support is mostly on such
vertices keeps the velocity with which it came, though it does not move: sand that lies at rest on a
fixed floor at the speed of its fall.

Such a particle loses the difference between its velocity and that at which it moves, as it would
have gone a part of a cell by it: by itself a difference d falls as exp(-STOPS (2 W - 1) s/h), s
being the way by d, and W > 1/2 the held part of the support. Smooth motion has hardly any: in
waves the loss is of third order in their amplitude. The wall takes the momentum, does work only
where it moves, and books what else is lost. No kinetic energy is gained, as the wall sees it.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.lanes import of_lane
from pgimp.jit.simd import bits, lane, vector, with_lane
from pgimp.jit.tuples import plus_scaled
from pgimp.kernels.fours import LANES, coordinates
from pgimp.kernels.heldcodes import SEVERAL
from pgimp.kernels.ledger import WALL_LOSS
from pgimp.kernels.walls import HOLDS, MOTION, NUMBER, PLACE

#: The inverse of the way, in cells, by which the difference falls by a factor of e.
STOPS = 10.0

#: Least held part of a particle's support at which it counts as held.
MOSTLY = 0.5


@inner_kernel
def _nearest(frame, walls, x):
    """The nearest wall that holds every component, within a cell of a particle at x; -1: none."""
    found, least = -1, 1.0
    for d in range(len(x)):
        for end in range(2):
            wall = walls[2 * d + end]
            far = abs(x[d] - wall[PLACE]) * frame.inverse[d]
            if wall[HOLDS] > 0.0 and far < least:
                found, least = 2 * d + end, far
    return found


@inner_kernel
def _lost_part(frame, dt, part, wall, u, v):
    """Part of the difference v - u that a particle loses in a step, `part` of it being held."""
    rate, square, along = 0.0, 0.0, 0.0
    for d in range(len(u)):
        off = v[d] - u[d]
        rate += (off * frame.inverse[d]) ** 2
        square += off * off
        along += off * (v[d] - wall[MOTION + d])
    if not along > 0.0:
        return 0.0
    most = min(along / square, 1.0)
    return min(STOPS * (part - MOSTLY) / (1.0 - MOSTLY) * dt * sqrt(rate), most)


@inner_kernel
def _settled_part(frame, forcing, m, x, motion, held, ledger, layer):
    """Part of the difference that a particle of mass m at x loses in a step; books that.

    `motion` are its velocity and that at which it moves; `held` is the sum of its codes.
    """
    part = held / SEVERAL
    if not part > MOSTLY:
        return 0.0
    n = _nearest(frame, forcing.walls, x)
    if n < 0:
        return 0.0
    (v, u), wall = motion, forcing.walls[n]
    lost, face = _lost_part(frame, forcing.dt, min(part, 1.0), wall, u, v), int(wall[NUMBER])
    for d in range(len(x)):
        change = lost * (u[d] - v[d])
        ledger.impulse[layer, face, d] += m * change
        ledger.work[layer] += m * change * wall[MOTION + d]
        against = v[d] + 0.5 * change - wall[MOTION + d]
        ledger.walls[layer, face, WALL_LOSS] -= m * change * against
    return lost


def settle(rest, frame, forcing, particles, batch, motion, held, ledger):
    """Velocities of four particles, less what those lose that are held.

    Parameters
    ----------
    rest
        See `Loads`.
    frame, forcing, particles, batch, ledger
        See `Frame`, `Forcing`, `Particles`, `Batch`, `Ledger`.
    motion : tuple
        Their velocities, and those at which they move.
    held : Vec4
        Weighted sums of `HELD`.
    """


@specialise(settle)
def _settle(rest, frame, forcing, particles, batch, motion, held, ledger):
    if hasattr(rest, "count"):  # ()
        return lambda rest, frame, forcing, particles, batch, motion, held, ledger: motion[0]

    def settled(rest, frame, forcing, particles, batch, motion, held, ledger):
        v, u = motion
        if bits(held > MOSTLY * SEVERAL) == 0:
            return v
        x = coordinates(frame, particles, batch.rows)
        lost, part = vector(0.0), 0.0
        for j in range(LANES):
            if j < batch.size:  # else as the last one, for which it fills in
                part = _settled_part(
                    frame, forcing, particles.m[batch.rows[j]], of_lane(x, j), of_lane(motion, j),
                    lane(held, j), ledger, batch.layer,
                )  # fmt: skip
            lost = with_lane(lost, j, part)
        return plus_scaled(lost, u, plus_scaled(-lost, v, v))

    return settled
