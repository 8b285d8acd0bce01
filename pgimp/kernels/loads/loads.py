"""Additions to stress and gravity: viscosity, tractions, a body force, relaxation.

Each is `()` in a scene without it; the compiler then omits it at no cost.
"""

from typing import NamedTuple, Self

import numpy as np

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.kernels.loads.surfaces import scatter_surfaces, surface_power
from pgimp.kernels.loads.tractions import Booking, scatter_tractions, traction_power
from pgimp.kernels.loads.wall_gap import Sides
from pgimp.physics.exact.base import BodyForce
from pgimp.physics.loads.surfaces import SurfaceLoad
from pgimp.physics.loads.tractions import Traction


class Loads(NamedTuple):
    """The loads of one step."""

    #: Viscosity or (): Artificial viscosity of shocks (45). See `pgimp.kernels.update.viscosity`.
    viscosity: tuple = ()
    #: Tractions on faces of bodies (18). See `pgimp.kernels.loads.tractions`.
    tractions: tuple[Traction, ...] = ()
    #: BodyForce or (): Body force that varies in space. See `pgimp.physics.exact.base`.
    force: BodyForce | tuple[()] = ()
    #: float or (): Rate at which particles relax to the grid's velocity. See `relaxed`.
    relaxation: float | tuple[()] = ()
    #: float or (): A number where particles carry their velocity gradient. See
    #: `pgimp.kernels.update.affine`.
    affine: float | tuple[()] = ()
    #: For each direction the walls across it that need clearances. () without any.
    approached: tuple[Sides, ...] = ()
    #: float, (bodies,) float64 or (): A number where cells have one dilatation each. An array
    #: where some bodies have none, as liquids under gravity: 1 for these, 0 for others. See
    #: `pgimp.kernels.update.mean_dilatation`.
    mean: float | np.ndarray | tuple[()] = ()
    #: float or (): A number where cells have one dilatation each, of bodies in the initial
    #: configuration. See `pgimp.kernels.update.mean_dilatation_lagrangian`.
    mean_lagrangian: float | tuple[()] = ()
    #: (bodies,) bool or (): Bodies that come to rest on faces that hold every component. See
    #: `pgimp.kernels.grid.resting`.
    rest: np.ndarray | tuple[()] = ()
    #: Loads on parts of surfaces. See `pgimp.kernels.loads.surfaces`.
    surfaces: tuple[SurfaceLoad, ...] = ()

    def summed(self) -> Self:
        """The loads that sums of particles need, to compile kernels once for all others."""
        return self._replace(relaxation=(), rest=())


@inlined
def relaxed_part(rate, dt):
    """Grid's part of a particle's velocity after a step; 0 without relaxation."""
    if is_empty(rate):
        return 0.0
    return min(rate * dt, 1.0)


@inlined
def relaxed(rate, dt, v, u):
    """Velocities v of particles, after (27), relaxed towards the grid's velocities u there.

    By (27) alone a particle keeps for ever the part of its velocity that the grid cannot resolve.
    This relaxes it, and some of the resolved part, at a rate that does not depend on the step.
    """
    if is_empty(rate):
        return v
    part = relaxed_part(rate, dt)
    return plus_scaled(part, u, scaled(1.0 - part, v))


@inlined
def given(rate, m, dt, v, a, V, A):
    """Momentum that particles gain where vertices of mass m have (V, A) instead of (v, a).

    By (27) they get the acceleration; the relaxed part gets the velocity.
    """
    if is_empty(rate):
        return m * dt * (A - a)
    part = relaxed_part(rate, dt)
    return m * ((1.0 - part) * dt * (A - a) + part * (V - v))


@inlined
def scatter_loads(loads, setting, field, particles, rows, span, layer):
    """Add the loads of a layer's particles, but for stress and body force, to its planes."""
    if len(loads.tractions) > 0:
        scatter_tractions(loads.tractions, setting, field, particles, rows, span, layer)
    if len(loads.surfaces) > 0:
        scatter_surfaces(loads.surfaces, setting, field, particles, rows, span, layer)


@inlined
def layer_power(loads, setting, field, particles, rows, span, layer, booking):
    """Power of the loads on a layer's particles, without the body force; see `Booking`."""
    power, faces = 0.0, len(loads.tractions)
    if faces > 0:
        power += traction_power(
            loads.tractions, setting, field, particles, rows, span, layer, booking
        )
    if len(loads.surfaces) > 0:
        own = Booking(booking.dt, booking.impulse, faces, booking.half)
        power += surface_power(loads.surfaces, setting, field, particles, rows, span, layer, own)
    return power
