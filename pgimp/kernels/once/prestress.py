"""Initial stress: the state that it sets in particles, and the stress that materials can bear."""

from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import scaled, write
from pgimp.kernels.transfer.first_vertex import deformation
from pgimp.kernels.update.stress import of_particle


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
    for p in rows:
        state = of_particle("initial_state", setting, particles, p, setting.identity, ())
        write(particles.state, p, 0, state)


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
    still = scaled(0.0, setting.identity)
    for i in range(len(rows)):
        p = rows[i]
        F = deformation(setting.frame, particles, p)
        found = of_particle("stress", setting, particles, p, F, (still, 1.0))
        for k in range(stresses.shape[1]):
            stresses[i, k] = found[k]
