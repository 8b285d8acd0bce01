"""Additions to stress and gravity: viscosity, tractions, a body force, relaxation.

Each is `()` in a scene without it; the compiler then omits it at no cost.
"""

from typing import NamedTuple, Self

import numpy as np

from pgimp.jit.kernel import specialise
from pgimp.jit.tuples import plus_scaled, read, scaled
from pgimp.jit.vectors.lanes import of_lane
from pgimp.jit.vectors.simd import pack
from pgimp.kernels.grid.wall_gap import Sides, divergence
from pgimp.kernels.loads.surfaces import scatter_surfaces, surface_power
from pgimp.kernels.loads.tractions import scatter_tractions, traction_power
from pgimp.physics.exact.base import BodyForce, body_force
from pgimp.physics.functions.call import call
from pgimp.physics.loads.bodyforce import acceleration
from pgimp.physics.loads.surfaces import SurfaceLoad
from pgimp.physics.loads.tractions import Traction


class Loads(NamedTuple):
    """The loads of one step.

    Attributes
    ----------
    viscosity : Viscosity or ()
        See `pgimp.kernels.update.viscosity`.
    tractions : tuple of Traction
        See `pgimp.kernels.loads.tractions`.
    force : BodyForce or ()
        See `pgimp.physics.exact.base`.
    relaxation : float or ()
        Rate at which particles relax to the grid's velocity, see `relaxed`.
    affine : float or ()
        A number where particles carry their velocity gradient, see `pgimp.kernels.update.affine`.
    approached : tuple of Sides
        For each direction the walls across it that need clearances; () without any.
    mean : float, (bodies,) float64 or ()
        A number where cells have one dilatation each, see `pgimp.kernels.update.mean_dilatation`.
        In scenes with liquids under gravity an array, 1 for liquids and 0 for other bodies.
    mean_lagrangian : float or ()
        Likewise for bodies in the initial configuration, see
        `pgimp.kernels.update.mean_dilatation_lagrangian`.
    rest : (bodies,) bool or ()
        Bodies that come to rest on faces that hold every component: see
        `pgimp.kernels.grid.resting`.
    surfaces : tuple of SurfaceLoad
        See `pgimp.kernels.loads.surfaces`.
    """

    viscosity: tuple = ()
    tractions: tuple[Traction, ...] = ()
    force: BodyForce | tuple[()] = ()
    relaxation: float | tuple[()] = ()
    affine: float | tuple[()] = ()
    approached: tuple[Sides, ...] = ()
    mean: float | np.ndarray | tuple[()] = ()
    mean_lagrangian: float | np.ndarray | tuple[()] = ()
    rest: np.ndarray | tuple[()] = ()
    surfaces: tuple[SurfaceLoad, ...] = ()

    def summed(self) -> Self:
        """The loads that sums of particles need, to compile kernels once for all others."""
        return self._replace(relaxation=(), rest=())


def _has_surfaces(loads):
    """Whether loads, given by their Numba type, or a stand-in for them, have any on surfaces."""
    names = loads.instance_class._fields
    return "surfaces" in names and len(loads.types[names.index("surfaces")]) > 0


def _three(V):
    """A vector of the scene as three numbers, zero in missing directions."""


@specialise(_three)
def _three_of(V):
    return (lambda V: (V[0], 0.0, 0.0), lambda V: (V[0], V[1], 0.0), lambda V: V)[len(V) - 1]


def _force(force, frame, particles, p):
    """Body force per mass of particle `p` as three numbers, (17)."""


