"""Functions of small symmetric tensors by series in the tensor itself, without a branch.

As `exponential` and `logarithm` of `pgimp.jit.spectral`, for elastic strains and for deformations
by them. They need no eigenvectors, cost a quarter and lose no digits of small tensors. Tensors are
tuples as in `pgimp.jit.algebra`, of numbers or of vectors; both have the same bits. Powers above
the second follow from the first two (Cayley-Hamilton).
"""

from math import factorial

from pgimp.jit.functions import fma
from pgimp.jit.kernel import exact

#: Terms of the series. In x^k of exp, to 1e-16 for |x| < 0.4 and 1e-11 for |x| < 1. In z^(2k+1) of
#: 2 artanh, to 1e-16 for |z| < 0.16 and 1e-9 for |z| < 0.4.
_EXP_TERMS, _LOG_TERMS = 14, 10
_EXP = tuple(1.0 / factorial(k) for k in range(_EXP_TERMS))
_LOG = tuple(2.0 / (2 * k + 1) for k in range(_LOG_TERMS))


@exact
def square(S):
    """The symmetric tensor S S."""
    if len(S) == 3:
        return S[0] * S[0], S[1] * S[1], S[2] * S[2]
    if len(S) == 4:
        c = S[3] * S[3]
        return fma(S[0], S[0], c), fma(S[1], S[1], c), S[2] * S[2], (S[0] + S[1]) * S[3]
    xx, yy, zz, xy, yz, xz = S
    a, b, c = xy * xy, yz * yz, xz * xz
    return (
        fma(xx, xx, a + c),
        fma(yy, yy, a + b),
        fma(zz, zz, b + c),
        fma(xx + yy, xy, yz * xz),
        fma(yy + zz, yz, xy * xz),
        fma(xx + zz, xz, xy * yz),
    )


@exact
def product(S, T):
    """The product S T of symmetric tensors with common eigenvectors, which is symmetric too."""
    if len(S) == 3:
        return S[0] * T[0], S[1] * T[1], S[2] * T[2]
    if len(S) == 4:
        c = S[3] * T[3]
        return fma(S[0], T[0], c), fma(S[1], T[1], c), S[2] * T[2], fma(S[0], T[3], S[3] * T[1])
    a, b, c = S[3] * T[3], S[4] * T[4], S[5] * T[5]
    return (
        fma(S[0], T[0], a + c),
        fma(S[1], T[1], a + b),
        fma(S[2], T[2], b + c),
        fma(S[0], T[3], fma(S[3], T[1], S[5] * T[4])),
        fma(S[3], T[5], fma(S[1], T[4], S[4] * T[2])),
        fma(S[0], T[5], fma(S[3], T[4], S[5] * T[2])),
    )


@exact
def invariants(S):
    """The principal invariants of a symmetric tensor: trace, second, determinant."""
    if len(S) == 3:
        both = S[0] + S[1]
        return both + S[2], fma(both, S[2], S[0] * S[1]), S[0] * S[1] * S[2]
    if len(S) == 4:
        both, minor = S[0] + S[1], fma(-S[3], S[3], S[0] * S[1])
        return both + S[2], fma(both, S[2], minor), minor * S[2]
    xx, yy, zz, xy, yz, xz = S
    x = fma(-yz, yz, yy * zz)
    y = fma(-xz, xz, xx * zz)
    z = fma(-xy, xy, xx * yy)
    off = fma(xy, fma(yz, xz, -zz * xy), xz * fma(xy, yz, -yy * xz))
    return xx + yy + zz, x + y + z, fma(xx, x, off)


@exact
def inverse_symmetric(S):
    """Inverse of a nonsingular symmetric tensor."""
    if len(S) == 3:
        return 1.0 / S[0], 1.0 / S[1], 1.0 / S[2]
    if len(S) == 4:
        r = 1.0 / fma(-S[3], S[3], S[0] * S[1])
        return S[1] * r, S[0] * r, 1.0 / S[2], -S[3] * r
    xx, yy, zz, xy, yz, xz = S
    x = fma(-yz, yz, yy * zz)
    a = fma(yz, xz, -zz * xy)
    b = fma(xy, yz, -yy * xz)
    r = 1.0 / fma(xx, x, fma(xy, a, xz * b))
    return (
        x * r,
        fma(-xz, xz, xx * zz) * r,
        fma(-xy, xy, xx * yy) * r,
        a * r,
        fma(xy, xz, -xx * yz) * r,
        b * r,
    )


