"""Small matrices and symmetric tensors as tuples, specialised on their length at compile time.

A matrix (F, the velocity gradient, a rotation) is a row-major tuple of D*D numbers. Where the
direction out of the plane stretches, as in axisymmetry, a matrix in 2D has its zz as fifth number.
A symmetric tensor (stress, left Cauchy-Green) is (xx, yy, zz) in 1D, with xy in 2D, with yz and xz
in 3D. Each is a prefix of the next, so that zz is always there.
"""

from math import isqrt

from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import on_diagonal, scaled

#: Rows and columns of a symmetric tensor's components.
_COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


@inlined
def determinant(A):
    """Determinant of a matrix; in 2D without zz of its plane-strain extension."""
    if len(A) == 1:
        return A[0]
    if len(A) == 4:
        return A[0] * A[3] - A[1] * A[2]
    if len(A) == 5:
        return (A[0] * A[3] - A[1] * A[2]) * A[4]
    return (
        A[0] * (A[4] * A[8] - A[5] * A[7])
        - A[1] * (A[3] * A[8] - A[5] * A[6])
        + A[2] * (A[3] * A[7] - A[4] * A[6])
    )


@inlined
def multiply(A, B):
    """Matrix product A B."""
    if len(A) == 5:
        return (*multiply(A[:4], B[:4]), A[4] * B[4])
    D = isqrt(len(A))
    return tuple(
        sum(A[D * i + k] * B[D * k + j] for k in range(D)) for i in range(D) for j in range(D)
    )


@inlined
def _products(A, B, rest):
    """The tensor A B^T where it is symmetric; `rest` in the directions that a scene has not."""
    D = isqrt(len(A))
    return tuple(
        sum(A[D * i + k] * B[D * j + k] for k in range(D)) if j < D else rest
        for i, j in _COMPONENTS[: (3, 4, 6)[D - 1]]
    )


@inlined
def inverse(A):
    """Inverse of a nonsingular matrix."""
    if len(A) == 1:
        return (1.0 / A[0],)
    if len(A) == 4:
        r = 1.0 / (A[0] * A[3] - A[1] * A[2])
        return (A[3] * r, -A[1] * r, -A[2] * r, A[0] * r)
    if len(A) == 5:
        return (*inverse(A[:4]), 1.0 / A[4])
    c0 = A[4] * A[8] - A[5] * A[7]
    c1 = A[5] * A[6] - A[3] * A[8]
    c2 = A[3] * A[7] - A[4] * A[6]
    r = 1.0 / (A[0] * c0 + A[1] * c1 + A[2] * c2)
    return (
        c0 * r,
        (A[2] * A[7] - A[1] * A[8]) * r,
        (A[1] * A[5] - A[2] * A[4]) * r,
        c1 * r,
        (A[0] * A[8] - A[2] * A[6]) * r,
        (A[2] * A[3] - A[0] * A[5]) * r,
        c2 * r,
        (A[1] * A[6] - A[0] * A[7]) * r,
        (A[0] * A[4] - A[1] * A[3]) * r,
    )


@inlined
def cofactor(A):
    """Cofactor matrix det(A) A^-T; in 2D of the plane-strain extension, except its zz."""
    if len(A) == 1:
        return (1.0,)
    if len(A) == 4:
        return (A[3], -A[2], -A[1], A[0])
    if len(A) == 5:
        return (*scaled(A[4], cofactor(A[:4])), A[0] * A[3] - A[1] * A[2])
    return (
        A[4] * A[8] - A[5] * A[7], A[5] * A[6] - A[3] * A[8], A[3] * A[7] - A[4] * A[6],
        A[2] * A[7] - A[1] * A[8], A[0] * A[8] - A[2] * A[6], A[1] * A[6] - A[0] * A[7],
        A[1] * A[5] - A[2] * A[4], A[2] * A[3] - A[0] * A[5], A[0] * A[4] - A[1] * A[3],
    )  # fmt: skip