def _own_force(kind):
    """`_force` by a function of one's own, which may take the initial position."""

    def force_by_place(force, frame, particles, p):
        x, v = read(particles.x, p, 0, frame.origin), read(particles.v, p, 0, frame.origin)
        return _three(call(force.source, (x, x, v, force.time)))

    def force_by_origin(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        x, v = read(particles.x, p, 0, frame.origin), read(particles.v, p, 0, frame.origin)
        return _three(call(force.source, (X, x, v, force.time)))

    return force_by_origin if 0 in kind.taken else force_by_place


@specialise(_force)
def _force_of(force, frame, particles, p):
    D = len(frame.types[0])
    if hasattr(force.types[0].instance_class, "taken"):
        return _own_force(force.types[0].instance_class)
    if hasattr(force.types[0].instance_class, "acceleration"):

        def force_here(force, frame, particles, p):
            x = _three(read(particles.x, p, 0, frame.origin))
            v = _three(read(particles.v, p, 0, frame.origin))
            return acceleration(force.source, x, v, force.time)

        return force_here

    def force1(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        return body_force(force.source, X, force.time)[0], 0.0, 0.0

    def force2(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        b = body_force(force.source, X, force.time)
        return b[0], b[1], 0.0

    def force3(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        return body_force(force.source, X, force.time)

    return (force1, force2, force3)[D - 1]


def weight(force, walls, frame, particles, p):
    """Vector (0, m_p b_p), which (17) adds to the force on the support's vertices, or ().

    With walls its first component is for `pgimp.kernels.grid.wall_gap`.
    """


@specialise(weight)
def _weight(force, walls, frame, particles, p):
    forced, near = hasattr(force, "instance_class"), len(walls) > 0
    if not forced and not near:
        return lambda force, walls, frame, particles, p: ()

    def near_walls(force, walls, frame, particles, p):
        return pack(particles.m[p] * divergence(walls, particles, p, 0), 0.0, 0.0, 0.0)

    def weight_of(force, walls, frame, particles, p):
        m = particles.m[p]
        b = _force(force, frame, particles, p)
        return pack(0.0, m * b[0], m * b[1], m * b[2])

    def weight_near_walls(force, walls, frame, particles, p):
        m = particles.m[p]
        b = _force(force, frame, particles, p)
        div = divergence(walls, particles, p, 0)
        return pack(m * div, m * b[0], m * b[1], m * b[2])

    if not forced:
        return near_walls
    return weight_near_walls if near else weight_of


def relaxed_part(rate, dt):
    """Grid's part of a particle's velocity after a step; 0 without relaxation."""


@specialise(relaxed_part)
def _relaxed_part(rate, dt):
    if hasattr(rate, "count"):  # ()
        return lambda rate, dt: 0.0
    return lambda rate, dt: min(rate * dt, 1.0)


def relaxed(rate, dt, v, u):
    """Velocities v of particles, after (27), relaxed towards the grid's velocities u there.

    By (27) alone a particle keeps for ever the part of its velocity that the grid cannot resolve.
    This relaxes it, and some of the resolved part, at a rate that does not depend on the step.
    """


@specialise(relaxed)
def _relaxed(rate, dt, v, u):
    if hasattr(rate, "count"):  # ()
        return lambda rate, dt, v, u: v

    def relax(rate, dt, v, u):
        part = relaxed_part(rate, dt)
        return plus_scaled(part, u, scaled(1.0 - part, v))

    return relax


def given(rate, m, dt, v, a, V, A):
    """Momentum that particles gain where vertices of mass m have (V, A) instead of (v, a).

    By (27) they get the acceleration; the relaxed part gets the velocity.
    """


@specialise(given)
def _given(rate, m, dt, v, a, V, A):
    if hasattr(rate, "count"):  # ()
        return lambda rate, m, dt, v, a, V, A: m * dt * (A - a)

    def gained(rate, m, dt, v, a, V, A):
        part = relaxed_part(rate, dt)
        return m * ((1.0 - part) * dt * (A - a) + part * (V - v))

    return gained


def scatter_loads(loads, setting, field, particles, rows, span, layer):
    """Add the loads of a layer's particles, but for stress and body force, to its planes."""


@specialise(scatter_loads)
def _scatter_loads(loads, setting, field, particles, rows, span, layer):
    faces, surfaces = len(loads.types[1]) > 0, _has_surfaces(loads)

    def scatter_both(loads, setting, field, particles, rows, span, layer):
        scatter_tractions(loads.tractions, setting, field, particles, rows, span, layer)
        scatter_surfaces(loads.surfaces, setting, field, particles, rows, span, layer)

    if faces and surfaces:
        return scatter_both
    if surfaces:
        return lambda loads, setting, field, particles, rows, span, layer: scatter_surfaces(
            loads.surfaces, setting, field, particles, rows, span, layer
        )
    if not faces:
        return lambda loads, setting, field, particles, rows, span, layer: None
    return lambda loads, setting, field, particles, rows, span, layer: scatter_tractions(
        loads.tractions, setting, field, particles, rows, span, layer
    )


def layer_power(loads, setting, field, particles, rows, span, layer, dt):
    """Power of the loads on a layer's particles, without the body force."""


@specialise(layer_power)
def _layer_power(loads, setting, field, particles, rows, span, layer, dt):
    faces, surfaces = len(loads.types[1]) > 0, _has_surfaces(loads)

    def power_of_both(loads, setting, field, particles, rows, span, layer, dt):
        own = traction_power(loads.tractions, setting, field, particles, rows, span, layer, dt)
        more = surface_power(loads.surfaces, setting, field, particles, rows, span, layer, dt)
        return own + more

    if faces and surfaces:
        return power_of_both
    if surfaces:
        return lambda loads, setting, field, particles, rows, span, layer, dt: surface_power(
            loads.surfaces, setting, field, particles, rows, span, layer, dt
        )
    if not faces:
        return lambda loads, setting, field, particles, rows, span, layer, dt: 0.0
    return lambda loads, setting, field, particles, rows, span, layer, dt: traction_power(
        loads.tractions, setting, field, particles, rows, span, layer, dt
    )


def add_force_power(force, frame, particles, four, u, power):
    """Power so far plus the power of the body force on four particles, which moves at `u`."""


@specialise(add_force_power)
def _add_force_power(force, frame, particles, four, u, power):
    if not hasattr(force, "instance_class"):
        return lambda force, frame, particles, four, u, power: power

    def add(force, frame, particles, four, u, power):
        for j in range(four.size):
            p, w = four.rows[j], of_lane(u, j)
            b = _force(force, frame, particles, p)
            rate = 0.0
            for d in range(len(w)):
                rate += b[d] * w[d]
            power += particles.m[p] * rate
        return power

    return add
