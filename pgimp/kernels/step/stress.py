"""Stress of four particles after a strain, with all that goes with it, kept."""

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inlined
from pgimp.kernels.transfer.lane_io import put, put_row, take
from pgimp.kernels.update.stress import keep_state, update_stress
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.kernels.update.viscosity import update_viscous_pressure


@inlined
def stress_particles(setting, forcing, particles, rows, m, F, L):
    """Stress of four particles at `F`, kept with their state, volume and viscous pressure (45).

    Parameters
    ----------
    setting, forcing, particles
        See `KernelScene`, `Forcing` or `Strain`, `Particles`.
    rows, m : tuple of 4 int
        Their rows and the numbers of their materials.
    F, L : tuple of Vec4
        Deformation gradients after the strain, velocity gradients; matrices.

    Returns
    -------
    own, J, sigma, state, extra
        The setting with their parameters, det F, stress, state, and what viscosity adds to the
        speed of waves.
    """
    J = determinant(F)
    own = substitute_parameters(setting, particles, rows)
    sigma, state = update_stress(own, forcing, particles, rows, m, F, J, L)
    put_row(particles.sigma, rows, 0, sigma)
    keep_state(particles, rows, state)
    if setting.tracked:
        put(particles.V, rows, J * take(particles.V0, rows))
    viscosity = forcing.loads.viscosity
    extra = update_viscous_pressure(viscosity, own, m, particles, rows, F, J, L)
    return own, J, sigma, state, extra
