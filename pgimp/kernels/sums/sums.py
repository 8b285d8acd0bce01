"""Sums over the particles, layer by layer in canonical order, and their greatest speed."""

from math import isqrt, sqrt

from pgimp.jit.algebra import determinant, symmetric
from pgimp.jit.kernel import class_of, inlined, inner_kernel, kernel
from pgimp.jit.tuples import read
from pgimp.kernels.transfer.first_vertex import is_axial
from pgimp.kernels.update.pace import pace
from pgimp.kernels.update.speed import own_speed, speed_of_waves
from pgimp.kernels.update.stress import has_any, state_of
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.physics.materials.parameters.evaluate import evaluate

#: Columns of `layer_sums`.
MASS, MOMENTUM, ANGULAR, MOMENT, KINETIC, STRAIN, SUMS = 0, 1, 4, 7, 10, 11, 12


@inlined
def book_losses(row, materials, k, args, state, V0):
    """Add the energy losses that a particle's material reports, after the other sums.

    Nothing is added without materials that report losses.
    """
    if any(hasattr(class_of(material), "losses") for material in materials):
        losses = evaluate("losses", materials, k, args, state)
        for n, loss in enumerate(losses):
            row[SUMS + n] += V0 * loss


@inlined
def remaining_across(frame):
    """Part of a sum along x that remains: 0 of rings, round whose axis it vanishes; else 1."""
    if is_axial(frame):
        return 0.0
    return 1.0


@inner_kernel
def unwrapped(frame, particles, p, d):
    """Coordinate `d` of particle `p`, with its turns through periodic faces."""
    x = particles.x[p, d]
    if particles.winding.shape[1] > 0:
        x += particles.winding[p, d] * (frame.cells[d] * frame.cell[d])
    return x


@kernel
def layer_sums(setting, particles, order, sums):
    """Add up mass, momentum, angular momentum, first moment, kinetic and strain energy.

    Parameters
    ----------
    setting, particles, order
        See `KernelScene`, `Particles`, `Order`.
    sums : (layers, bodies, columns) float64
        Zero on entry; `SUMS` columns as named in this module, and one for each of `LOSSES` where
        materials have any.
    """
    like, start, D = setting.identity, order.start, len(setting.frame.origin)
    across = remaining_across(setting.frame)
    for layer in range(len(start) - 1):
        for k in range(start[layer], start[layer + 1]):
            p = order.rows[k]
            body = particles.body[p]
            row = sums[layer, body]
            m = particles.m[p]
            x0, y0, z0 = unwrapped(setting.frame, particles, p, 0), 0.0, 0.0
            vx, vy, vz = particles.v[p, 0], 0.0, 0.0
            if D > 1:
                y0, vy = unwrapped(setting.frame, particles, p, 1), particles.v[p, 1]
            if D > 2:
                z0, vz = unwrapped(setting.frame, particles, p, 2), particles.v[p, 2]
            row[MASS] += m
            row[MOMENTUM] += across * (m * vx)
            row[MOMENTUM + 1] += m * vy
            row[MOMENTUM + 2] += m * vz
            row[ANGULAR] += m * (y0 * vz - z0 * vy)
            row[ANGULAR + 1] += m * (z0 * vx - x0 * vz)
            row[ANGULAR + 2] += across * (m * (x0 * vy - y0 * vx))
            row[MOMENT] += across * (m * x0)
            row[MOMENT + 1] += m * y0
            row[MOMENT + 2] += m * z0
            row[KINETIC] += 0.5 * m * (vx * vx + vy * vy + vz * vz)
            F = read(particles.F, p, 0, like)
            sigma = read(particles.sigma, p, 0, symmetric(like))
            J = determinant(F)
            materials = substitute_parameters(setting, particles, p).materials
            state = state_of(materials, particles, p, F)
            k, args = setting.material_of[body], (F, J, sigma)
            row[STRAIN] += particles.V0[p] * evaluate("energy", materials, k, args, state)
            book_losses(row, materials, k, args, state, particles.V0[p])


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
        Zero on entry; then mass is ``(high + low / 2**62) / unit``. The part of a mass below
        2^-62 / unit is dropped: zero, unless it is 2^69 times lighter than the greatest sum.
    """
    for p in rows:
        scaled = particles.m[p] * unit
        high = int(scaled)
        row = masses[particles.body[p]]
        low = row[1] + int((scaled - high) * 2.0**LOW)
        row[0] += high + (low >> LOW)
        row[1] = low & ((1 << LOW) - 1)


@inlined
def _with_diffusion(setting, k, args, state, inverse, c):
    """Speed limiting the step of a particle of material `k`, from waves and viscosity."""
    if not has_any(setting.materials, "diffusivity"):
        return c
    D = float(isqrt(len(args[0])))
    extra = D * inverse * evaluate("diffusivity", setting.materials, k, args, state)
    return sqrt(c * c + extra * extra) + extra


@kernel
def fastest_rate(setting, particles, rows, controlled):
    """Largest `pace` over L of the particles in `rows`, 1/time; times dt the Courant number.

    With viscous materials c_p is `effective_wave_speed`; in the initial configuration it is the
    wave speed alone, see `pgimp.kernels.update.speed`.
    """
    frame, material_of = setting.frame, setting.material_of
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    rate = 0.0
    for p in rows:
        F = read(particles.F, p, 0, setting.identity)
        own = substitute_parameters(setting, particles, p)
        state = state_of(own.materials, particles, p, F)
        args, v = (F, determinant(F)), read(particles.v, p, 0, frame.origin)
        c = speed_of_waves(own, material_of[particles.body[p]], args, state)
        c = _with_diffusion(own, material_of[particles.body[p]], args, state, inverse, c)
        rate = max(rate, pace(controlled, c, own_speed(frame, v)) * inverse)
    return rate
