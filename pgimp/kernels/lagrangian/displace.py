"""Particles from the vertices' motion, in the initial configuration: when something asks for them.

Positions X_p + sum_v u_v S_vp, velocities sum_v v_v S_vp, and F = 1 + sum_v u_v grad0 S_vp with the
stress of a hyperelastic material. Each particle is gathered by itself, so that its bits do not
depend on the others of the four.
"""

from typing import NamedTuple

from pgimp.jit.algebra import determinant, one_plus, symmetric
from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.tuples import plus_scaled
from pgimp.jit.vectors.lanes import vectors
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.arguments import FourParticles
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.transfer.gather_shared import take_from_grid
from pgimp.kernels.transfer.lane_io import LANES, coordinates, four_rows, put, put_row, take
from pgimp.kernels.transfer.rings import ring_motion
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, supports
from pgimp.kernels.transfer.transpose import SUMS
from pgimp.kernels.update.stress import materials_of
from pgimp.physics.materials.parameters.evaluate import evaluate_four


class Displaced(NamedTuple):
    """The columns that `displace_particles` sets, see `Particles`: the particles' or others."""

    x: FloatArray
    v: FloatArray
    F: FloatArray
    sigma: FloatArray
    V: FloatArray


@kernel
def displace_particles(setting, plain, field, particles, order, displaced, to):
    """Set position, velocity, deformation gradient, volume and stress of particles.

    Parameters
    ----------
    setting, particles, order
        See `KernelScene`, `Particles`, `Order`; the materials are hyperelastic. Without materials
        only positions and velocities are set.
    plain : Frame
        The frame of the current configuration.
    field : Field
        With the records of the vertices' motion in place of `G`.
    displaced : Displaced
        Set.
    to : (n,) int32
        The rows there of the particles in their order.
    """
    shape, frame, window, start = setting.shape, setting.frame, field.window, order.start
    buffer, sums = stack(SUPPORT_SIZE), stack(SUMS)
    for layer in range(len(start) - 1):
        number = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            four = FourParticles(rows, min(LANES, start[layer + 1] - k), k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            u, v, grad, _, hoop = take_from_grid((shape, plain), field, (), four, buffer, sums)
            u = ring_motion(frame, particles, four, hoop, u)
            x = plus_scaled(1.0, u, coordinates(frame, particles, rows))
            places = four_rows(to, k, start[layer + 1])
            put_row(displaced.x, places, 0, x)
            put_row(displaced.v, places, 0, v)
            _put_elastic(setting, particles, rows, grad, displaced, places)


@kernel
def place_particles(setting, plain, field, particles, order):
    """Set only positions and deformation gradients, as `displace_particles` does."""
    shape, frame, window, start = setting.shape, setting.frame, field.window, order.start
    buffer, sums = stack(SUPPORT_SIZE), stack(SUMS)
    for layer in range(len(start) - 1):
        number = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            four = FourParticles(rows, min(LANES, start[layer + 1] - k), k, layer, number)
            supports(shape, frame, window, particles, rows, number, buffer, ())
            u, _, grad, _, hoop = take_from_grid((shape, plain), field, (), four, buffer, sums)
            u = ring_motion(frame, particles, four, hoop, u)
            put_row(particles.x, rows, 0, plus_scaled(1.0, u, coordinates(frame, particles, rows)))
            put_row(particles.F, rows, 0, one_plus(1.0, grad))


@inlined
def _put_elastic(setting, particles, rows, grad, displaced, places):
    """Set F, V and stress of four elastic particles; nothing without materials.

    `grad` is their displacement gradients.
    """
    if len(setting.materials) == 0:
        return None
    F = one_plus(1.0, grad)
    J = determinant(F)
    m = materials_of(setting.material_of, particles.body, rows)
    unused = vectors(symmetric(grad))
    sigma = evaluate_four("stress", setting.materials, m, (F, J, unused, grad, 0.0), (), unused)
    put_row(displaced.F, places, 0, F)
    put_row(displaced.sigma, places, 0, sigma)
    if setting.tracked:
        put(displaced.V, places, J * take(particles.V0, rows))
