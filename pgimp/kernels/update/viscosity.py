"""Artificial viscosity (45): a pressure q in compression that spreads shocks over some cells.

Let D be the rate of volume change, c the wave speed, rho the density and L the cell's size. Then
q = c1 rho c L |D| + c2 rho (L D)^2 for D < 0, else 0. It enters the internal force (16) of the next
step, s_p - q; the stored stress is the material's.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pgimp.jit.algebra import trace
from pgimp.jit.kernel import inlined, is_record
from pgimp.jit.vectors.kinds import is_vector
from pgimp.jit.vectors.simd import where
from pgimp.kernels.transfer.lane_io import put_row, take
from pgimp.kernels.update.stress import states, wave_speed


class Viscosity(NamedTuple):
    """Coefficients c1 and c2 of each material, (materials,), and the smallest side of a cell."""

    linear: np.ndarray
    quadratic: np.ndarray
    cell: float


@inlined
def viscous_pressure(viscosity, particles, p):
    """Pressure q of particle `p` from the last step; zero in scenes without viscosity."""
    if not is_record(viscosity):
        return 0.0
    return particles.q[p, 0]


@inlined
def update_viscous_pressure(viscosity, setting, m, particles, rows, F, J, L):
    """Set q of four particles for the next step; `m` are their materials, F, J and L vectors.

    Returns
    -------
    Vec4
        q/(rho L |D|), the speed that viscosity adds; 0 without any.
    """
    if not is_record(viscosity):
        return 0.0
    c = wave_speed(setting, m, F, J, states(setting.materials, particles, rows, F))
    compression = -viscosity.cell * trace(L)
    compressed = compression > 0.0
    c1, c2 = take(viscosity.linear, m), take(viscosity.quadratic, m)
    speed = where(compressed, c1 * c + c2 * compression, 0.0)
    density = take(particles.m, rows) / (J * take(particles.V0, rows))
    put_row(particles.q, rows, 0, (where(compressed, density * speed * compression, 0.0),))
    return speed


@inlined
def effective_wave_speed(c, extra):
    """Wave speed that limits the step: c sqrt(1 + z^2) + c z with the damping ratio z = extra/c.

    `extra` is a vector where the scene has any viscosity, else a number.
    """
    if not is_vector(extra):
        return c
    return sqrt(c * c + extra * extra) + extra
