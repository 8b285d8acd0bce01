"""Speed at which waves and particles cross the grid, which limits the step.

In the current configuration particles move over the grid, at (c + |v|)/L. A grid of the initial
configuration moves and deforms with the material: only waves cross it, at a speed in initial
lengths. A wave of speed c along n goes along N = F^T n/|F^T n| there, at c |F^-T N|: at most c over
the least stretch. The greatest row sum of C^-1 = F^-1 F^-T, which no rotation changes, bounds it,
exactly for stretches along the grid. This combines the fastest wave with the least stretch, whose
directions may differ, as in a stretched bar. A material may give a better bound by an
`initial_speed(material, F, J)`.
"""

from math import sqrt

from pgimp.jit.algebra import inverse, largest_stretch_squared, left_cauchy_green
from pgimp.jit.kernel import class_of, inlined
from pgimp.jit.tuples import squared
from pgimp.jit.vectors.kinds import is_vector
from pgimp.kernels.transfer.first_vertex import is_initial
from pgimp.kernels.update.pace import pace
from pgimp.kernels.update.stress import diffusion_speed, wave_speed
from pgimp.kernels.update.viscosity import effective_wave_speed
from pgimp.physics.materials.parameters.evaluate import evaluate, evaluate_four


@inlined
def has_initial_speed(materials):
    """Whether all materials have an `initial_speed`."""
    return all(hasattr(class_of(material), "initial_speed") for material in materials)


@inlined
def shortening(F):
    """Bound of 1 over the least stretch of a deformation gradient."""
    return sqrt(largest_stretch_squared(left_cauchy_green(inverse(F))))


@inlined
def _initial_speed(setting, numbers, F, J, state, by):
    """Speeds of waves in the initial configuration; `by` is from `shortening`."""
    if has_initial_speed(setting.materials):
        return evaluate_four("initial_speed", setting.materials, numbers, (F, J), state, J)
    return by * wave_speed(setting, numbers, F, J, state)


@inlined
def grid_speed(setting, controlled, numbers, after, inverse, extra):
    """Speeds at which four particles, and waves through them, cross the grid.

    Parameters
    ----------
    setting
        See `KernelScene`.
    controlled : bool or float
        See `pace`.
    numbers : tuple of 4 int
        Their materials.
    after : tuple
        v, F, J and state after the step, as in `grid_to_particles`.
    inverse : float
        1 over the side of a cell.
    extra : Vec4 or float
        From `update_viscous_pressure`.
    """
    if is_initial(setting.frame):
        _, F, J, state = after
        by = shortening(F)
        c = _initial_speed(setting, numbers, F, J, state, by)
        extra = diffusion_speed(setting, numbers, F, J, state, inverse, extra)
        return effective_wave_speed(c, _steeper(by, extra))
    v, F, J, state = after
    c = wave_speed(setting, numbers, F, J, state)
    extra = diffusion_speed(setting, numbers, F, J, state, inverse, extra)
    c = effective_wave_speed(c, extra)
    return pace(controlled, c, sqrt(squared(v)))


@inlined
def _steeper(by, extra):
    """The share of viscosity, by lengths of the initial configuration: a vector by^2 extra."""
    if not is_vector(extra):
        return extra
    return by * by * extra


@inlined
def speed_of_waves(setting, number, args, state):
    """Speed of waves over the grid through one particle; `args` are F and J."""
    if not is_initial(setting.frame):
        return evaluate("speed", setting.materials, number, args, state)
    materials = setting.materials
    if has_initial_speed(materials):
        return evaluate("initial_speed", setting.materials, number, args, state)
    return shortening(args[0]) * evaluate("speed", setting.materials, number, args, state)


@inlined
def own_speed(frame, v):
    """Speed at which a particle crosses the grid: its velocity's, 0 where it cannot."""
    if is_initial(frame):
        return 0.0
    return sqrt(squared(v))
