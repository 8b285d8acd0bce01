"""Deformation gradients and volumes (29, 30)."""

from pgimp.jit.algebra import inverse, multiply, one_plus
from pgimp.jit.kernel import specialise
from pgimp.jit.tuples import plus_scaled
from pgimp.kernels.batch import deformations
from pgimp.kernels.place import is_initial


def velocity_gradients(frame, particles, batch, D):
    """Velocity gradients L of four particles at the step's beginning, by present places.

    `D` is what the grid gives: L itself or, in the initial configuration, the gradient of the
    velocity by initial places, which is the rate of F; then L = D F^-1. Either way F after the step
    is (1 + dt L) F, to rounding.
    """


@specialise(velocity_gradients)
def _velocity_gradients(frame, particles, batch, D):
    if not is_initial(frame):
        return lambda frame, particles, batch, D: D
    return lambda frame, particles, batch, D: multiply(
        D, inverse(deformations(frame, particles, batch.rows))
    )


def update_deformation(setting, forcing, particles, batch, D):
    """Deformation gradients F of four particles after a step (29); `D`: `velocity_gradients`."""


@specialise(update_deformation)
def _update_deformation(setting, forcing, particles, batch, L):
    frame = setting.types[setting.fields.index("frame")]
    if is_initial(frame):
        return lambda setting, forcing, particles, batch, D: plus_scaled(
            forcing.dt, D, deformations(setting.frame, particles, batch.rows)
        )
    return lambda setting, forcing, particles, batch, L: multiply(
        one_plus(forcing.dt, L), deformations(setting.frame, particles, batch.rows)
    )
