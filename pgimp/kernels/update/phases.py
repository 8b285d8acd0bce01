"""Strain of a step in two parts, for orders of phases; see `pgimp.solver.phases.orders`."""

from typing import Any, NamedTuple

from pgimp.jit.algebra import inverse, multiply, one_plus
from pgimp.jit.kernel import inlined, is_empty


class Strain(NamedTuple):
    """What stands in for `Forcing` in a part of a step's strain."""

    dt: float  #: Its time.
    loads: Any  #: Loads: See `pgimp.kernels.loads.loads`.


@inlined
def rest_of_strain(forcing, particles):
    """What is left of a step's strain, as forcing, and the particles: all, unless it has phases."""
    if is_empty(forcing.phase):
        return forcing, particles
    return Strain(forcing.phase.dt, forcing.loads), forcing.phase.particles


@inlined
def from_before(dt, L):
    """Velocity gradients by positions a time dt before those of the gradients `L`.

    With the same velocities, 1 + dt L turns into (1 - dt L)^-1: a rotation goes on as a rotation.
    """
    return multiply(L, inverse(one_plus(-dt, L)))
