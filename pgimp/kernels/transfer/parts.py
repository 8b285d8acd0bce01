"""Weights of parts of cells: means of the cell's multilinear functions over a part.

A vertex has N = n_x n_y n_z, with n = 1 - t or t along each direction. About the part's centroid
each n is linear, with the slope g = -1/h or 1/h. So the mean of N over the part is exact with the
means of products of the distances from the centroid, c_xy, c_yz, c_xz, c_xyz:

    n_x n_y n_z + n_x g_y g_z c_yz + n_y g_x g_z c_xz + n_z g_x g_y c_xy + g_x g_y g_z c_xyz,
    dN/dx: g_x (n_y n_z + g_y g_z c_yz).

The sum of V_p dN_p/dx over a body is then the integral of N n over its surface, wherever that cuts
cells. Whoever needs the weights of a particle calls `corner_weights`.
"""

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled, read
from pgimp.jit.vectors.simd import load, number, store, vector
from pgimp.kernels.transfer.lane_io import take_row
from pgimp.physics.shapes.base import by_parts

#: Where a buffer for supports has the products of four parts: in the place of arms along x.
_PRODUCTS = 32


@inlined
def zero_products(D):
    """Zeros, as many as a part has products of inertia."""
    if D == 3:
        return (0.0, 0.0, 0.0, 0.0)
    if D == 2:
        return (0.0,)
    return ()


@inlined
def product_count(D):
    """Number of a part's products of inertia."""
    return (0, 1, 4)[D - 1]


@inlined
def keep_products(shape, frame, particles, rows, buffer):
    """Store the products of inertia of four particles in a buffer; nothing for other shapes."""
    if by_parts(shape):
        _keep(buffer, _PRODUCTS, take_products(particles.products, rows, len(frame.origin)))


@inlined
def take_products(products, rows, D):
    """Products of inertia of four rows, vectors."""
    if D == 1:
        return ()
    return take_row(products, rows, 0, zero_products(D))


@inlined
def read_products(products, p, number, D):
    """Products of inertia of a part, from those of several in a row."""
    if D == 1:
        return ()
    return read(products, p, number, zero_products(D))


@inlined
def _keep(buffer, at, V):
    """Store vectors in a buffer, one after the other."""
    if len(V) == 0:
        return None
    store(buffer, at, V[0])
    _keep(buffer, at + 4, V[1:])


@inlined
def keep_own_products(buffer, products):
    """Store the products of inertia of one part in a buffer, for j = 0."""
    if len(products) == 0:
        return None
    _keep(buffer, _PRODUCTS, tuple(vector(c) for c in products))


@inlined
def corner_weights(buffer, j, corner):
    """Weight of a corner of the cell of particle `j` of four, and its gradient.

    Parameters
    ----------
    buffer
        The supports of four particles, see `pgimp.kernels.transfer.supports`.
    j : int
        Number of the particle among the four.
    corner : tuple of D int
        0 or 1 along each direction.

    Returns
    -------
    N : float
    dN : tuple of D float
    """
    if len(corner) == 1:
        n, g = _factor(buffer, j, 0, corner[0])
        return n, (g,)
    if len(corner) == 2:
        (n, g), (m, h) = _factor(buffer, j, 0, corner[0]), _factor(buffer, j, 1, corner[1])
        return n * m + g * h * number(buffer, _PRODUCTS + j), (g * m, h * n)
    (n, g), (m, h) = _factor(buffer, j, 0, corner[0]), _factor(buffer, j, 1, corner[1])
    o, k = _factor(buffer, j, 2, corner[2])
    yz, xz = number(buffer, _PRODUCTS + j), number(buffer, _PRODUCTS + 4 + j)
    xy, xyz = number(buffer, _PRODUCTS + 8 + j), number(buffer, _PRODUCTS + 12 + j)
    x, y, z = m * o + h * k * yz, n * o + g * k * xz, n * m + g * h * xy
    N = n * x + g * (m * (k * xz) + o * (h * xy) + h * k * xyz)
    return N, (g * x, h * y, k * z)


@inlined
def _factor(buffer, j, d, i):
    """Weight and slope of vertex `i` along direction `d` of particle `j`."""
    at = 48 * d + 4 * i + j
    return number(buffer, at), number(buffer, at + 16)


@inlined
def _force(N, dN, B, S):
    """The vector N B + sum_i dN_i S_i, without B where it is ()."""
    if len(S) == 1:
        if is_empty(B):
            return dN[0] * S[0]
        return N * B + dN[0] * S[0]
    return dN[0] * S[0] + _force(N, dN[1:], B, S[1:])


@inlined
def scatter_parts(G, support, offset, stride, share, corner=()):
    """See `pgimp.kernels.transfer.scatter.scatter`; from the given corner on."""
    if len(corner) < len(share.S):
        scatter_parts(G, support, offset, stride[1:], share, (*corner, 0))
        scatter_parts(G, support, offset + stride[0], stride[1:], share, (*corner, 1))
        return
    N, dN = corner_weights(support.buffer, support.j, corner)
    if not is_empty(share.A):
        store(G, offset, load(G, offset) + N * share.A)
    store(G, offset + 4, load(G, offset + 4) + _force(N, dN, share.B, share.S))


@inlined
def gather_parts(G, support, offset, stride, like, corner=()):
    """See `pgimp.kernels.transfer.gather.gather`; there is no `mean` and no hoop."""
    if len(corner) < len(like):
        U, A, D = gather_parts(G, support, offset, stride[1:], like, (*corner, 0))
        V, B, E = gather_parts(G, support, offset + stride[0], stride[1:], like, (*corner, 1))
        return U + V, A + B, plus_scaled(1.0, D, E)
    N, dN = corner_weights(support.buffer, support.j, corner)
    u = load(G, offset)
    return N * u, N * load(G, offset + 4), tuple(g * u for g in dN)
