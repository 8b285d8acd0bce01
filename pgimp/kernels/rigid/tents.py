"""Parts of products of tents that planes cut off."""

from math import sqrt

from pgimp.jit.kernel import inner_kernel

#: Points and weights that integrate, over a tent from -1 to 1, polynomials up to the third degree
#: on either side: Gauss-Jacobi with two points.
_POSITIONS = (
    -(4.0 + sqrt(6.0)) / 10.0,
    -(4.0 - sqrt(6.0)) / 10.0,
    (4.0 - sqrt(6.0)) / 10.0,
    (4.0 + sqrt(6.0)) / 10.0,
)
_OUTER, _INNER = 0.25 - 1.0 / (6.0 * sqrt(6.0)), 0.25 + 1.0 / (6.0 * sqrt(6.0))
_WEIGHTS = (_OUTER, _INNER, _INNER, _OUTER)


@inner_kernel
def _below(u):
    """Part of a tent from -1 to 1 below u."""
    if u <= 0.0:
        return 0.5 * max(0.0, 1.0 + u) ** 2
    return 1.0 - 0.5 * max(0.0, 1.0 - u) ** 2


@inner_kernel
def cut(a, b, c, s):
    """Part of a box of tents with n . x < s, and its derivative by s; a, b, c are |n_d| half sides.

    `a` is the greatest.
    """
    part, slope = 0.0, 0.0
    for i in range(4 if b > 1e-12 * a else 1):
        w, x = (_WEIGHTS[i], b * _POSITIONS[i]) if b > 1e-12 * a else (1.0, 0.0)
        for k in range(4 if c > 1e-12 * a else 1):
            v, y = (_WEIGHTS[k], c * _POSITIONS[k]) if c > 1e-12 * a else (1.0, 0.0)
            u = (s - x - y) / a
            part += w * v * _below(u)
            slope += w * v * max(0.0, 1.0 - abs(u)) / a
    return part, slope
