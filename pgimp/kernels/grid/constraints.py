"""Prescribed motion of a part of a body: constraints on its particles and on vertices near them.

A constrained particle moves exactly as prescribed, and so do its marked vertices
(`pgimp.kernels.grid.constrained_vertices`). Where a constraint turns, each moves by the chord of
its own circle: no step changes the radius. Chords are linear in space. So the grid gives particles
theirs, and their neighbourhood a rotation without strain.
"""

from pgimp.jit.kernel import inlined, inner_kernel, is_number, kernel
from pgimp.jit.vectors.simd import bits, lane, pack, where
from pgimp.kernels.data.motion import grid_rate
from pgimp.kernels.data.record import ACCELERATION, HELD, MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.grid.constraint_flags import SEVERAL
from pgimp.kernels.loads.loads import given
from pgimp.kernels.loads.prescribed import (
    add_moment,
    place_of,
    places_of_four,
    rate_at,
    velocities_at,
    velocity_at,
)
from pgimp.kernels.transfer.lane_io import take


@inlined
def constrained_velocity(marked, r, v):
    """Velocity of the vertex at `r` with all constraints applied to `v`.

    Parameters
    ----------
    marked : (constraints, mask) or (constraints, mask, Places) or ()
        The constraints and their vertices, see `mark_constrained_vertices`, with `Places` where
        velocities depend on the place. Where constraints share a vertex, the later one applies.
    """
    if len(marked) == 0:
        return v
    constraints, mask = marked[0], marked[1]
    for k in range(len(constraints)):
        if mask[r // RECORD] >> k & 1:
            h, u = constraints[k].held, velocity_at(constraints[k], place_of(marked, r))
            v = (u[0] if h[0] else v[0], u[1] if h[1] else v[1], u[2] if h[2] else v[2])
    return v


@inlined
def former_velocity(marked, r, v, dt):
    """As `constrained_velocity`, at the beginning of a step of the length `dt`."""
    if len(marked) == 0:
        return v
    constraints, mask = marked[0], marked[1]
    for k in range(len(constraints)):
        if mask[r // RECORD] >> k & 1:
            h, x = constraints[k].held, place_of(marked, r)
            u, a = velocity_at(constraints[k], x), rate_at(constraints[k], x)
            v = tuple(u[d] - dt * a[d] if h[d] else v[d] for d in range(3))
    return v


@inlined
def constrained_rate(marked, r, a):
    """Acceleration of the vertex at `r` with all constraints applied to `a`, see above."""
    if len(marked) == 0:
        return a
    constraints, mask = marked[0], marked[1]
    for k in range(len(constraints)):
        if mask[r // RECORD] >> k & 1:
            h, b = constraints[k].held, rate_at(constraints[k], place_of(marked, r))
            a = (b[0] if h[0] else a[0], b[1] if h[1] else a[1], b[2] if h[2] else a[2])
    return a


@inlined
def is_marked(marked, r):
    """Whether a constraint holds the vertex at `r`."""
    if len(marked) == 0:
        return False
    return marked[1][r // RECORD] != 0


@kernel
def apply_constraints(field, forcing, ledger):
    """Set velocity and acceleration of the marked vertices, after the momentum update.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, which has booked gravity's work with the velocity before.
    ledger : Ledger
        `constraint_impulse` grows by the momentum that each constraint gives to the vertices, and
        by its moment where it turns. `work` grows by that momentum times the velocity after the
        last constraint.
    """
    G, active, owned, plane = field.G, field.active, field.owned, field.window.stride[0]
    marked, relaxation = forcing.marked, forcing.loads.relaxation
    dt, gravity, work, impulse = forcing.dt, forcing.gravity, ledger.work, ledger.constraint_impulse
    constraints, mask = marked[0], marked[1]
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
            last, x = constrained_velocity(marked, r, own), place_of(marked, r)
            for k in range(len(constraints)):
                if held >> k & 1 == 0:
                    continue
                velocity, acceleration = velocity_at(constraints[k], x), rate_at(constraints[k], x)
                for d in range(3):
                    if constraints[k].held[d]:
                        v, a = velocity[d], acceleration[d]
                        u, b = G[r + VELOCITY + d], G[r + ACCELERATION + d]
                        change = given(rate, mass, dt, u, b, v, a)
                        work[i] += mass * dt * gravity[d] * (v - u)
                        G[r + VELOCITY + d] = v
                        G[r + ACCELERATION + d] = a
                        G[r + HELD] = SEVERAL
                        impulse[i, k, d] += change
                        add_moment(constraints[k], x, d, change, impulse[i])
                        work[i] += change * last[d]


@inlined
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
    if len(constraints) == 0:
        return (u, v)
    column, rows = particles.constraint, four.rows
    number = pack(*tuple(float(column[rows[j], 0]) for j in range(4)))
    if bits(number > 0.0) == 0:
        return u, v
    m = where(pack(0.0, 1.0, 2.0, 3.0) < four.size, take(particles.m, rows), 0.0)
    x = places_of_four(constraints, particles, rows, u)
    # Branches for single particles would slow down the loop over all.
    for k, one in enumerate(constraints):
        chosen = number == k + 1.0
        w = velocities_at(one, x, chosen)
        _book_moment(one, x, chosen, m, w, v, ledger, four.layer)
        u, v = _hold(one, (four.layer, k, 0), (chosen, m), w, u, v, ledger)
    return u, v


@inlined
def _hold(one, entry, which, w, u, v, ledger):
    """Apply one constraint in the directions from `d` on, one vector each of `u` and `v`.

    `w` are the prescribed velocities from there on; `entry` is the plane and the constraint's
    number in the ledger, and d; `which` are the particles, and their masses.
    """
    if len(u) == 0:
        return (u, v)
    plane, k, d = entry
    chosen, m = which
    U, V = _hold(one, (plane, k, d + 1), which, w[1:], u[1:], v[1:], ledger)
    if not one.held[d]:
        return (u[0], *U), (v[0], *V)
    prescribed = w[0]
    given = where(chosen, m * (prescribed - v[0]), 0.0)
    total = _sum(given)
    ledger.constraint_impulse[plane, k, d] += total
    ledger.work[plane] += _times(given, total, prescribed)
    return (where(chosen, prescribed, u[0]), *U), (where(chosen, prescribed, v[0]), *V)


@inner_kernel
def _sum(values):
    return (lane(values, 0) + lane(values, 1)) + (lane(values, 2) + lane(values, 3))


@inlined
def _times(given, total, w):
    """Sum of four impulses times velocities `w`: four, or one for all, given with their sum."""
    if is_number(w):
        return total * w
    return _sum(given * w)


@inlined
def _book_moment(one, x, chosen, m, w, v, ledger, plane):
    """Book the moment of what a constraint gives to four particles, where it turns."""
    if len(x) < 2:
        return None
    if len(x) == 2:
        if one.moment >= 0:
            c, m = one.centre, where(chosen, m, 0.0)
            each = (x[0] - c[0]) * (m * (w[1] - v[1])) - (x[1] - c[1]) * (m * (w[0] - v[0]))
            ledger.constraint_impulse[plane, one.moment, 2] += _sum(each)
    else:
        if one.moment >= 0:
            c, h, m = one.centre, one.held, where(chosen, m, 0.0)
            a, b, e = x[0] - c[0], x[1] - c[1], x[2] - c[2]
            f = (m if h[0] else 0.0 * m) * (w[0] - v[0])
            g = (m if h[1] else 0.0 * m) * (w[1] - v[1])
            i = (m if h[2] else 0.0 * m) * (w[2] - v[2])
            ledger.constraint_impulse[plane, one.moment, 0] += _sum(b * i - e * g)
            ledger.constraint_impulse[plane, one.moment, 1] += _sum(e * f - a * i)
            ledger.constraint_impulse[plane, one.moment, 2] += _sum(a * g - b * f)
