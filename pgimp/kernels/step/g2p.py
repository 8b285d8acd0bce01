"""Grid to particles: positions and velocities (26, 27), deformation (29, 30), volume and stress."""

from pgimp.jit.kernel import is_empty, kernel
from pgimp.jit.vectors.simd import lane, stack, vector
from pgimp.kernels.contact.hold import project_out
from pgimp.kernels.data.arguments import FourParticles
from pgimp.kernels.flows.refill import refill
from pgimp.kernels.loads.body_forces import FORCES, add_force_power, book_shifts
from pgimp.kernels.loads.loads import layer_power
from pgimp.kernels.loads.tractions import Booking
from pgimp.kernels.step.checks import check, limits_of
from pgimp.kernels.step.stress import stress_particles
from pgimp.kernels.transfer.gather_shared import take_from_grid
from pgimp.kernels.transfer.lane_io import LANES, four_rows, put_row
from pgimp.kernels.transfer.mean_dilatation_weights import keep_means
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, supports
from pgimp.kernels.transfer.transpose import SUMS
from pgimp.kernels.update.affine import keep_gradients, when_moved
from pgimp.kernels.update.mean_dilatation import with_means
from pgimp.kernels.update.mean_dilatation_lagrangian import (
    deform,
    keep_mean_lagrangian,
    take_mean_lagrangian,
)
from pgimp.kernels.update.phases import rest_of_strain, way_of, weight_power
from pgimp.kernels.update.speed import grid_speed
from pgimp.kernels.update.stress import margins, materials_of
from pgimp.kernels.update.velocity import update_position, update_velocity


@kernel
def grid_to_particles(
    setting, field, particles, order, layers, forcing, report, ledger
) -> tuple[int, int, int, float, int, int]:
    """Advance particles of a rank by one step, and report on them.

    A particle at fault stays as computed, in its layer; the others go on. One that has left through
    an open face gets the layer `OUTFLOW`.

    Parameters
    ----------
    setting, field, particles, order, forcing
        See `KernelScene`, `Field`, `Particles`, `Order`, `Forcing`; the field holds velocities and
        accelerations.
    layers : (k,) int64
        The layers to advance, ascending, counted from the rank's first one.
    report : Report
        Filled by this.
    ledger : Ledger
        Grows, layer by layer, by the work of loads, constraints and walls on particles.
        `constraint_impulse`, `impulse` and `traction_impulse` grow by the momentum from
        constraints, from walls and from tractions.

    Returns
    -------
    errors, outflow, changed : int
        Number of particles at fault, of particles that left, of particles that left or changed
        layer.
    rate : float
        Largest `pace` over L, if controlled; see `pgimp.kernels.update.speed`.
    clamped : int
        Number of particles whose half-width is clamped.
    held : int
        Number of particles that walls held in.
    """
    shape, frame, window = setting.shape, setting.frame, field.window
    loads, dt, start, work = forcing.loads, forcing.dt, order.start, ledger.work
    counts = (0, 0, 0, 0, 0)
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    limits = limits_of(setting, forcing, inverse)
    acting, half = way_of(forcing)
    fastest = vector(0.0)
    buffer = stack(SUPPORT_SIZE)
    weights = stack(SUPPORT_SIZE)
    sums = stack(SUMS)
    forces = stack(FORCES)
    for layer in layers:
        number = layer + window.lower[0]
        span = (start[layer], start[layer + 1])
        booking = Booking(acting, ledger.traction_impulse, 0, half)
        power = layer_power(loads, setting, field, particles, order.rows, span, number, booking)
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            count = min(LANES, start[layer + 1] - k)
            four = FourParticles(rows, count, k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            keep_means(loads.mean, shape, frame, buffer)
            keep_mean_lagrangian(loads.mean_lagrangian, shape, frame, buffer, weights)
            u, a, grad, codes, hoop = take_from_grid(  # (30)
                (shape, frame), field, loads.mean, four, buffer, sums
            )
            power = add_force_power(loads.force, frame, particles, four, u, forces, power)
            if not is_empty(forcing.phase):
                power = weight_power(forcing.gravity, particles, rows, count, u, power)
            u, v = update_velocity(frame, forcing, particles, four, (u, a, hoop), ledger)  # (27)
            moved_to = update_position(forcing, particles, four, u)  # (26)
            if is_empty(forcing.phase):
                moved = when_moved(loads.affine, dt, grad)
                keep_gradients(loads.affine, particles, rows, moved, codes)
            grad = with_means(  # the cells' rates of dilatation
                loads.mean, frame, particles, rows, buffer, sums, count, grad
            )
            cells = take_mean_lagrangian(
                loads.mean_lagrangian, (shape, frame), field, four, buffer, weights, sums
            )
            m = materials_of(setting.material_of, particles.body, rows)
            left, strained = rest_of_strain(forcing, particles)
            L, F = deform(cells, setting, left, strained, four, m, grad)  # (29)
            x, F, v = refill(
                forcing, setting, field, particles, four, (buffer, sums), (moved_to, F, v), ledger
            )
            own, J, sigma, state, extra = stress_particles(setting, left, particles, rows, m, F, L)
            put_row(particles.x, rows, 0, x)
            put_row(particles.v, rows, 0, v)
            put_row(particles.F, rows, 0, F)
            x, v = project_out(forcing.limits, forcing, particles, four, x, v, ledger)
            if forcing.controlled:
                c = grid_speed(own, forcing.controlled, m, (v, F, J, state), inverse, extra)
                fastest = max(c * inverse, fastest)
            margin = margins(own, m, F, J, sigma, state)
            found = (u, v, x, F, J, state, margin)
            counts = check(limits, field, particles, four, found, report, ledger, counts)
            book_shifts(loads.force, forces, particles, four, moved_to, ledger)
        work[layer] += acting * power
    failed, outflow, moved, clamped, held = counts
    rate = max(max(lane(fastest, 0), lane(fastest, 1)), max(lane(fastest, 2), lane(fastest, 3)))
    return failed, outflow, moved, rate, clamped, held
