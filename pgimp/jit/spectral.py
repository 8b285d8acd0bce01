"""Functions of symmetric tensors by their eigenvalues, without a branch.

Tensors are tuples as in `pgimp.jit.algebra`, of numbers or of vectors; both have the same bits. For
small tensors `pgimp.jit.series` costs a quarter.
"""

from math import sqrt

from pgimp.jit.choose import choose
from pgimp.jit.functions import exp, fma, log
from pgimp.jit.kernel import exact

_TINY = 1e-300


@exact
def _angle(p, q, r):
    """Cosine and tangent of the rotation that diagonalises ((p, r), (r, q))."""
    d = q - p
    twice = 2.0 * r
    sign = choose(d < 0.0, -1.0, 1.0)
    t = twice * sign / (abs(d) + sqrt(fma(d, d, twice * twice)) + _TINY)
    return 1.0 / sqrt(fma(t, t, 1.0)), t


@exact
def _turn(c, t, a, b):
    """Components along two axes after their rotation by an angle of cosine c and tangent t."""
    return (c * fma(-t, b, a), c * fma(t, a, b))


@exact
def _sweep(S, Q):
    """One sweep of Jacobi's method: S = J^T S J and Q = Q J, by rotations in xy, xz and yz."""
    xx, yy, zz, xy, yz, xz = S
    c, t = _angle(xx, yy, xy)
    xx, yy = fma(-t, xy, xx), fma(t, xy, yy)
    xz, yz = _turn(c, t, xz, yz)
    a0, b0 = _turn(c, t, Q[0], Q[1])
    a1, b1 = _turn(c, t, Q[3], Q[4])
    a2, b2 = _turn(c, t, Q[6], Q[7])
    c, t = _angle(xx, zz, xz)
    xx, zz = fma(-t, xz, xx), fma(t, xz, zz)
    xy, yz = _turn(c, t, 0.0, yz)
    a0, c0 = _turn(c, t, a0, Q[2])
    a1, c1 = _turn(c, t, a1, Q[5])
    a2, c2 = _turn(c, t, a2, Q[8])
    c, t = _angle(yy, zz, yz)
    yy, zz = fma(-t, yz, yy), fma(t, yz, zz)
    xy, xz = _turn(c, t, xy, 0.0)
    b0, c0 = _turn(c, t, b0, c0)
    b1, c1 = _turn(c, t, b1, c1)
    b2, c2 = _turn(c, t, b2, c2)
    return (xx, yy, zz, xy, 0.0, xz), (a0, b0, c0, a1, b1, c1, a2, b2, c2)


@exact
def eigen(S):
    """Eigenvalues and eigenvectors of a symmetric tensor, in no order.

    Four sweeps of Jacobi's method leave 1e-16 of the tensor's size, for distant, nearly equal or
    equal eigenvalues; in plane strain one rotation.

    Parameters
    ----------
    S : tuple
        A symmetric tensor.

    Returns
    -------
    values : tuple of 3
        Eigenvalues; in 2D the last belongs to zz, in 1D they are the components.
    Q : tuple
        The matrix whose columns are the eigenvectors, for `spectral`.
    """
    if len(S) == 3:
        return S, (1.0,)
    if len(S) == 4:
        c, t = _angle(S[0], S[1], S[3])
        s = t * c
        return (fma(-t, S[3], S[0]), fma(t, S[3], S[1]), S[2]), (c, s, -s, c)
    A, one = _sweep(S, (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    B, two = _sweep(A, one)
    C, three = _sweep(B, two)
    D, four = _sweep(C, three)
    return (D[0], D[1], D[2]), four


@exact
def spectral(values, Q):
    """The symmetric tensor with these eigenvalues and eigenvectors, as `eigen` gives them."""
    if len(Q) == 1:
        return values
    if len(Q) == 4:
        a, b, c = values
        return (
            fma(a * Q[0], Q[0], b * Q[1] * Q[1]),
            fma(a * Q[2], Q[2], b * Q[3] * Q[3]),
            c,
            fma(a * Q[0], Q[2], b * Q[1] * Q[3]),
        )
    a, b, c = values
    x0, x1, x2 = a * Q[0], b * Q[1], c * Q[2]
    y0, y1, y2 = a * Q[3], b * Q[4], c * Q[5]
    z0, z1, z2 = a * Q[6], b * Q[7], c * Q[8]
    return (
        fma(x0, Q[0], fma(x1, Q[1], x2 * Q[2])),
        fma(y0, Q[3], fma(y1, Q[4], y2 * Q[5])),
        fma(z0, Q[6], fma(z1, Q[7], z2 * Q[8])),
        fma(x0, Q[3], fma(x1, Q[4], x2 * Q[5])),
        fma(y0, Q[6], fma(y1, Q[7], y2 * Q[8])),
        fma(x0, Q[6], fma(x1, Q[7], x2 * Q[8])),
    )


@exact
def exponential(S):
    """The symmetric tensor e^S."""
    values, Q = eigen(S)
    return spectral((exp(values[0]), exp(values[1]), exp(values[2])), Q)


@exact
def logarithm(S):
    """The symmetric tensor ln S; NaN where an eigenvalue is not positive."""
    values, Q = eigen(S)
    return spectral((log(values[0]), log(values[1]), log(values[2])), Q)
