"""Sums over the particles, layer by layer in canonical order, and their greatest speed."""

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read
from pgimp.kernels.speed import speed_at
from pgimp.kernels.updates.stress import state_of
from pgimp.physics.materials.base import evaluate

#: Columns of `layer_sums`.
MASS, MOMENTUM, ANGULAR, MOMENT, KINETIC, STRAIN, SUMS = 0, 1, 4, 7, 10, 11, 12


@kernel
def layer_sums(setting, particles, order, sums):
    """Add up mass, momentum, angular momentum, first moment, kinetic and strain energy.

    Parameters
    ----------
    setting, particles, order
        See `Setting`, `Particles`, `Order`.
    sums : (layers, bodies, 12) float64
        Zero on entry; columns as named in this module.
    """
    like, start, D = setting.identity, order.start, len(setting.frame.origin)
    for layer in range(len(start) - 1):
        for k in range(start[layer], start[layer + 1]):
            p = order.rows[k]
            body = particles.body[p]
            row = sums[layer, body]
            m = particles.m[p]
            x0, y0, z0 = particles.x[p, 0], 0.0, 0.0
            vx, vy, vz = particles.v[p, 0], 0.0, 0.0
            if D > 1:
                y0, vy = particles.x[p, 1], particles.v[p, 1]
            if D > 2:
                z0, vz = particles.x[p, 2], particles.v[p, 2]
            row[MASS] += m
            row[MOMENTUM] += m * vx
            row[MOMENTUM + 1] += m * vy
            row[MOMENTUM + 2] += m * vz
            row[ANGULAR] += m * (y0 * vz - z0 * vy)
            row[ANGULAR + 1] += m * (z0 * vx - x0 * vz)
            row[ANGULAR + 2] += m * (x0 * vy - y0 * vx)
            row[MOMENT] += m * x0
            row[MOMENT + 1] += m * y0
            row[MOMENT + 2] += m * z0
            row[KINETIC] += 0.5 * m * (vx * vx + vy * vy + vz * vz)
            F = read(particles.F, p, 0, like)
            sigma = read(particles.sigma, p, 0, symmetric(like))
            J = determinant(F)
            row[STRAIN] += particles.V0[p] * evaluate(
                "energy", setting.materials, setting.material_of[body], (F, J, sigma),
                state_of(setting.materials, particles, p, F),
            )  # fmt: skip


#: Bits of the two integers in which `exact_masses` holds a mass.
HIGH, LOW = 60, 62


@kernel
def exact_masses(particles, rows, unit, masses):
    """Add up the masses of a rank's particles without rounding, so that no order matters.

    Parameters
    ----------
    unit : float
        2^60 over a power of two that is greater than the sum.
    masses : (bodies, 2) int64
        Zero on entry; then mass is ``(high + low / 2**62) / unit``. What a particle has below
        2^-62 / unit is left out: nothing, unless it is 2^69 times lighter than the greatest sum.
    """
    for p in rows:
        scaled = particles.m[p] * unit
        high = int(scaled)
        row = masses[particles.body[p]]
        low = row[1] + int((scaled - high) * 2.0**LOW)
        row[0] += high + (low >> LOW)
        row[1] = low & ((1 << LOW) - 1)


@kernel
def fastest_rate(setting, particles, rows):
    """Largest (c_p + |v_p|)/L over the particles in `rows`, 1/time; times dt the Courant number.

    See `pgimp.kernels.speed`; in the initial configuration of the waves alone.
    """
    frame, materials, material_of = setting.frame, setting.materials, setting.material_of
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    rate = 0.0
    for p in rows:
        F = read(particles.F, p, 0, setting.identity)
        state = state_of(materials, particles, p, F)
        v = read(particles.v, p, 0, frame.origin)
        c = speed_at(setting, material_of[particles.body[p]], v, F, determinant(F), state)
        rate = max(rate, c * inverse)
    return rate
