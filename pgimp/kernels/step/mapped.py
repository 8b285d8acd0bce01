"""New velocities of particles, mapped to the vertices again: momenta, as sums of their own.

For orders of phases, see `pgimp.solver.phases.orders`. While the particles of a layer are summed,
each gathers its acceleration, and gives the vertices its momentum after it. The velocity gradient
that it carries (`affine`) is the new one too, at the step's beginning.
"""

from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import plus_scaled, read, scaled, three
from pgimp.jit.vectors.simd import pack, stack, vector
from pgimp.kernels.data.arguments import Field, FourParticles
from pgimp.kernels.loads.loads import relaxed
from pgimp.kernels.transfer.gather_shared import take_from_grid
from pgimp.kernels.transfer.lane_io import LANES, put_row, take_row
from pgimp.kernels.transfer.scatter import Share
from pgimp.kernels.transfer.supports import supports
from pgimp.kernels.transfer.transpose import SUMS
from pgimp.kernels.update.affine import affine_momentum, keep_gradients, when_moved
from pgimp.kernels.update.phases import weight_power
from pgimp.physics.shapes.base import by_corners, by_parts


class Carriers(NamedTuple):
    """Masses and velocity gradients of particles, for `affine_momentum`."""

    m: np.ndarray
    L: np.ndarray


class MappedMomentum(NamedTuple):
    """Momentum of particles after a step, a `Quantity`; their velocities are kept in `v`."""

    field: Field  #: With the vertices' velocities and accelerations, after all conditions.
    dt: float
    relaxation: Any  #: float or (): See `Loads`.
    affine: Any  #: float or (): See `Loads`.
    v: np.ndarray  #: (capacity, D) float64: Set to the velocities.
    #: (capacity, D*D) float64: With `affine` set to their gradients. Those of the particles are set
    #: to them as moved.
    L: np.ndarray
    gravity: tuple[float, float, float]  #: See `Forcing`.
    #: (planes,) float64: The work of loads. That of gravity by the vertices' velocities is taken
    #: back: particles move by others.
    work: np.ndarray

    @staticmethod
    def supports(quantity, shape, frame, window, particles, rows, layer, buffer):
        """See `Quantity`; accelerates the four particles."""
        dt, affine = quantity.dt, quantity.affine
        supports(shape, frame, window, particles, rows, layer, buffer, affine)
        four = FourParticles(rows, LANES, 0, layer - window.lower[0], layer)
        u, a, grad, held, _ = take_from_grid(
            (shape, frame), quantity.field, (), four, buffer, stack(SUMS)
        )
        count = 1 + (rows[1] != rows[0]) + (rows[2] != rows[1]) + (rows[3] != rows[2])
        power = weight_power(quantity.gravity, particles, rows, count, u, 0.0)
        quantity.work[four.layer] -= dt * power
        v = plus_scaled(dt, a, take_row(particles.v, rows, 0, u))
        put_row(quantity.v, rows, 0, relaxed(quantity.relaxation, dt, v, u))
        keep_gradients(affine, quantity, rows, grad, held)
        keep_gradients(affine, particles, rows, when_moved(affine, dt, grad), held)

    @staticmethod
    def share(quantity, shape, frame, particles, p):
        """See `Quantity`: mass and momentum."""
        m = particles.m[p]
        A = pack(m, *three(scaled(m, read(quantity.v, p, 0, frame.origin))))
        C = affine_momentum(quantity.affine, frame, Carriers(particles.m, quantity.L), p)
        return Share(A, (), _no_force(shape, frame.origin), C, (), ())


@inlined
def _no_force(shape, like):
    """No force along each direction: as () where weights are products by direction."""
    if by_corners(shape) or by_parts(shape):
        return tuple(vector(0.0) for _ in range(len(like)))
    return tuple(() for _ in range(len(like)))
