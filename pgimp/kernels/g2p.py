"""Grid to particles: positions and velocities (26, 27), deformation (29, 30), volume and stress."""

from math import isfinite, sqrt

from pgimp.jit.algebra import determinant, multiply, one_plus, symmetric
from pgimp.jit.kernel import kernel, specialise
from pgimp.jit.lanes import of_lane
from pgimp.jit.simd import bits, lane, stack, vector
from pgimp.jit.tuples import plus_scaled, read
from pgimp.kernels.affine import keep_gradients
from pgimp.kernels.batch import (
    LANES,
    ROOM,
    deformations,
    first_place,
    four,
    put,
    put_row,
    supports,
    take,
    take_row,
)
from pgimp.kernels.gathered import (
    SUMS,
    collected,
    components,
    gradients,
    keep_sums,
    repeat_sums,
)
from pgimp.kernels.grips import gripped
from pgimp.kernels.loads import force_power, layer_power, relaxed
from pgimp.kernels.place import first_vertex
from pgimp.kernels.transfer import gather
from pgimp.kernels.viscosity import stiffened, thicken
from pgimp.kernels.walls import hold_inside
from pgimp.physics.materials.base import evaluate_four
from pgimp.physics.shapes.base import size
from pgimp.physics.shapes.stretch import LARGEST

#: What is wrong with a particle at fault.
NOT_FINITE, INVERTED, TOO_FAST, OUTSIDE = 1, 2, 3, 4

#: What `_outside` says of a particle that has left through a face that lets it go.
_LEAVES = -1

#: The layer of such a particle.
GONE = -1


def within(bounds, x):
    """Whether each coordinate lies within its bounds; false for NaN, never branches."""


@specialise(within)
def _within(bounds, x):
    if len(x) == 1:
        return lambda bounds, x: (x[0] >= bounds[0][0]) & (x[0] <= bounds[0][1])
    return lambda bounds, x: (
        (x[0] >= bounds[0][0]) & (x[0] <= bounds[0][1]) & within(bounds[1:], x[1:])
    )


def squared(v):
    """Square of the length of a tuple."""


@specialise(squared)
def _squared(v):
    if len(v) == 1:
        return lambda v: v[0] * v[0]
    return lambda v: v[0] * v[0] + squared(v[1:])


@kernel
def materials_of(material_of, body, rows):
    """Materials of four particles."""
    return (
        material_of[body[rows[0]]], material_of[body[rows[1]]],
        material_of[body[rows[2]]], material_of[body[rows[3]]],
    )  # fmt: skip


@kernel
def _unsound(frame, x, v, u, J, dt):
    """Name the fault of a particle that failed the combined check, wherever it is; 0 for none."""
    for d in range(len(x)):
        if not (isfinite(x[d]) and isfinite(v[d])):
            return NOT_FINITE
    if not isfinite(J):
        return NOT_FINITE
    if not J > 0.0:
        return INVERTED
    for d in range(len(x)):
        if not abs(u[d]) * dt * frame.inverse[d] <= 1.0:
            return TOO_FAST
    return 0


@kernel
def _outside(frame, exits, x):
    """Tell whether a particle has left the domain, and if it may."""
    fault = 0
    for d in range(len(x)):
        xi = (x[d] - frame.origin[d]) * frame.inverse[d]
        if not (xi >= 0.0 and xi <= frame.cells[d]):
            if exits >> (2 * d + (xi > 0.0)) & 1 == 0:
                return OUTSIDE
            fault = _LEAVES
    return fault


