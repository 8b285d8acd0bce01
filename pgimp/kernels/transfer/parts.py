"""Weights of parts of cells: means of the cell's multilinear functions over a part.

A vertex has N = n_x n_y n_z, with n = 1 - t or t along each direction. About the part's centroid
each n is linear, with the slope g = -1/h or 1/h. So the mean of N over the part is exact with the
means of products of the distances from the centroid, c_xy, c_yz, c_xz, c_xyz:

    n_x n_y n_z + n_x g_y g_z c_yz + n_y g_x g_z c_xz + n_z g_x g_y c_xy + g_x g_y g_z c_xyz,
    dN/dx: g_x (n_y n_z + g_y g_z c_yz).

The sum of V_p dN_p/dx over a body is then the integral of N n over its surface, wherever that cuts
cells. Whoever needs the weights of a particle calls `corner_weights`.

Rings weigh with their radius r. So their means of N and dN/dx are of this form about the mass's
centroid, with c_xy about it. The weights T of the hoop, see `pgimp.kernels.transfer.rings`, are
means of N over the section, over the radius of its centroid. With the distance d between both
centroids c_xy there is r d_y.
"""

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled, read
from pgimp.jit.vectors.lanes import numbers, vectors
from pgimp.jit.vectors.simd import load, number, store
from pgimp.kernels.transfer.first_vertex import is_axial
from pgimp.kernels.transfer.lane_io import coordinates, take_row
from pgimp.physics.shapes.base import by_parts

#: Where a buffer for supports has the weights of four parts: for each corner of their cells, the
#: last direction innermost, the weight, its gradient and the hoop's weight, four times each.
_CORNERS, _CORNER = 152, 16


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
def keep_parts(shape, frame, particles, rows, buffer):
    """Store the weights of four parts in their buffer; nothing for other shapes.

    The buffer has those of points at their centroids, by direction.
    """
    if by_parts(shape):
        D = len(frame.origin)
        if D == 1:
            keep_corners(buffer, (), frame.origin, ())
        elif is_axial(frame):
            products = take_row(particles.products, rows, 0, (0.0, 0.0, 0.0))
            radius = coordinates(frame, particles, rows)[0]
            keep_corners(buffer, (*products, 1.0 / radius), frame.origin, ())
        else:
            products = take_row(particles.products, rows, 0, zero_products(D))
            keep_corners(buffer, products, frame.origin, ())


@inlined
def read_products(products, p, number, D):
    """Products of inertia of a part, vectors, from those of several in a row."""
    if D == 1:
        return ()
    return vectors(read(products, p, number, zero_products(D)))


@inlined
def keep_corners(buffer, products, like, corner):
    """Store weights in a buffer, from the given corner on; see `keep_parts`.

    `products` are of four parts, `like` has an entry a direction. Those of rings end with 1/r.
    """
    if len(corner) < len(like):
        keep_corners(buffer, products, like, (*corner, 0))
        keep_corners(buffer, products, like, (*corner, 1))
        return
    n, g = _factors(buffer, 0, corner)
    N, dN = _means(n, g, products)
    at = _CORNERS + _CORNER * _number(corner)
    store(buffer, at, N)
    _keep(buffer, at + 4, dN)


@inlined
def _number(corner):
    """Number of a corner among those of its cell."""
    if len(corner) == 1:
        return corner[0]
    if len(corner) == 2:
        return 2 * corner[0] + corner[1]
    return 4 * corner[0] + 2 * corner[1] + corner[2]


@inlined
def _factors(buffer, d, corner):
    """Tents and slopes of a corner at four centroids, from direction `d` on."""
    at = 48 * d + 4 * corner[0]
    if len(corner) == 1:
        return (load(buffer, at),), (load(buffer, at + 16),)
    n, g = _factors(buffer, d + 1, corner[1:])
    return (load(buffer, at), *n), (load(buffer, at + 16), *g)


