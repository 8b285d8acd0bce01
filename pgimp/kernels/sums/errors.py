"""Exact solutions on particles: initial velocities, and errors of their state."""

from math import sqrt

from pgimp.jit.algebra import contract, symmetric
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import plus_scaled, read, squared, write
from pgimp.physics.exact.base import state

#: Columns of `layer_errors`.
DISPLACEMENT, VELOCITY, STRESS, VOLUME, STRESS_VOLUME, ERRORS = 0, 1, 2, 3, 4, 5


@kernel
def layer_errors(solution, t, follows, setting, particles, order, sums, most):
    """Add up errors in displacement, velocity and stress, layer by layer in canonical order.

    Parameters
    ----------
    solution : NamedTuple
        The exact solution, see `pgimp.physics.exact`.
    follows : bool
        Whether the particles' size follows the deformation, so that (47) takes the current one.
    setting, particles, order
        See `KernelScene`, `Particles`, `Order`.
    sums : (layers, 5) float64
        Zero on entry: initial volume times the squared errors, initial volume, and the error in
        stress times volume (47).
    most : (layers, 5) float64
        Zero on entry: greatest errors, in the first three columns.
    """
    frame, like, start = setting.frame, setting.identity, order.start
    for layer in range(len(start) - 1):
        row, top = sums[layer], most[layer]
        for k in range(start[layer], start[layer + 1]):
            p = order.rows[k]
            X = read(particles.origin, p, 0, frame.origin)
            x = read(particles.x, p, 0, frame.origin)
            u, v, sigma = state(solution, X, x, t)
            du = squared(plus_scaled(-1.0, u, plus_scaled(-1.0, X, x)))
            dv = squared(plus_scaled(-1.0, v, read(particles.v, p, 0, frame.origin)))
            S = plus_scaled(-1.0, sigma, read(particles.sigma, p, 0, symmetric(like)))
            ds = contract(S, S)
            V0 = particles.V0[p]
            row[DISPLACEMENT] += V0 * du
            row[VELOCITY] += V0 * dv
            row[STRESS] += V0 * ds
            row[VOLUME] += V0
            row[STRESS_VOLUME] += sqrt(ds) * (particles.V[p] if follows else V0)
            top[DISPLACEMENT] = max(top[DISPLACEMENT], sqrt(du))
            top[VELOCITY] = max(top[VELOCITY], sqrt(dv))
            top[STRESS] = max(top[STRESS], sqrt(ds))


@kernel
def initial_velocities(solution, frame, x, v):
    """Set `v` (n, D) to the exact velocities at `x` (n, D) and time 0."""
    for p in range(len(x)):
        X = read(x, p, 0, frame.origin)
        write(v, p, 0, state(solution, X, X, 0.0)[1])
