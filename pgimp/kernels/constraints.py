"""Prescribed motion of a part of a body: constraints on its particles and on vertices near them.

A constrained particle moves exactly as prescribed. It also marks the vertices of its support; these
are constrained too, so that the material around moves with the particles and does not tear from
them prematurely. A constraint therefore acts up to a vertex near the edge of its region: exactly up
to the edge where that is a plane of vertices, else up to a cell further, and this vertex changes as
the region moves. Marks in planes that two ranks share are combined with ``or``, so that their order
does not matter.
"""

from pgimp.jit.kernel import kernel, specialise
from pgimp.jit.simd import bits, lane, pack, stack, where
from pgimp.kernels.batch import SUPPORT_SIZE, entry, extent, first_place, supports
from pgimp.kernels.cornertransfer import corner
from pgimp.kernels.fours import LANES, four, take
from pgimp.kernels.heldcodes import LEAST_WEIGHT, SEVERAL
from pgimp.kernels.loads import given
from pgimp.kernels.record import ACCELERATION, HELD, MASS, RECORD, VELOCITY
from pgimp.kernels.transfer import Support
from pgimp.physics.shapes.base import by_corners


def any_held(particles, rows):
    """Whether a constraint holds one of four particles."""


@specialise(any_held)
def _any_held(particles, rows):
    def any_held(particles, rows):
        held = particles.constraint
        return (held[rows[0], 0] | held[rows[1], 0] | held[rows[2], 0] | held[rows[3], 0]) > 0

    return any_held


def _mark(shape, mask, bit, place, support, d, stride, like):
    """Set a bit at the vertices in a particle's support; `like` has its number of directions."""


