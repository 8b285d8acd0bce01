"""Stress and state of the materials, and the speed of their waves."""

from math import isqrt

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import inlined, is_record, of_types
from pgimp.jit.tuples import read
from pgimp.kernels.transfer.lane_io import put_row, take_row
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.physics.materials.base import has, state_width, takes_viscous_pressure
from pgimp.physics.materials.parameters.evaluate import evaluate, evaluate_four


@of_types
def _width(materials, like):
    """Greatest number of state variables of some materials; `like` is as long as F."""
    dimensions = isqrt(len(like))
    return max(state_width(material.instance_class, dimensions) for material in materials)


@of_types
def has_any(materials, quantity):
    """Whether one of the materials has a quantity that others do not have."""
    return any(has(each.instance_class, quantity) for each in materials)


@of_types
def _takes_viscous_pressure(materials):
    """Whether one of the materials needs the viscous pressure."""
    return any(takes_viscous_pressure(each.instance_class) for each in materials)


@inlined
def materials_of(material_of, body, rows):
    """Materials of four particles."""
    return tuple(material_of[body[rows[j]]] for j in range(4))


@inlined
def states(materials, particles, rows, like):
    """State of four particles, as many vectors as the widest material needs; `like` is as F."""
    width = _width(materials, like)
    if width == 0:
        return ()
    zeros = (0.0,) * width
    return take_row(particles.state, rows, 0, zeros)


@inlined
def state_of(materials, particles, p, like):
    """As `states`, of one particle."""
    width = _width(materials, like)
    if width == 0:
        return ()
    zeros = (0.0,) * width
    return read(particles.state, p, 0, zeros)


@inlined
def of_particle(quantity, setting, particles, p, F, more):
    """As `evaluate`, of particle `p` by its material, state and stress.

    Parameters
    ----------
    quantity : str
        Its name.
    setting, particles
        See `KernelScene`, `Particles`.
    p : int
        Its row.
    F : tuple of float
        Deformation gradient.
    more : tuple
        Arguments after the stress.
    """
    materials = substitute_parameters(setting, particles, p).materials
    sigma = read(particles.sigma, p, 0, symmetric(F))
    state = state_of(materials, particles, p, F)
    number = setting.material_of[particles.body[p]]
    return evaluate(quantity, materials, number, (F, determinant(F), sigma, *more), state)


@inlined
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
    components = (3, 4, 6)[isqrt(len(F)) - 1]
    if _width(setting.materials, F):
        materials = setting.materials
        sigma = take_row(particles.sigma, rows, 0, symmetric(L))
        state = states(materials, particles, rows, F)
        args = (F, J, sigma, L, forcing.dt, *heating(setting, forcing.loads, particles, rows))
        found = evaluate_four("stress", materials, numbers, args, state, (*sigma, *state))
        return found[:components], found[components:]
    sigma = take_row(particles.sigma, rows, 0, symmetric(L))
    args = (F, J, sigma, L, forcing.dt)
    return evaluate_four("stress", setting.materials, numbers, args, (), sigma), ()


@inlined
def heating(setting, loads, particles, rows):
    """Viscous pressure q of four particles in a step, (q,), where a material needs it; else ()."""
    if is_record(loads.viscosity) and _takes_viscous_pressure(setting.materials):
        return take_row(particles.q, rows, 0, (0.0,))
    return ()


@inlined
def keep_state(particles, rows, state):
    """Store the state of four particles, if they have any."""
    if len(state):
        put_row(particles.state, rows, 0, state)


@inlined
def wave_speed(setting, numbers, F, J, state):
    """Speeds of the fastest wave through four particles; `numbers` are their materials."""
    return evaluate_four("speed", setting.materials, numbers, (F, J), state, J)


@inlined
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
    if not has_any(setting.materials, "diffusivity"):
        return extra
    D = float(isqrt(len(F)))
    nu = evaluate_four("diffusivity", setting.materials, numbers, (F, J), state, J)
    return extra + D * inverse * nu


@inlined
def margins(setting, numbers, F, J, sigma, state):
    """Margins of four particles to the end of their materials' range; 1 where none has one."""
    if not has_any(setting.materials, "margin"):
        return 1.0
    return evaluate_four("margin", setting.materials, numbers, (F, J, sigma), state, J)
