"""Deformation gradients and volumes (29, 30)."""

from pgimp.jit.algebra import multiply, one_plus
from pgimp.jit.kernel import specialise
from pgimp.kernels.batch import deformations


def update_deformation(setting, forcing, particles, batch, L):
    """Deformation gradients F of four particles after a step, from velocity gradients L (29)."""


@specialise(update_deformation)
def _update_deformation(setting, forcing, particles, batch, L):
    return lambda setting, forcing, particles, batch, L: multiply(
        one_plus(forcing.dt, L), deformations(setting.frame, particles, batch.rows)
    )