@specialise(_mark)
def _mark_along(shape, mask, bit, place, support, d, stride, like):
    if len(like) == 0:

        def vertex(shape, mask, bit, place, support, d, stride, like):
            mask[place // RECORD] |= bit

        return vertex

    def line(shape, mask, bit, place, support, d, stride, like):
        buffer, j = support
        for i in range(extent(shape, buffer, d, j)):
            if entry(buffer, d, 0, i, j) >= LEAST_WEIGHT:
                at = place + i * stride[0]
                _mark(shape, mask, bit, at, support, d + 1, stride[1:], like[1:])

    return line


def _mark_cell(mask, bit, place, w, t, stride):
    """Set a bit at the vertices round the place t in a cell, as `spread` in `cornertransfer`."""


@specialise(_mark_cell)
def _mark_cell_along(mask, bit, place, w, t, stride):
    def vertex(mask, bit, place, w, t, stride):
        if w >= LEAST_WEIGHT:
            mask[place // RECORD] |= bit

    def both(mask, bit, place, w, t, stride):
        _mark_cell(mask, bit, place, w * (1.0 - t[0]), t[1:], stride[1:])
        _mark_cell(mask, bit, place + stride[0], w * t[0], t[1:], stride[1:])

    return vertex if len(t) == 0 else both


def _mark_support(shape, mask, bit, place, support, stride, like):
    """Set a bit at the vertices in a particle's support, by whatever it has."""


@specialise(_mark_support)
def _mark_support_of(shape, mask, bit, place, support, stride, like):
    corners, part = 2 ** len(like), 0.5 ** len(like)

    def by_all(shape, mask, bit, place, support, stride, like):
        for c in range(corners):
            t, cell = corner(support.buffer, c, support.j, like)
            _mark_cell(mask, bit, place + cell, part, t, stride)

    if by_corners(shape):
        return by_all
    return lambda shape, mask, bit, place, support, stride, like: _mark(
        shape, mask, bit, place, support, 0, stride, like
    )


@kernel
def mark_constrained_vertices(setting, window, particles, order, mask):
    """Mark the vertices in the supports of constrained particles.

    Parameters
    ----------
    setting, window, particles, order
        See `Setting`, `Window`, `Particles`, `Order`.
    mask : (planes * plane / 8,) int64
        Grows: bit k of a vertex says that constraint k holds it.
    """
    shape, frame, rows_of_all, start = setting.shape, setting.frame, order.rows, order.start
    buffer = stack(SUPPORT_SIZE)
    for layer in range(len(start) - 1):
        plane = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four(rows_of_all, k, start[layer + 1])
            if not any_held(particles, rows):
                continue
            supports(shape, frame, window, particles, rows, plane, buffer, ())
            for j in range(min(LANES, start[layer + 1] - k)):
                p = rows_of_all[k + j]
                number = particles.constraint[p, 0]
                if number > 0:
                    place = first_place(buffer, j) + layer * window.stride[0]
                    bit = 1 << (number - 1)
                    support = Support(buffer, j)
                    _mark_support(shape, mask, bit, place, support, window.stride, frame.origin)


def constrained_velocity(marked, r, v):
    """Velocity of the vertex at `r` when all constraints are applied to `v`.

    Parameters
    ----------
    marked : (constraints, mask) or ()
        The constraints and the vertices that they hold, see
        `mark_constrained_vertices`. Where constraints share a vertex, the later one applies.
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
                    u[0] - dt * a[0] if h[0] else v[0], u[1] - dt * a[1] if h[1] else v[1],
                    u[2] - dt * a[2] if h[2] else v[2],
                )  # fmt: skip
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
        As in `update_momentum`, which has counted gravity's work with the velocity before.
    ledger : Ledger
        `constraint_impulse` grows by the momentum that each constraint gives to the vertices,
        `work` by that momentum times the velocity after the last constraint.
    """
    G, active, owned, plane = field.G, field.active, field.owned, field.window.stride[0]
    marked, relaxation = forcing.marked, forcing.loads.relaxation
    dt, gravity, work, impulse = forcing.dt, forcing.gravity, ledger.work, ledger.constraint_impulse
    constraints, mask = marked
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, RECORD):
            held = mask[r // RECORD]
            if held == 0 or not G[r + MASS] > 0.0:
                continue
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
                        change = given(relaxation, mass, dt, u, b, v, a)
                        work[i] += mass * dt * gravity[d] * (v - u)
                        G[r + VELOCITY + d] = v
                        G[r + ACCELERATION + d] = a
                        G[r + HELD] = SEVERAL
                        impulse[i, k, d] += change
                        work[i] += change * last[d]


def constrain_particles(constraints, particles, batch, u, v, ledger):
    """Velocities of a batch, and those at which it moves, after its constraints.

    Parameters
    ----------
    particles, batch
        See `Particles`, `Batch`.
    u, v : tuple of Vec4
        For each direction, those of four particles.
    ledger : Ledger
        `constraint_impulse` and `work` grow.
    """


def _held(constraints, k, number, m, u, v, ledger, plane):
    """Treat the constraints from number `k` on, those in `constraints`.

    `number` is that of each particle's constraint, from 1; `m` is zero for particles that do not
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


def _hold(one, d, chosen, m, u, v, ledger, place):
    """Treat the directions from `d` on, one vector each of `u` and `v`, of one constraint.

    `place` is the plane and the constraint's number in the ledger.
    """


@specialise(_hold)
def _hold_along(one, d, chosen, m, u, v, ledger, place):
    if len(u) == 0:
        return lambda one, d, chosen, m, u, v, ledger, place: (u, v)

    def hold(one, d, chosen, m, u, v, ledger, place):
        U, V = _hold(one, d + 1, chosen, m, u[1:], v[1:], ledger, place)
        if not one.held[d]:
            return (u[0], *U), (v[0], *V)
        prescribed = one.velocity[d]
        given = where(chosen, m * (prescribed - v[0]), 0.0)
        total = (lane(given, 0) + lane(given, 1)) + (lane(given, 2) + lane(given, 3))
        plane, k = place
        ledger.constraint_impulse[plane, k, d] += total
        ledger.work[plane] += total * prescribed
        return (where(chosen, prescribed, u[0]), *U), (where(chosen, prescribed, v[0]), *V)

    return hold


@specialise(constrain_particles)
def _constrain_particles(constraints, particles, batch, u, v, ledger):
    if len(constraints) == 0:
        return lambda constraints, particles, batch, u, v, ledger: (u, v)

    def constrain_particles(constraints, particles, batch, u, v, ledger):
        column, rows = particles.constraint, batch.rows
        number = pack(
            float(column[rows[0], 0]), float(column[rows[1], 0]),
            float(column[rows[2], 0]), float(column[rows[3], 0]),
        )  # fmt: skip
        if bits(number > 0.0) == 0:
            return u, v
        m = where(pack(0.0, 1.0, 2.0, 3.0) < batch.size, take(particles.m, rows), 0.0)
        return _held(constraints, 0, number, m, u, v, ledger, batch.layer)

    return constrain_particles
