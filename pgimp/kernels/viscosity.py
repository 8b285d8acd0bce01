"""Artificial viscosity (45): a pressure q in compression that spreads shocks over some cells.

With D the rate of volume change, c the wave speed, rho the density and L the cell's size,
q = c1 rho c L |D| + c2 rho (L D)^2 for D < 0, else 0. It enters the internal force (16) of the next
step, s_p - q; the stored stress is the material's.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pgimp.kernels.algebra import determinant
from pgimp.kernels.jit import specialise
from pgimp.materials.base import evaluate


class Viscosity(NamedTuple):
    """Coefficients c1 and c2 of each material, (materials,), and the smallest side of a cell."""

    linear: np.ndarray
    quadratic: np.ndarray
    cell: float


def viscous_pressure(viscosity, particles, p):
    """Pressure q of particle `p` from the last step; zero where the scene has no viscosity."""


@specialise(viscous_pressure)
def _viscous_pressure(viscosity, particles, p):
    if not hasattr(viscosity, "instance_class"):
        return lambda viscosity, particles, p: 0.0
    return lambda viscosity, particles, p: particles.q[p, 0]


def trace(L):
    """Trace of a row-major velocity gradient."""


@specialise(trace)
def _trace(L):
    if len(L) == 1:
        return lambda L: L[0]
    if len(L) == 4:
        return lambda L: L[0] + L[3]
    return lambda L: L[0] + L[4] + L[8]


def thicken(viscosity, materials, m, particles, p, F, L):
    """Set q of particle `p`, of material `m`, for the next step.

    Returns
    -------
    float
        q/(rho L |D|), the speed by which viscosity stiffens the particle; 0 without any.
    """


@specialise(thicken)
def _thicken(viscosity, materials, m, particles, p, F, L):
    if not hasattr(viscosity, "instance_class"):
        return lambda viscosity, materials, m, particles, p, F, L: 0.0

    def thicken_particle(viscosity, materials, m, particles, p, F, L):
        closing = -viscosity.cell * trace(L)
        if not closing > 0.0:
            particles.q[p, 0] = 0.0
            return 0.0
        J = determinant(F)
        c = evaluate("speed", materials, m, (F, J))
        speed = viscosity.linear[m] * c + viscosity.quadratic[m] * closing
        particles.q[p, 0] = particles.m[p] / (J * particles.V0[p]) * speed * closing
        return speed

    return thicken_particle


def stiffened(viscosity, c, slow):
    """Wave speed that limits the step: c sqrt(1 + z^2) + c z with the damping ratio z = slow/c."""


@specialise(stiffened)
def _stiffened(viscosity, c, slow):
    if not hasattr(viscosity, "instance_class"):
        return lambda viscosity, c, slow: c
    return lambda viscosity, c, slow: sqrt(c * c + slow * slow) + slow