@exact
def combine(P, S, T):
    """The symmetric tensor P[0] 1 + P[1] S + P[2] T."""
    return tuple(
        fma(P[2], T[k], fma(P[1], S[k], P[0]) if k < 3 else P[1] * S[k]) for k in range(len(S))
    )


@exact
def _series(found, P, coefficients):
    """Horner's rule for a polynomial of a tensor X with known invariants.

    P are the coefficients found so far, in 1, X and X^2; X^3 is
    I1 X^2 - I2 X + I3.
    """
    for each in coefficients:
        p, q, r = P
        P = fma(r, found[2], each), fma(-r, found[1], p), fma(r, found[0], q)
    return P


_EXP_BACK = (*reversed(_EXP[1:-3]), 0.0)
_LOG_BACK = tuple(reversed(_LOG[:-3]))


@exact
def series_expm1(S):
    """The symmetric tensor e^S - 1 by its series, to 1e-15 for eigenvalues up to 0.4 in size."""
    begin = _EXP[-3:]
    return combine(_series(invariants(S), begin, _EXP_BACK), S, square(S))


@exact
def series_log1p(S):
    """The symmetric tensor ln(1 + S) by a series.

    The series is 2 artanh z, z = S (2 + S)^-1. Its relative error is 1e-15 for eigenvalues of 1 + S
    between 0.7 and 1.4, 1e-9 between 0.45 and 2.2. Beyond, it changes more slowly than ln.
    """
    begin = _LOG[-3:]
    more = combine((2.0, 1.0, 0.0), S, S)
    Z = product(S, inverse_symmetric(more))
    W = square(Z)
    p, q, r = _series(invariants(W), begin, _LOG_BACK)
    # Z (p + q Z^2 + r Z^4), by Z^3 = a Z^2 - b Z + c
    a, b, c = invariants(Z)
    x, y, z = r * a * c, fma(-r * a, b, r * c), fma(r * a, a, fma(-r, b, q))
    return combine((z * c, fma(-z, b, x + p), fma(z, a, y)), Z, W)


@exact
def carry(A, S):
    """The symmetric tensor (1 + A)(1 + S)(1 + A)^T - 1, of a matrix A; small if both are."""
    if len(A) == 5:
        x, y, _, xy = carry(A[:4], S)
        return x, y, fma(A[4] * (2.0 + A[4]), 1.0 + S[2], S[2]), xy
    if len(S) == 3:
        return fma(A[0] * (2.0 + A[0]), 1.0 + S[0], S[0]), S[1], S[2]
    if len(S) == 4:
        a, b, c, d = A
        p, q = fma(a, S[0], fma(b, S[3], a)), fma(a, S[3], fma(b, S[1], b))  # A (1 + S)
        r, s = fma(c, S[0], fma(d, S[3], c)), fma(c, S[3], fma(d, S[1], d))
        return (
            S[0] + fma(p, a, fma(q, b, 2.0 * p)),
            S[1] + fma(r, c, fma(s, d, 2.0 * s)),
            S[2],
            S[3] + fma(p, c, fma(q, d, q + r)),
        )
    xx, yy, zz, xy, yz, xz = S
    a, b, c, d, e, f, g, h, i = A
    # A (1 + S), row by row
    ax, ay, az = _row(a, b, c, S)
    dx, dy, dz = _row(d, e, f, S)
    gx, gy, gz = _row(g, h, i, S)
    return (
        xx + fma(ax, a, fma(ay, b, fma(az, c, 2.0 * ax))),
        yy + fma(dx, d, fma(dy, e, fma(dz, f, 2.0 * dy))),
        zz + fma(gx, g, fma(gy, h, fma(gz, i, 2.0 * gz))),
        xy + fma(ax, d, fma(ay, e, fma(az, f, ay + dx))),
        yz + fma(dx, g, fma(dy, h, fma(dz, i, dz + gy))),
        xz + fma(ax, g, fma(ay, h, fma(az, i, az + gx))),
    )


@exact
def _row(a, b, c, S):
    """The row (a, b, c) times 1 + S."""
    return (
        fma(a, S[0], fma(b, S[3], fma(c, S[5], a))),
        fma(a, S[3], fma(b, S[1], fma(c, S[4], b))),
        fma(a, S[5], fma(b, S[4], fma(c, S[2], c))),
    )