@kernel
def grid_to_particles(setting, field, particles, order, layers, forcing, report, ledger):
    """Advance particles of a rank by one step, and notice what happened to them.

    A particle at fault is left as it was computed, in its layer; the others go on. One that has
    left through faces that let it go gets the layer `GONE`.

    Parameters
    ----------
    setting, field, particles, order, forcing
        See `Setting`, `Field`, `Particles`, `Order`, `Forcing`; the field holds velocities and
        accelerations.
    layers : (k,) int64
        The layers to advance, ascending, counted from the rank's first one.
    report : Report
        Filled with what happened.
    ledger : Ledger
        Grows, layer by layer, by the work of loads, constraints and walls on particles, and by the
        momentum that constraints (`grip_impulse`) and walls (`impulse`) give to them.

    Returns
    -------
    faults, leavers, movers : int
        Number of particles at fault, of those that left, of those that left or changed their layer.
    rate : float
        Largest (c_p + |v_p|)/L, if controlled.
    clamped : int
        Number of particles whose half-width is clamped.
    held : int
        Number of particles that walls held in.
    """
    shape, frame, window, G = setting.shape, setting.frame, field.window, field.G
    materials, material_of, exits = setting.materials, setting.material_of, setting.exits
    loads, grips, dt, controlled = forcing.loads, forcing.grips, forcing.dt, forcing.controlled
    reach, movers, faults, bounds = report.reach, report.movers, report.faults, field.bounds
    impulse, wall_impulse, work = ledger.grip_impulse, ledger.impulse, ledger.work
    tracked, walls, start = setting.tracked, forcing.walls, order.start
    failed = 0
    leavers = 0
    found = 0
    clamped = 0
    held = 0
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    limit = (dt * inverse) ** 2
    fastest = vector(0.0)
    room = stack(ROOM)
    sums = stack(SUMS)
    for layer in layers:
        number = layer + window.lower[0]
        begin = layer * window.stride[0]
        span = (start[layer], start[layer + 1])
        power = layer_power(loads, setting, field, particles, order.rows, span, number)
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four(order.rows, k, start[layer + 1])
            count = min(LANES, start[layer + 1] - k)
            supports(shape, frame, window, particles, rows, number, room, ())
            for j in range(count):
                place = begin + first_place(room, j)
                U, A, D = gather(shape, G, room, j, place, window.stride, frame.origin)
                keep_sums(sums, j, U, A, D)
                w = components(frame.origin, U)
                power += force_power(loads.force, frame, particles, rows[j], w)
            repeat_sums(sums, count, frame.origin)
            u = collected(sums, 0, frame.origin)
            a = collected(sums, 1, frame.origin)
            L = gradients(sums, 2, frame.origin)  # (30)
            v = plus_scaled(dt, a, take_row(particles.v, rows, 0, u))  # (27)
            v = relaxed(loads.relaxation, dt, v, u)
            u, v = gripped(grips, particles, rows, count, u, v, impulse, work, layer)
            x = plus_scaled(dt, u, take_row(particles.x, rows, 0, u))  # (26)
            keep_gradients(loads.affine, particles, rows, L, sums)
            F = multiply(one_plus(dt, L), deformations(frame, particles, rows))
            J = determinant(F)
            m = materials_of(material_of, particles.body, rows)
            sigma = take_row(particles.sigma, rows, 0, symmetric(L))
            sigma = evaluate_four("stress", materials, m, (F, J, sigma, L, dt), sigma)
            put_row(particles.x, rows, 0, x)
            put_row(particles.v, rows, 0, v)
            put_row(particles.F, rows, 0, F)
            put_row(particles.sigma, rows, 0, sigma)
            if tracked:
                put(particles.V, rows, J * take(particles.V0, rows))
            slow = thicken(loads.viscosity, materials, m, particles, rows, F, J, L)  # (45)
            if controlled:
                c = evaluate_four("speed", materials, m, (F, J), J)
                c = stiffened(loads.viscosity, c, slow)
                fastest = max((c + sqrt(squared(v))) * inverse, fastest)
            # One branch for all that rarely happens, NaN included; its speed limit is sharper.
            half, most = size(shape, frame.cell, F)
            now = first_vertex(frame, 0, half[0], x[0])
            usual = bits(
                within(bounds, x)
                & (J > 0.0)
                & ((squared(u) + squared(v)) * limit <= 1.0)
                & (now == number)
                & (vector(most) <= LARGEST)
            )
            if usual == 15:
                continue
            for j in range(count):
                if usual >> j & 1:
                    continue
                p = rows[j]
                clamped += lane(vector(most), j) > LARGEST
                xj = of_lane(x, j)
                layer_now = int(lane(now, j))
                fault = _unsound(frame, xj, of_lane(v, j), of_lane(u, j), lane(J, j), dt)
                if fault == 0:
                    fault = _outside(frame, exits, xj)
                if fault == OUTSIDE and hold_inside(
                    walls, frame, grips, particles, p, wall_impulse[layer],
                    work[layer : layer + 1],
                ):  # fmt: skip
                    held += 1
                    xj = read(particles.x, p, 0, frame.origin)
                    layer_now = int(first_vertex(frame, 0, lane(vector(half[0]), j), xj[0]))
                    fault = _outside(frame, exits, xj)
                if fault == _LEAVES:
                    particles.layer[p] = GONE
                    movers[found] = k + j
                    found += 1
                    leavers += 1
                    continue
                if fault == 0 and abs(layer_now - number) > 1:
                    fault = TOO_FAST  # a cell, but for rounding: past a slab of one layer
                if fault != 0:
                    if failed < len(faults):
                        faults[failed, 0] = p
                        faults[failed, 1] = fault
                    failed += 1
                    continue
                for d in range(1, len(xj)):
                    i = first_vertex(frame, d, lane(vector(half[d]), j), xj[d])
                    reach[0, d - 1] = min(reach[0, d - 1], i)
                    reach[1, d - 1] = max(reach[1, d - 1], i)
                if layer_now != number:
                    particles.layer[p] = layer_now
                    movers[found] = k + j
                    found += 1
        work[layer] += dt * power
    rate = max(max(lane(fastest, 0), lane(fastest, 1)), max(lane(fastest, 2), lane(fastest, 3)))
    return failed, leavers, found, rate, clamped, held