@inlined
def _means(n, g, products):
    """Means of a corner's function and its gradient over parts; of rings also the hoop's."""
    if len(n) == 1:
        return n[0], g
    if len(n) == 2 and len(products) == 4:
        xy, out, along, by = products
        x, y, both = n[0] + g[0] * out, n[1] + g[1] * along, g[0] * g[1]
        return x * y + both * xy, (g[0] * y, g[1] * x, by * (n[0] * n[1]) + both * along)
    if len(n) == 2:
        return n[0] * n[1] + g[0] * g[1] * products[0], (g[0] * n[1], g[1] * n[0])
    yz, xz, xy = g[1] * g[2] * products[0], g[0] * g[2] * products[1], g[0] * g[1] * products[2]
    x, y, z = n[1] * n[2] + yz, n[0] * n[2] + xz, n[0] * n[1] + xy
    N = n[0] * x + n[1] * xz + n[2] * xy + g[0] * g[1] * g[2] * products[3]
    return N, (g[0] * x, g[1] * y, g[2] * z)


@inlined
def _keep(buffer, at, V):
    """Store vectors in a buffer, one after the other."""
    if len(V) == 0:
        return None
    store(buffer, at, V[0])
    _keep(buffer, at + 4, V[1:])


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
    at = _CORNERS + _CORNER * _number(corner) + j
    return number(buffer, at), numbers(buffer, at + 4, 4, corner)


@inlined
def _hoop_weight(support, corner):
    """Weight of the hoop of a ring at a corner of its cell."""
    return number(support.buffer, _CORNERS + _CORNER * _number(corner) + 12 + support.j)


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
    force = _force(N, dN, share.B, share.S)
    if not is_empty(share.H):
        force = force + _hoop_weight(support, corner) * share.H
    store(G, offset + 4, load(G, offset + 4) + force)


@inlined
def gather_parts(G, support, offset, stride, like, hoop, corner=()):
    """See `pgimp.kernels.transfer.gather.gather`; there is no `mean`."""
    if len(corner) < len(like):
        upper = offset + stride[0]
        U, A, D = gather_parts(G, support, offset, stride[1:], like, hoop, (*corner, 0))
        V, B, E = gather_parts(G, support, upper, stride[1:], like, hoop, (*corner, 1))
        return U + V, A + B, plus_scaled(1.0, D, E)
    N, dN = corner_weights(support.buffer, support.j, corner)
    u = load(G, offset)
    D = tuple(g * u for g in dN)
    if len(hoop) > 0:
        D = (*D, _hoop_weight(support, corner) * u)
    return N * u, N * load(G, offset + 4), D


@inlined
def _product_weights(buffer, j, corner):
    """Weights of products of distances at a corner: slopes along their directions, tents else."""
    if len(corner) == 1:
        return ()
    at = tuple(48 * d + 4 * corner[d] + j for d in range(len(corner)))
    n, g = tuple(number(buffer, a) for a in at), tuple(number(buffer, a + 16) for a in at)
    if len(corner) == 2:
        return (g[0] * g[1],)
    yz = g[1] * g[2]
    return n[0] * yz, g[0] * n[1] * g[2], g[0] * g[1] * n[2], g[0] * yz


@inlined
def scatter_surface(G, support, offset, stride, force, moments, like, corner=()):
    """Add the force on a part of a surface, and its moments, to its cell.

    Parameters
    ----------
    force : Vec4
        (0, f).
    moments : tuple of Vec4
        First moments of the force along each direction, then those of products of distances, as
        many as a part has products of inertia.
    like : tuple
        One entry a direction.
    """
    if len(corner) < len(like):
        upper, rest = offset + stride[0], stride[1:]
        scatter_surface(G, support, offset, rest, force, moments, like, (*corner, 0))
        scatter_surface(G, support, upper, rest, force, moments, like, (*corner, 1))
        return
    N, dN = corner_weights(support.buffer, support.j, corner)
    weights = (*dN, *_product_weights(support.buffer, support.j, corner))
    store(G, offset + 4, load(G, offset + 4) + _force(N, weights, force, moments))


@inlined
def gather_between(G, support, offset, stride, half, like, corner=()):
    """Mean over a part of the velocity less `half` times the acceleration, and its derivatives.

    These are the gradient, and what belongs to the products of distances of `scatter_surface`.
    """
    if len(corner) < len(like):
        U, D = gather_between(G, support, offset, stride[1:], half, like, (*corner, 0))
        upper = offset + stride[0]
        V, E = gather_between(G, support, upper, stride[1:], half, like, (*corner, 1))
        return U + V, plus_scaled(1.0, D, E)
    N, dN = corner_weights(support.buffer, support.j, corner)
    u = load(G, offset) - half * load(G, offset + 4)
    return N * u, tuple(g * u for g in (*dN, *_product_weights(support.buffer, support.j, corner)))
