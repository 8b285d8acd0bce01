"""Change of the rotation R of F = V R in a step, for Green and Naghdi's rate."""

from math import isqrt, sqrt

from pgimp.jit.algebra import (
    inverse,
    left_cauchy_green,
    multiply,
    one_plus,
    rotate,
    skew,
    symmetric,
)
from pgimp.jit.kernel import inlined
from pgimp.jit.spectral import eigen


@inlined
def polar_rotation(F, L, dt):
    """Increment of R, the polar rotation of F, in a step.

    In 2D it is exactly R R_before^T. In 3D it follows from the spin at the mid-point: second order
    in the step, and exact for a rotation without strain. In the basis of V's eigenvectors,
    Omega_ij = W_ij + D_ij (v_j - v_i)/(v_i + v_j), and Q = (1 - dt/2 Omega)^-1 (1 + dt/2 Omega).
    """
    if isqrt(len(F)) == 1:
        return (1.0,)
    if isqrt(len(F)) == 2:
        B = multiply(inverse(one_plus(dt, L)), F)
        c, s = F[0] + F[3], F[2] - F[1]
        before_c, before_s = B[0] + B[3], B[2] - B[1]
        cosine, sine = c * before_c + s * before_s, s * before_c - c * before_s
        r = 1.0 / sqrt(cosine * cosine + sine * sine)
        return cosine * r, -sine * r, sine * r, cosine * r
    half = one_plus(0.5 * dt, L)
    G = multiply(L, inverse(half))
    middle = multiply(half, multiply(inverse(one_plus(dt, L)), F))
    squares, Q = eigen(left_cauchy_green(middle))
    v = sqrt(squares[0]), sqrt(squares[1]), sqrt(squares[2])
    D = rotate((Q[0], Q[3], Q[6], Q[1], Q[4], Q[7], Q[2], Q[5], Q[8]), symmetric(G))
    xy = D[3] * (v[1] - v[0]) / (v[0] + v[1])
    yz = D[4] * (v[2] - v[1]) / (v[1] + v[2])
    xz = D[5] * (v[2] - v[0]) / (v[0] + v[2])
    # The skew tensor's axis (yz, -xz, xy) turns as a vector does.
    x, y, z = yz, -xz, xy
    W = skew(G)
    a = W[5] + Q[0] * x + Q[1] * y + Q[2] * z
    b = -W[2] + Q[3] * x + Q[4] * y + Q[5] * z
    c = W[1] + Q[6] * x + Q[7] * y + Q[8] * z
    spin = (0.0, c, -b, -c, 0.0, a, b, -a, 0.0)
    return multiply(inverse(one_plus(-0.5 * dt, spin)), one_plus(0.5 * dt, spin))
