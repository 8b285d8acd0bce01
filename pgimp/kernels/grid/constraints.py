"""Prescribed motion of a part of a body: constraints on its particles and on vertices near them.

A constrained particle moves exactly as prescribed, and so do its marked vertices
(`pgimp.kernels.grid.constrained_vertices`).
"""

from pgimp.jit.kernel import kernel, specialise
from pgimp.jit.vectors.simd import bits, lane, pack, where
from pgimp.kernels.data.motion import grid_rate
from pgimp.kernels.data.record import ACCELERATION, HELD, MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.grid.constraint_flags import SEVERAL
from pgimp.kernels.loads.loads import given
from pgimp.kernels.transfer.lane_io import take


def constrained_velocity(marked, r, v):
    """Velocity of the vertex at `r` with all constraints applied to `v`.

    Parameters
    ----------
    marked : (constraints, mask) or ()
        The constraints and their vertices, see `mark_constrained_vertices`. Where
        constraints share a vertex, the later one applies.
    """


@specialise(constrained_velocity)
def _constrained_velocity(marked, r, v):
    if len(marked) == 0:
        return lambda marked, r, v: v

    def by_constraints(marked, r, v):
        constraints, mask = marked
        for k in range(len(constraints)):
            if mask[r // RECORD] >> k & 1:
                h, u = constraints[k].held, constraints[k].velocity
                v = (u[0] if h[0] else v[0], u[1] if h[1] else v[1], u[2] if h[2] else v[2])
        return v

    return by_constraints


def former_velocity(marked, r, v, dt):
    """As `constrained_velocity`, at the beginning of a step of the length `dt`."""


@specialise(former_velocity)
def _former_velocity(marked, r, v, dt):
    if len(marked) == 0:
        return lambda marked, r, v, dt: v

    def by_constraints(marked, r, v, dt):
        constraints, mask = marked
        for k in range(len(constraints)):
            if mask[r // RECORD] >> k & 1:
                h, u, a = constraints[k].held, constraints[k].velocity, constraints[k].rate
                v = (
                    u[0] - dt * a[0] if h[0] else v[0],
                    u[1] - dt * a[1] if h[1] else v[1],
                    u[2] - dt * a[2] if h[2] else v[2],
                )
        return v

    return by_constraints


def is_marked(marked, r):
    """Whether a constraint holds the vertex at `r`."""


@specialise(is_marked)
def _is_marked(marked, r):
    if len(marked) == 0:
        return lambda marked, r: False
    return lambda marked, r: marked[1][r // RECORD] != 0


@kernel
def apply_constraints(field, forcing, ledger):
    """Set velocity and acceleration of the marked vertices, after the momentum update.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, which has booked gravity's work with the velocity before.
    ledger : Ledger
        `constraint_impulse` grows by the momentum that each constraint gives to the vertices,
        `work` by that momentum times the velocity after the last constraint.
    """
    G, active, owned, plane = field.G, field.active, field.owned, field.window.stride[0]
    marked, relaxation = forcing.marked, forcing.loads.relaxation
    dt, gravity, work, impulse = forcing.dt, forcing.gravity, ledger.work, ledger.constraint_impulse
    constraints, mask = marked
    size = field_size(field.window)
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, RECORD):
            held = mask[r // RECORD]
            if held == 0 or not G[r + MASS] > 0.0:
                continue
            rate = grid_rate(relaxation, field.motion, (r - i * plane) // size)
            mass = G[r + MASS] if i < owned else 0.0
            own = (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
            last = constrained_velocity(marked, r, own)
            for k in range(len(constraints)):
                if held >> k & 1 == 0:
                    continue
                for d in range(3):
                    if constraints[k].held[d]:
                        v, a = constraints[k].velocity[d], constraints[k].rate[d]
                        u, b = G[r + VELOCITY + d], G[r + ACCELERATION + d]
                        change = given(rate, mass, dt, u, b, v, a)
                        work[i] += mass * dt * gravity[d] * (v - u)
                        G[r + VELOCITY + d] = v
                        G[r + ACCELERATION + d] = a
                        G[r + HELD] = SEVERAL
                        impulse[i, k, d] += change
                        work[i] += change * last[d]


def constrain_particles(constraints, particles, four, u, v, ledger):
    """Velocities of four particles, and velocities of its motion, after its constraints.

    Parameters
    ----------
    particles, four
        See `Particles`, `FourParticles`.
    u, v : tuple of Vec4
        For each direction, the velocities of four particles.
    ledger : Ledger
        `constraint_impulse` and `work` grow.
    """


def _held(constraints, k, number, m, u, v, ledger, plane):
    """Apply the constraints from number `k` on, given in `constraints`.

    `number` is each particle's constraint, from 1; `m` is zero for particles that do not
    count. Branches for single particles would slow down the loop over all.
    """


@specialise(_held)
def _held_by_each(constraints, k, number, m, u, v, ledger, plane):
    if len(constraints) == 0:
        return lambda constraints, k, number, m, u, v, ledger, plane: (u, v)

    def held(constraints, k, number, m, u, v, ledger, plane):
        chosen = number == k + 1.0
        U, V = _hold(constraints[0], 0, chosen, m, u, v, ledger, (plane, k))
        return _held(constraints[1:], k + 1, number, m, U, V, ledger, plane)

    return held


def _hold(one, d, chosen, m, u, v, ledger, entry):
    """Apply one constraint in the directions from `d` on, one vector each of `u` and `v`.

    `entry` is the plane and the constraint's number in the ledger.
    """


@specialise(_hold)
def _hold_along(one, d, chosen, m, u, v, ledger, entry):
    if len(u) == 0:
        return lambda one, d, chosen, m, u, v, ledger, entry: (u, v)

    def hold(one, d, chosen, m, u, v, ledger, entry):
        U, V = _hold(one, d + 1, chosen, m, u[1:], v[1:], ledger, entry)
        if not one.held[d]:
            return (u[0], *U), (v[0], *V)
        prescribed = one.velocity[d]
        given = where(chosen, m * (prescribed - v[0]), 0.0)
        total = (lane(given, 0) + lane(given, 1)) + (lane(given, 2) + lane(given, 3))
        plane, k = entry
        ledger.constraint_impulse[plane, k, d] += total
        ledger.work[plane] += total * prescribed
        return (where(chosen, prescribed, u[0]), *U), (where(chosen, prescribed, v[0]), *V)

    return hold


@specialise(constrain_particles)
def _constrain_particles(constraints, particles, four, u, v, ledger):
    if len(constraints) == 0:
        return lambda constraints, particles, four, u, v, ledger: (u, v)

    def constrain_particles(constraints, particles, four, u, v, ledger):
        column, rows = particles.constraint, four.rows
        number = pack(
            float(column[rows[0], 0]),
            float(column[rows[1], 0]),
            float(column[rows[2], 0]),
            float(column[rows[3], 0]),
        )
        if bits(number > 0.0) == 0:
            return u, v
        m = where(pack(0.0, 1.0, 2.0, 3.0) < four.size, take(particles.m, rows), 0.0)
        return _held(constraints, 0, number, m, u, v, ledger, four.layer)

    return constrain_particles
