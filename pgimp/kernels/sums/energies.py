"""Strain energy of single particles, for output that names it."""

from typing import Any

import numpy as np

from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.update.stress import of_particle


@kernel
def particle_energies(setting, particles, rows, found):
    """Set the strain energy per initial volume of the particles in `rows`.

    Parameters
    ----------
    setting, particles
        See `KernelScene`, `Particles`.
    rows : (n,) int64
        Their rows.
    found : (n,) float64
        Set.
    """
    like = setting.identity
    for n in range(len(rows)):
        p = rows[n]
        F = read(particles.F, p, 0, like)
        found[n] = of_particle("energy", setting, particles, p, F, ())


def strain_energies(setting: KernelScene, particles: Particles, rows: Any) -> np.ndarray:
    """Return the strain energy per initial volume of the particles in `rows`, (n,)."""
    found = np.zeros(len(rows))
    particle_energies(setting.without_shape(), particles, np.asarray(rows, np.int64), found)
    return found
