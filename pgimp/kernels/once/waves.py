"""Speeds of small waves in particles, by their materials: of compression, and of shear."""

from math import isqrt, sqrt

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.tuples import read, scaled
from pgimp.kernels.transfer.first_vertex import deformation, is_plate
from pgimp.kernels.update.stress import state_of
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.physics.materials.parameters.evaluate import evaluate

#: The shear strain whose stress gives the stiffness in shear.
STRAIN = 2.0**-20


@kernel
def small_wave_speeds(setting, particles, rows, length, speeds):
    """Find the speeds of small waves in some particles.

    That of shear follows from the stress of a small shear, in the time of a wave on the way
    `length`: the stiffer one of both directions, as one of them may flow.

    Parameters
    ----------
    setting, particles
        See `KernelScene`, `Particles`.
    rows : (n,) int64
        Their rows.
    length : float
        Side of a cell.
    speeds : (n, 2) float64
        Gets the speeds of compression and of shear.
    """
    for i in range(len(rows)):
        p = rows[i]
        F = deformation(setting.frame, particles, p)
        materials = substitute_parameters(setting, particles, p).materials
        number, state = setting.material_of[particles.body[p]], state_of(materials, particles, p, F)
        args = (F, determinant(F))
        c = evaluate("speed", materials, number, args, state)
        one = _shear_stress(setting, particles, p, materials, STRAIN, length / c)
        other = _shear_stress(setting, particles, p, materials, -STRAIN, length / c)
        before = _shear_stress(setting, particles, p, materials, 0.0, length / c)
        modulus = max(abs(one - before), abs(other - before)) / STRAIN
        s = sqrt(modulus * particles.V[p] / particles.m[p])
        speeds[i, 0], speeds[i, 1] = _in_a_plate(setting.frame, c, s), s


@inlined
def _in_a_plate(frame, c, s):
    """Speed of compression in plane stress, by the speeds c and s in space; else c."""
    if is_plate(frame):
        return 2.0 * s * sqrt(1.0 - (s / c) ** 2)
    return c


@inlined
def _shear_stress(setting, particles, p, materials, strain, dt):
    """Stress xy of a particle after a shear along x in the time `dt`; 0 in 1D."""
    like = setting.identity
    D = isqrt(len(like))
    if D == 1:
        return 0.0
    F = deformation(setting.frame, particles, p)
    number, state = setting.material_of[particles.body[p]], state_of(materials, particles, p, F)
    still = scaled(0.0, F)
    L = (still[0], strain / dt, *still[2:])
    sheared = _sheared(F, strain)
    sigma = read(particles.sigma, p, 0, symmetric(F))
    args = (sheared, determinant(sheared), sigma, L, dt)
    return evaluate("stress", materials, number, args, state)[3]


@inlined
def _sheared(F, strain):
    """(1 + strain e_x e_y) F."""
    D = isqrt(len(F))
    return tuple(F[d] + strain * F[D + d] for d in range(D)) + F[D:]
