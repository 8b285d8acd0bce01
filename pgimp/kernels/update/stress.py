"""Stress and state of the materials, and the speed of their waves."""

from math import isqrt

from numba.core import types
from numba.extending import overload

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import INLINE_OPTIONS, inlined, specialise
from pgimp.jit.tuples import read
from pgimp.kernels.transfer.lane_io import put_row, take_row
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.physics.materials.base import has, state_width, takes_viscous_pressure
from pgimp.physics.materials.parameters.evaluate import evaluate, evaluate_four


def _width(materials, like):
    """Greatest number of state variables of some materials; `like` is as long as F."""
    dimensions = isqrt(len(like))
    return max(state_width(material.instance_class, dimensions) for material in materials)


def _materials(setting):
    """Numba's types of the materials of a scene."""
    return setting.types[setting.fields.index("materials")]


def has_any(setting, quantity):
    """Whether a material of the scene has a quantity that others do not have."""
    return any(has(each.instance_class, quantity) for each in _materials(setting))


def states(materials, particles, rows, like):
    """State of four particles, as many vectors as the widest material needs; `like` is as F."""


@specialise(states)
def _states(materials, particles, rows, like):
    width = _width(materials, like)
    if width == 0:
        return lambda materials, particles, rows, like: ()
    zeros = (0.0,) * width
    return lambda materials, particles, rows, like: take_row(particles.state, rows, 0, zeros)


def state_of(materials, particles, p, like):
    """As `states`, of one particle."""


@specialise(state_of)
def _state_of(materials, particles, p, like):
    width = _width(materials, like)
    if width == 0:
        return lambda materials, particles, p, like: ()
    zeros = (0.0,) * width
    return lambda materials, particles, p, like: read(particles.state, p, 0, zeros)


def of_particle(quantity, setting, particles, p, F, more):
    """As `evaluate`, of particle `p` by its material, state and stress.

    Parameters
    ----------
    quantity : str
        A literal.
    setting, particles
        See `KernelScene`, `Particles`.
    p : int
        Its row.
    F : tuple of float
        Deformation gradient.
    more : tuple
        Arguments after the stress.
    """


@overload(of_particle, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _of_particle(quantity, setting, particles, p, F, more):
    if not isinstance(quantity, types.Literal):
        return None
    name = quantity.literal_value

    def value(quantity, setting, particles, p, F, more):
        materials = substitute_parameters(setting, particles, p).materials
        sigma = read(particles.sigma, p, 0, symmetric(F))
        state = state_of(materials, particles, p, F)
        number = setting.material_of[particles.body[p]]
        return evaluate(name, materials, number, (F, determinant(F), sigma, *more), state)

    return value


def update_stress(setting, forcing, particles, rows, numbers, F, J, L):
    """Stress and state of four particles after a step.

    Parameters
    ----------
    setting, forcing, particles
        See `KernelScene`, `Forcing`, `Particles`.
    rows, numbers : tuple of 4 int
        Their rows and the numbers of their materials.
    F, L : tuple of Vec4
        Deformation gradients at the end of the step, velocity gradients; matrices.
    J : Vec4
        det F.

    Returns
    -------
    sigma, state : tuple of Vec4
    """


@specialise(update_stress)
def _update_stress(setting, forcing, particles, rows, numbers, F, J, L):
    components = (3, 4, 6)[isqrt(len(F)) - 1]

    def update(setting, forcing, particles, rows, numbers, F, J, L):
        materials = setting.materials
        sigma = take_row(particles.sigma, rows, 0, symmetric(L))
        state = states(materials, particles, rows, F)
        args = (F, J, sigma, L, forcing.dt, *heating(setting, forcing.loads, particles, rows))
        found = evaluate_four("stress", materials, numbers, args, state, (*sigma, *state))
        return found[:components], found[components:]

    def update_without(setting, forcing, particles, rows, numbers, F, J, L):
        sigma = take_row(particles.sigma, rows, 0, symmetric(L))
        args = (F, J, sigma, L, forcing.dt)
        return evaluate_four("stress", setting.materials, numbers, args, (), sigma), ()

    return update if _width(_materials(setting), F) else update_without


def heating(setting, loads, particles, rows):
    """Viscous pressure q of four particles in a step, (q,), where a material needs it; else ()."""


@specialise(heating)
def _heating(setting, loads, particles, rows):
    viscous = hasattr(loads.types[loads.fields.index("viscosity")], "instance_class")
    needed = any(takes_viscous_pressure(each.instance_class) for each in _materials(setting))
    if not (viscous and needed):
        return lambda setting, loads, particles, rows: ()
    return lambda setting, loads, particles, rows: take_row(particles.q, rows, 0, (0.0,))


@inlined
def keep_state(particles, rows, state):
    """Store the state of four particles, if they have any."""
    if len(state):
        put_row(particles.state, rows, 0, state)
    else:
        return None


@inlined
def wave_speed(setting, numbers, F, J, state):
    """Speeds of the fastest wave through four particles; `numbers` are their materials."""
    return evaluate_four("speed", setting.materials, numbers, (F, J), state, J)


def diffusion_speed(setting, numbers, F, J, state, inverse, extra):
    """Viscosity's share of the speed that limits the step, see `effective_wave_speed`.

    The explicit diffusion of momentum with the diffusivity nu is stable up to dt = h^2/(2 D nu),
    for cells of side h in D directions. This is the limit for a speed of D nu/h.

    Parameters
    ----------
    inverse : float
        1/h.
    extra : Vec4 or float
        The share of artificial viscosity.
    """


@specialise(diffusion_speed)
def _diffusion_speed(setting, numbers, F, J, state, inverse, extra):
    if not has_any(setting, "diffusivity"):
        return lambda setting, numbers, F, J, state, inverse, extra: extra
    D = float(isqrt(len(F)))

    def speed(setting, numbers, F, J, state, inverse, extra):
        nu = evaluate_four("diffusivity", setting.materials, numbers, (F, J), state, J)
        return extra + D * inverse * nu

    return speed


def margins(setting, numbers, F, J, sigma, state):
    """Margins of four particles to the end of their materials' range; 1 where none has one."""


@specialise(margins)
def _margins(setting, numbers, F, J, sigma, state):
    if not has_any(setting, "margin"):
        return lambda setting, numbers, F, J, sigma, state: 1.0
    return lambda setting, numbers, F, J, sigma, state: evaluate_four(
        "margin", setting.materials, numbers, (F, J, sigma), state, J
    )
