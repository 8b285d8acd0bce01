"""What particles remember of the stress that they begin with."""

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read, write
from pgimp.kernels.own import with_own
from pgimp.kernels.updates.stress import state_of
from pgimp.physics.materials.evaluate import evaluate


@kernel
def remember_stress(setting, particles, rows):
    """Set the state of some particles, undeformed ones, by their materials' ``initial_state``.

    Parameters
    ----------
    setting, particles
        See `Setting`, `Particles`.
    rows : (n,) int64
        Their rows; at least one material of the scene has state variables.
    """
    F, tensor = setting.identity, symmetric(setting.identity)
    for p in rows:
        materials = with_own(setting, particles, p).materials
        number = setting.material_of[particles.body[p]]
        args = (F, determinant(F), read(particles.sigma, p, 0, tensor))
        state = state_of(materials, particles, p, F)
        write(particles.state, p, 0, evaluate("initial_state", materials, number, args, state))
