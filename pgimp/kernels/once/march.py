"""A material driven through steps, without a grid, as by a run's kernels."""

from math import isqrt

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.vectors.lanes import of_lane
from pgimp.kernels.transfer.lane_io import put_row, take_row
from pgimp.physics.materials.parameters.evaluate import evaluate_four


@inlined
def ask(materials, F, J, L, dt, found, rows, like):
    """Stress and state of four particles after a step, and their wave speed.

    `found` has stress and state of each in a row, `rows` the offsets; `like` has their length.
    """
    components = (3, 4, 6)[isqrt(len(F)) - 1]
    if len(like) > components:
        before = take_row(found, rows, 0, like)
        sigma, state = before[:components], before[components:]
        after = evaluate_four("stress", materials, rows, (F, J, sigma, L, dt), state, before)
        return after, evaluate_four("speed", materials, rows, (F, J), after[components:], J)
    sigma = take_row(found, rows, 0, like)
    after = evaluate_four("stress", materials, rows, (F, J, sigma, L, dt), (), sigma)
    return after, evaluate_four("speed", materials, rows, (F, J), (), J)


@kernel
def march(materials, F, L, dt, found, speed, matrix, like):
    """Drive a material through steps, as a run's kernels would.

    Parameters
    ----------
    materials : tuple of one NamedTuple
        The material.
    F, L : (n, D*D) float64
        Deformation gradients at the end of each step, and the steps' velocity gradients.
    dt : (n,) float64
        Lengths of the steps.
    found : (n + 1, columns) float64
        Stress and state: the first row before the first step; the others are filled.
    speed : (n,) float64
        Speed of the fastest wave after each step; filled.
    matrix, like : tuple of float
        As long as a row of F, of `found`.
    """
    rows = (0, 0, 0, 0)
    for k in range(len(F)):
        f = take_row(F, (k, k, k, k), 0, matrix)
        velocity = take_row(L, (k, k, k, k), 0, matrix)
        after, c = ask(materials, f, determinant(f), velocity, dt[k], found[k : k + 1], rows, like)
        put_row(found, (k + 1, k + 1, k + 1, k + 1), 0, after)
        speed[k] = of_lane(c, 0)
