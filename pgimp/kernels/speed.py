"""How fast waves and particles cross the grid: what limits the step.

In the current configuration particles move over the grid, at (c + |v|)/L. A grid of the initial
configuration moves and deforms with the material: what crosses it is waves alone, and how fast
follows from lengths at the start. A wave of speed c along n goes along N = F^T n/|F^T n| there, at
c |F^-T N|: at most c over the least stretch, of which the greatest row sum of C^-1 = F^-1 F^-T,
which no rotation changes, gives a bound, exact where the stretches lie along the grid. That takes
the fastest wave and the least stretch together, though a stretched bar has them along directions of
its own; a material may know better by an `initial_speed(material, F, J)`.
"""

from math import sqrt

from pgimp.jit.algebra import inverse, largest_stretch_squared, left_cauchy_green
from pgimp.jit.kernel import specialise
from pgimp.jit.tuples import squared
from pgimp.kernels.place import is_initial
from pgimp.kernels.updates.stress import wave_speed
from pgimp.kernels.viscosity import effective_wave_speed
from pgimp.physics.materials.base import evaluate, evaluate_four


def has_initial_speed(materials):
    """Whether all materials, given by their Numba types, have an `initial_speed`."""
    return all(hasattr(material.instance_class, "initial_speed") for material in materials)


def shortening(F):
    """Bound of 1 over the least stretch of a deformation gradient."""


@specialise(shortening)
def _shortening(F):
    return lambda F: sqrt(largest_stretch_squared(left_cauchy_green(inverse(F))))


def _initial_speed(setting, numbers, F, J, state, by):
    """Speeds of waves in the initial configuration; `by` is what `shortening` gives."""


@specialise(_initial_speed)
def _initial_speed_of(setting, numbers, F, J, state, by):
    if has_initial_speed(setting.types[setting.fields.index("materials")]):
        return lambda setting, numbers, F, J, state, by: evaluate_four(
            "initial_speed", setting.materials, numbers, (F, J), state, J
        )
    return lambda setting, numbers, F, J, state, by: (
        by * wave_speed(setting, numbers, F, J, state)
    )


def grid_speed(setting, viscosity, numbers, v, F, J, state, extra):
    """Speeds at which four particles, and waves through them, cross the grid.

    Parameters
    ----------
    setting, viscosity
        See `Setting`, `Viscosity`.
    numbers : tuple of 4 int
        Their materials.
    v, F, J, state
        As in `grid_to_particles`, after the step.
    extra : Vec4
        What `update_viscous_pressure` gives.
    """


@specialise(grid_speed)
def _grid_speed(setting, viscosity, numbers, v, F, J, state, extra):
    def current(setting, viscosity, numbers, v, F, J, state, extra):
        c = wave_speed(setting, numbers, F, J, state)
        c = effective_wave_speed(viscosity, c, extra)
        return c + sqrt(squared(v))

    def initial(setting, viscosity, numbers, v, F, J, state, extra):
        by = shortening(F)
        c = _initial_speed(setting, numbers, F, J, state, by)
        return effective_wave_speed(viscosity, c, by * by * extra)

    return initial if is_initial(setting.types[setting.fields.index("frame")]) else current


def speed_at(setting, number, v, F, J, state):
    """As `grid_speed`, of one particle, without viscosity."""


@specialise(speed_at)
def _speed_at(setting, number, v, F, J, state):
    def current(setting, number, v, F, J, state):
        return evaluate("speed", setting.materials, number, (F, J), state) + sqrt(squared(v))

    def known(setting, number, v, F, J, state):
        return evaluate("initial_speed", setting.materials, number, (F, J), state)

    def bounded(setting, number, v, F, J, state):
        return shortening(F) * evaluate("speed", setting.materials, number, (F, J), state)

    if not is_initial(setting.types[setting.fields.index("frame")]):
        return current
    materials = setting.types[setting.fields.index("materials")]
    return known if has_initial_speed(materials) else bounded
