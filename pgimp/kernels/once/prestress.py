"""Initial stress: the state that it sets in particles, and the stress that materials can bear."""

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read, scaled, write
from pgimp.kernels.transfer.first_vertex import deformation
from pgimp.kernels.update.stress import state_of
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.physics.materials.parameters.evaluate import evaluate


@kernel
def remember_stress(setting, particles, rows):
    """Set the state of some particles, undeformed ones, by their materials' ``initial_state``.

    Parameters
    ----------
    setting, particles
        See `KernelScene`, `Particles`.
    rows : (n,) int64
        Their rows; at least one material of the scene has state variables.
    """
    F, tensor = setting.identity, symmetric(setting.identity)
    for p in rows:
        materials = substitute_parameters(setting, particles, p).materials
        number = setting.material_of[particles.body[p]]
        args = (F, determinant(F), read(particles.sigma, p, 0, tensor))
        state = state_of(materials, particles, p, F)
        write(particles.state, p, 0, evaluate("initial_state", materials, number, args, state))


@kernel
def bearable_stress(setting, particles, rows, stresses):
    """Stress of some particles after a unit of time at rest.

    Parameters
    ----------
    setting, particles
        See `KernelScene`, `Particles`.
    rows : (n,) int64
        Their rows.
    stresses : (n, 3, 4 or 6) float64
        Gets the stresses.
    """
    tensor, still = symmetric(setting.identity), scaled(0.0, setting.identity)
    for i in range(len(rows)):
        p = rows[i]
        F = deformation(setting.frame, particles, p)
        materials = substitute_parameters(setting, particles, p).materials
        number = setting.material_of[particles.body[p]]
        args = (F, determinant(F), read(particles.sigma, p, 0, tensor), still, 1.0)
        state = state_of(materials, particles, p, F)
        found = evaluate("stress", materials, number, args, state)
        for k in range(stresses.shape[1]):
            stresses[i, k] = found[k]
