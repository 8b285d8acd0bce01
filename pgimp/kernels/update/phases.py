"""Strain of a step in two parts, for orders of phases; see `pgimp.solver.phases.orders`."""

from typing import Any, NamedTuple

from pgimp.jit.algebra import inverse, multiply, one_plus
from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.vectors.lanes import of_lane


class Strain(NamedTuple):
    """What stands in for `Forcing` in a part of a step's strain."""

    dt: float  #: Its time.
    loads: Any  #: Loads: See `pgimp.kernels.loads.loads`.
    gravity: tuple[float, float, float]  #: See `Forcing`.


@inlined
def rest_of_strain(forcing, particles):
    """What is left of a step's strain, as forcing, and the particles: all, unless it has phases."""
    if is_empty(forcing.phase):
        return forcing, particles
    return Strain(forcing.phase.dt, forcing.loads, forcing.gravity), forcing.phase.particles


@inlined
def way_of(forcing):
    """Time for which loads act by the velocity of a move, and half of it for `half_step`.

    In phases that is the rest of the step: the part before has had its own velocity. The mean is
    taken already then, so that the half is 0.
    """
    if is_empty(forcing.phase):
        return forcing.dt, 0.5 * forcing.dt
    return forcing.phase.dt, 0.0


@inlined
def weight_power(gravity, particles, rows, count, u, power):
    """Power so far plus that of gravity on the first `count` of four particles that move at `u`."""
    if gravity[0] == 0.0 and gravity[1] == 0.0 and gravity[2] == 0.0:
        return power
    for j in range(count):
        w, rate = of_lane(u, j), 0.0
        for d in range(len(w)):
            rate += gravity[d] * w[d]
        power += particles.m[rows[j]] * rate
    return power


@inlined
def from_before(dt, L):
    """Velocity gradients by positions a time dt before those of the gradients `L`.

    With the same velocities, 1 + dt L turns into (1 - dt L)^-1: a rotation goes on as a rotation.
    """
    return multiply(L, inverse(one_plus(-dt, L)))