@inlined
def full(S):
    """The matrix, row-major, of a symmetric tensor, in the directions of the scene."""
    if len(S) == 3:
        return (S[0],)
    if len(S) == 4:
        return (S[0], S[3], S[3], S[1])
    return (S[0], S[3], S[5], S[3], S[1], S[4], S[5], S[4], S[2])


@inlined
def plus_diagonal(A, e):
    """The matrix A + e 1."""
    return tuple(a + e if on_diagonal(k, A) else a for k, a in enumerate(A))


@inlined
def one_plus(c, A):
    """The matrix 1 + c A."""
    return plus_diagonal(scaled(c, A), 1.0)


@inlined
def trace(A):
    """Trace of a matrix."""
    return sum(a for k, a in enumerate(A) if on_diagonal(k, A))


@inlined
def skew(A):
    """Skew part (A - A^T)/2 of a matrix."""
    if len(A) == 1:
        return (0.0,)
    if len(A) == 4:
        return (0.0, 0.5 * (A[1] - A[2]), -(0.5 * (A[1] - A[2])), 0.0)
    if len(A) == 5:
        return (*skew(A[:4]), 0.0)
    xy, xz, yz = 0.5 * (A[1] - A[3]), 0.5 * (A[2] - A[6]), 0.5 * (A[5] - A[7])
    return (0.0, xy, xz, -xy, 0.0, yz, -xz, -yz, 0.0)


@inlined
def symmetric(A):
    """Symmetric part (A + A^T)/2 of a matrix, as a symmetric tensor."""
    if len(A) == 1:
        return (A[0], 0.0, 0.0)
    if len(A) == 4:
        return (A[0], A[3], 0.0, 0.5 * (A[1] + A[2]))
    if len(A) == 5:
        return (A[0], A[3], A[4], 0.5 * (A[1] + A[2]))
    return (
        A[0], A[4], A[8], 0.5 * (A[1] + A[3]), 0.5 * (A[5] + A[7]), 0.5 * (A[2] + A[6]),
    )  # fmt: skip


@inlined
def left_cauchy_green(F):
    """The symmetric tensor b = F F^T; missing directions of a scene are not stretched."""
    if len(F) == 5:
        b = left_cauchy_green(F[:4])
        return (b[0], b[1], F[4] * F[4], b[3])
    return _products(F, F, 1.0)


@inlined
def isotropic(a, S, c):
    """The symmetric tensor a S + c 1."""
    return tuple(a * each + c for each in S[:3]) + scaled(a, S[3:])


@inlined
def add(A, B):
    """Sum of two tuples of equal length."""
    return tuple(a + b for a, b in zip(A, B, strict=True))


@inlined
def contract(S, T):
    """Double contraction S : T of two symmetric tensors."""
    if len(S) == 3:
        return S[0] * T[0] + S[1] * T[1] + S[2] * T[2]
    if len(S) == 4:
        return S[0] * T[0] + S[1] * T[1] + S[2] * T[2] + 2.0 * S[3] * T[3]
    return S[0] * T[0] + S[1] * T[1] + S[2] * T[2] + 2.0 * (S[3] * T[3] + S[4] * T[4] + S[5] * T[5])


@inlined
def rotate(Q, S):
    """The symmetric tensor Q S Q^T."""
    if len(S) == 3:
        return S
    if len(S) == 4:
        return _products(multiply(Q[:4], full(S)), Q, S[2])
    return _products(multiply(Q, full(S)), Q, 0.0)


@inlined
def largest_stretch_squared(b):
    """Bound of the largest eigenvalue of b (largest row sum); exact when b is diagonal."""
    if len(b) == 3:
        return b[0]
    if len(b) == 4:
        return max(b[0], b[1]) + abs(b[3])
    return max(
        max(b[0] + abs(b[3]) + abs(b[5]), b[1] + abs(b[3]) + abs(b[4])),
        b[2] + abs(b[4]) + abs(b[5]),
    )
