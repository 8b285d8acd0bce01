"""Strain of particles by the vertices' velocities, before forces: the first part of a step's.

It is the strain of the move that has just been, by gradients at the positions after it.

For other orders of phases than `stress: last`, see `pgimp.solver.phases.orders`.
"""

from pgimp.jit.kernel import kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.arguments import FourParticles
from pgimp.kernels.loads.body_forces import FORCES, add_force_power
from pgimp.kernels.loads.loads import layer_power
from pgimp.kernels.loads.tractions import Booking
from pgimp.kernels.step.stress import stress_particles
from pgimp.kernels.transfer.gather_shared import take_from_grid
from pgimp.kernels.transfer.lane_io import LANES, four_rows, put_row
from pgimp.kernels.transfer.mean_dilatation_weights import keep_means
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, supports
from pgimp.kernels.transfer.transpose import SUMS
from pgimp.kernels.update.mean_dilatation import with_means
from pgimp.kernels.update.mean_dilatation_lagrangian import deform
from pgimp.kernels.update.phases import from_before, weight_power
from pgimp.kernels.update.stress import materials_of


@kernel
def strain_particles(setting, field, particles, order, strain, F_after, ledger):
    """Strain particles by velocities at the vertices; nothing moves, and supports stay.

    Parameters
    ----------
    setting, field, particles, order
        See `KernelScene`, `Field`, `Particles`, `Order`.
    strain : Strain
        Its time, in which loads act, too.
    F_after : (capacity, D*D) float64
        Set to the deformation gradients. F stays, on which supports depend.
    ledger : Ledger
        `work` and `traction_impulse` grow as in `grid_to_particles`.
    """
    shape, frame, window, loads = setting.shape, setting.frame, field.window, strain.loads
    buffer, sums, forces = stack(SUPPORT_SIZE), stack(SUMS), stack(FORCES)
    start = order.start
    for layer in range(len(start) - 1):
        number = layer + window.lower[0]
        span = (start[layer], start[layer + 1])
        booking = Booking(strain.dt, ledger.traction_impulse, 0, 0.0)
        power = layer_power(loads, setting, field, particles, order.rows, span, number, booking)
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            count = min(LANES, start[layer + 1] - k)
            four = FourParticles(rows, count, k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            keep_means(loads.mean, shape, frame, buffer)
            u, _, grad, _, _ = take_from_grid((shape, frame), field, loads.mean, four, buffer, sums)
            power = add_force_power(loads.force, frame, particles, four, u, forces, power)
            power = weight_power(strain.gravity, particles, rows, count, u, power)
            grad = with_means(loads.mean, frame, particles, rows, buffer, sums, count, grad)
            grad = from_before(strain.dt, grad)
            m = materials_of(setting.material_of, particles.body, rows)
            L, F = deform((), setting, strain, particles, four, m, grad)
            stress_particles(setting, strain, particles, rows, m, F, L)
            put_row(F_after, rows, 0, F)
        ledger.work[layer] += strain.dt * power
