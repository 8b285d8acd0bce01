"""Grid to particles: positions and velocities (26, 27), deformation (29, 30), volume and stress."""

from math import sqrt

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.jit.simd import bits, lane, stack, vector
from pgimp.jit.tuples import squared
from pgimp.kernels.affine import keep_gradients
from pgimp.kernels.batch import LANES, SUPPORT_SIZE, first_place, four, put, put_row, supports, take
from pgimp.kernels.concepts import Batch
from pgimp.kernels.fields import field_of
from pgimp.kernels.gathered import (
    SUMS,
    collected,
    components,
    gradients,
    keep_sums,
    repeat_sums,
)
from pgimp.kernels.loads import force_power, layer_power
from pgimp.kernels.mean import keep_means, keep_rates, with_means
from pgimp.kernels.place import first_vertex
from pgimp.kernels.transfer import gather
from pgimp.kernels.updates.checks import and_finite, and_positive, examine, within
from pgimp.kernels.updates.deformation import update_deformation
from pgimp.kernels.updates.stress import (
    diffusion_speed,
    keep_state,
    margins,
    update_stress,
    wave_speed,
)
from pgimp.kernels.updates.velocity import update_position, update_velocity
from pgimp.kernels.viscosity import effective_wave_speed, update_viscous_pressure
from pgimp.physics.shapes.base import size
from pgimp.physics.shapes.stretch import LARGEST


@kernel
def materials_of(material_of, body, rows):
    """Materials of four particles."""
    return (
        material_of[body[rows[0]]], material_of[body[rows[1]]],
        material_of[body[rows[2]]], material_of[body[rows[3]]],
    )  # fmt: skip


@kernel
def grid_to_particles(setting, field, particles, order, layers, forcing, report, ledger):
    """Advance particles of a rank by one step, and notice what happened to them.

    A particle at fault is left as it was computed, in its layer; the others go on. One that has
    left through faces that let it go gets the layer `OUTFLOW`.

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
        momentum that constraints (`constraint_impulse`) and walls (`impulse`) give to them.

    Returns
    -------
    faults, outflow, changed : int
        Number of particles at fault, of those that left, of those that left or changed their layer.
    rate : float
        Largest (c_p + |v_p|)/L, if controlled.
    clamped : int
        Number of particles whose half-width is clamped.
    held : int
        Number of particles that walls held in.
    """
    shape, frame, window, G = setting.shape, setting.frame, field.window, field.G
    loads, dt, start, work = forcing.loads, forcing.dt, order.start, ledger.work
    counts = (0, 0, 0, 0, 0)
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    limit = (dt * inverse) ** 2
    fastest = vector(0.0)
    buffer = stack(SUPPORT_SIZE)
    sums = stack(SUMS)
    for layer in layers:
        number = layer + window.lower[0]
        begin = layer * window.stride[0]
        span = (start[layer], start[layer + 1])
        power = layer_power(loads, setting, field, particles, order.rows, span, number)
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four(order.rows, k, start[layer + 1])
            count = min(LANES, start[layer + 1] - k)
            batch = Batch(rows, count, k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            keep_means(loads.mean, shape, frame, buffer)
            for j in range(count):
                p = order.rows[k + j]
                place = begin + first_place(buffer, j) + field_of(window, particles, p)
                U, A, D, M = gather(
                    shape, G, buffer, j, place, window.stride, frame.origin, loads.mean
                )
                keep_sums(sums, j, U, A, D)
                keep_rates(M, buffer, j)
                w = components(frame.origin, U)
                power += force_power(loads.force, frame, particles, p, w)
            repeat_sums(sums, count, frame.origin)
            u = collected(sums, 0, frame.origin)
            a = collected(sums, 1, frame.origin)
            L = gradients(sums, 2, frame.origin)  # (30)
            u, v = update_velocity(forcing, particles, batch, u, a, ledger)  # (27)
            x = update_position(forcing, particles, batch, u)  # (26)
            keep_gradients(loads.affine, particles, rows, L, sums)
            L = with_means(  # the cells' rates of dilatation
                loads.mean, frame, particles, rows, buffer, sums, count, L
            )
            m = materials_of(setting.material_of, particles.body, rows)
            F = update_deformation(setting, forcing, particles, batch, m, L)  # (29)
            J = determinant(F)
            sigma, state = update_stress(setting, forcing, particles, rows, m, F, J, L)
            put_row(particles.x, rows, 0, x)
            put_row(particles.v, rows, 0, v)
            put_row(particles.F, rows, 0, F)
            put_row(particles.sigma, rows, 0, sigma)
            keep_state(particles, rows, state)
            if setting.tracked:
                put(particles.V, rows, J * take(particles.V0, rows))
            extra = update_viscous_pressure(  # (45)
                loads.viscosity, setting, m, particles, rows, F, J, L
            )
            if forcing.controlled:
                c = wave_speed(setting, m, F, J, state)
                extra = diffusion_speed(setting, m, F, J, state, inverse, extra)
                c = effective_wave_speed(c, extra)
                fastest = max((c + sqrt(squared(v))) * inverse, fastest)
            # One branch for all that rarely happens, NaN included; its speed limit is sharper.
            half, most = size(shape, frame.cell, F)
            now = first_vertex(frame, 0, half[0], x[0])
            margin = margins(setting, m, F, J, sigma, state)
            sound = and_finite(within(field.bounds, x) & (J > 0.0), state)
            sound = and_positive(sound, margin)
            slower = (squared(u) + squared(v)) * limit <= 1.0
            usual = bits(sound & slower & (now == number) & (vector(most) <= LARGEST))
            if usual != 15:
                counts = examine(
                    setting, forcing, particles, batch, usual,
                    (u, v, x, J, state, margin, half, now, most), report, ledger, counts,
                )  # fmt: skip
        work[layer] += dt * power
    failed, outflow, moved, clamped, held = counts
    rate = max(max(lane(fastest, 0), lane(fastest, 1)), max(lane(fastest, 2), lane(fastest, 3)))
    return failed, outflow, moved, rate, clamped, held
