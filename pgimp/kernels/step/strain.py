"""Strain of particles by the vertices' velocities, before forces: the first part of a step's.

It is the strain of the move that has just been, by gradients at the positions after it.

For other orders of phases than `stress: last`, see `pgimp.solver.phases.orders`.
"""

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.arguments import FourParticles
from pgimp.kernels.transfer.gather_shared import take_from_grid
from pgimp.kernels.transfer.lane_io import LANES, four_rows, put, put_row, take
from pgimp.kernels.transfer.mean_dilatation_weights import keep_means
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, supports
from pgimp.kernels.transfer.transpose import SUMS
from pgimp.kernels.update.mean_dilatation import with_means
from pgimp.kernels.update.mean_dilatation_lagrangian import deform
from pgimp.kernels.update.phases import from_before
from pgimp.kernels.update.stress import keep_state, materials_of, update_stress
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.kernels.update.viscosity import update_viscous_pressure


@kernel
def strain_particles(setting, field, particles, order, strain, F_after):
    """Strain particles by velocities at the vertices; nothing moves, and supports stay.

    Parameters
    ----------
    setting, field, particles, order
        See `KernelScene`, `Field`, `Particles`, `Order`.
    strain : Strain
        Its time.
    F_after : (capacity, D*D) float64
        Set to the deformation gradients. F stays, on which supports depend.
    """
    shape, frame, window, loads = setting.shape, setting.frame, field.window, strain.loads
    buffer, sums = stack(SUPPORT_SIZE), stack(SUMS)
    start = order.start
    for layer in range(len(start) - 1):
        number = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            count = min(LANES, start[layer + 1] - k)
            four = FourParticles(rows, count, k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            keep_means(loads.mean, shape, frame, buffer)
            grad = take_from_grid((shape, frame), field, loads.mean, four, buffer, sums)[2]
            grad = with_means(loads.mean, frame, particles, rows, buffer, sums, count, grad)
            grad = from_before(strain.dt, grad)
            m = materials_of(setting.material_of, particles.body, rows)
            L, F = deform((), setting, strain, particles, four, m, grad)
            J = determinant(F)
            own = substitute_parameters(setting, particles, rows)
            sigma, state = update_stress(own, strain, particles, rows, m, F, J, L)
            put_row(F_after, rows, 0, F)
            put_row(particles.sigma, rows, 0, sigma)
            keep_state(particles, rows, state)
            if setting.tracked:
                put(particles.V, rows, J * take(particles.V0, rows))
            update_viscous_pressure(loads.viscosity, own, m, particles, rows, F, J, L)
