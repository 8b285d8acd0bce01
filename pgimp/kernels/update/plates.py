"""Plane stress: particles grow thicker or thinner, so that no stress acts out of the plane.

F has a zz, the stretch of the thickness, and L its rate r. In each step r is the root of

    s_zz(F(r), L(r)) = 0

by the material's own law: a secant method, whose first slope is that of the fastest wave, rho c^2.
Where a slope is beyond its bounds, as at a yield surface, this one is taken instead. Each of four
particles goes its own way and stops for itself, so that its bits do not depend on the others.
"""

from pgimp.jit.algebra import determinant, inverse, multiply, one_plus
from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import plus_scaled
from pgimp.jit.vectors.simd import bits, vector, where
from pgimp.kernels.transfer.first_vertex import is_initial
from pgimp.kernels.transfer.lane_io import deformations, take
from pgimp.kernels.update.stress import update_stress, wave_speed
from pgimp.kernels.update.varying import substitute_parameters

#: Stress out of the plane that is left, over rho c^2, and evaluations until it is.
TOLERANCE, ITERATIONS = 1e-13, 40

#: Bounds of a secant's slope over the wave's. It is 1 at most, but for rounding. J2 flow leaves
#: K/(K + 4G/3), and rubber that is stretched by a in the plane about 1/a^2.
MIN_SLOPE, MAX_SLOPE = 1e-4, 1.5

#: Greatest change of the thickness in one evaluation, relative.
MAX_CHANGE = 0.25


@inlined
def _in_plane(frame, dt, D, F):
    """L, and F after the step, in the plane; `F` is the one before."""
    if is_initial(frame):
        return (multiply(D, inverse(F)), plus_scaled(dt, D, F))
    return (D, multiply(one_plus(dt, D), F))


@inlined
def deform_plate(setting, forcing, particles, four, numbers, D):
    """Velocity gradients L and deformation gradients F of four particles, with zz.

    Parameters
    ----------
    setting, forcing, particles, four, numbers, D
        See `pgimp.kernels.update.mean_dilatation_lagrangian.deform`; `D` is in the plane.
    """
    dt, before = forcing.dt, deformations(setting.frame, particles, four.rows)
    L, F = _in_plane(setting.frame, dt, D, before[:4])
    own = substitute_parameters(setting, particles, four.rows)
    thickness, density = before[4], take(particles.m, four.rows) / take(particles.V0, four.rows)
    r, last_r = vector(0.0), vector(0.0)
    slope, last, done = vector(1.0), vector(0.0), vector(0.0)
    for n in range(ITERATIONS):
        now = (*F, thickness * (1.0 + dt * r))
        J = determinant(now)
        sigma, state = update_stress(own, forcing, particles, four.rows, numbers, now, J, (*L, r))
        s = sigma[2]
        if n == 0:
            c = wave_speed(own, numbers, now, J, state)
            slope = dt * density * c * c / J
            k = slope
        else:
            change = r - last_r
            k = (s - last) / where(change == 0.0, vector(1.0), change)
            k = where(k > MIN_SLOPE * slope, where(k < MAX_SLOPE * slope, k, slope), slope)
        done = where(abs(s) * dt <= TOLERANCE * slope, vector(1.0), done)
        if bits(done > 0.0) == 15:
            break
        way = -s / k
        most = MAX_CHANGE / dt * (1.0 + dt * r)
        way = max(min(way, most), -most)
        last_r, last = r, s
        r = where(done > 0.0, r, r + way)
    return (*L, r), (*F, thickness * (1.0 + dt * r))
