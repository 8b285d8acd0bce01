"""Supports that are sums over corners: convected particle domains in full.

A corner c of a particle's parallelogram gives to the 2^D vertices of its cell, with the weights
N = S_v(x_c). These are products of 1 - t_i or t_i for its position t in that cell. Each of them
gets the following vectors, times N (see `pgimp.physics.shapes.cpdi_corners` for A and s), from a
particle's `Share`

    2^-D (A + sum_j s_cj K_j) and 2^-D (B + sum_j s_cj T_j),   T_j = sum_i (A^-1)_ji S_i.

K_j = sum_i A_ij C_i is the change of the affine momentum from the particle to the corner. The
change from the corner on to a vertex, along each direction i -t_i or 1 - t_i cells of C_i, is added
on the way. Likewise the velocities U_c at the corners have the mean U, and the gradient 2^-D sum_j
(sum_c s_cj U_c) (A^-1)_j. So nothing branches, and no table of weights is made.
"""

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled
from pgimp.jit.vectors.lanes import numbers
from pgimp.jit.vectors.simd import load, number, pack, store
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.transfer.corners import CELL, CORNER, EDGES, INVERSE


@inlined
def _combined(w, V):
    """The vector sum_i w_i V_i."""
    if len(w) == 1:
        return w[0] * V[0]
    return w[0] * V[0] + _combined(w[1:], V[1:])


@inlined
def _combinations(part, buffer, at, steps, V, rows):
    """Combinations of the vectors `V`, times `part`, one for each of the rows from `at` on.

    `steps` are the distances in the buffer of a row's numbers, and of the rows.
    """
    if len(V) == 0:
        return ()
    begins = tuple(at + k * steps[1] for k in range(len(rows)))
    return tuple(part * _combined(numbers(buffer, each, steps[0], V), V) for each in begins)


@inlined
def corner(buffer, c, j, like):
    """Position t of corner `c` of particle `j` in its cell, and that cell's offset."""
    return (numbers(buffer, CORNER * c + j, 4, like), int(number(buffer, CORNER * c + CELL + j)))


@inlined
def _along(A, t, C):
    """The vector A + t C_0; A where C is ()."""
    if len(C) == 0:
        return A
    return t * C[0] + A


@inlined
def spread(G, offset, stride, w, t, A, B, C):
    """Add vectors A and B, times `w`, to the vertices round the position t in a cell.

    Parameters
    ----------
    offset, stride
        For the cell's first vertex; from the current direction on.
    t : tuple of float
        The position along the current direction and the following ones.
    C : tuple of Vec4
        Change of A over a cell along each of them, or ().
    """
    if len(t) == 0:
        store(G, offset, load(G, offset) + w * A)
        store(G, offset + 4, load(G, offset + 4) + w * B)
        return
    innermost = len(t) == 1
    above = offset + (RECORD if innermost else stride[0])
    low, high = _along(A, -t[0], C), _along(A, 1.0 - t[0], C)
    spread(G, offset, stride[1:], w * (1.0 - t[0]), t[1:], low, B, C[1:])
    spread(G, above, stride[1:], w * t[0], t[1:], high, B, C[1:])


@inlined
def _scatter_each(support, c, planes, middle, changes, like):
    """Add the shares of the corners c, c + 1, ... of a particle.

    `planes` are G, offset and stride, `middle` A, B in the middle of these corners and C, `changes`
    K and T.
    """
    if len(changes[1]) == 0:
        (G, offset, stride), (A, B, C) = planes, middle
        t, cell = corner(support[0], c, support[1], like)
        spread(G, offset + cell, stride, 1.0, t, A, B, C)
        return
    (A, B, C), (K, T) = middle, changes
    low, high = (_along(A, -1.0, K), B - T[0], C), (_along(A, 1.0, K), B + T[0], C)
    _scatter_each(support, 2 * c, planes, low, (K[1:], T[1:]), like)
    _scatter_each(support, 2 * c + 1, planes, high, (K[1:], T[1:]), like)


@inlined
def _part_of(part, B):
    """The vector part B; zero where B is ()."""
    if is_empty(B):
        return pack(0.0, 0.0, 0.0, 0.0)
    return part * B


@inlined
def _over_cells(part, C, cell):
    """The changes C, per length, over a cell along each direction, times `part`; () if () ."""
    return tuple((part * h) * each for each, h in zip(C, cell, strict=False))


@inlined
def scatter_corners(shape, G, support, offset, stride, share):
    """See `pgimp.kernels.transfer.scatter.scatter`."""
    D = len(share.S)
    part, like, steps = 0.5**D, (0.0,) * D, (4, 4 * D)
    (buffer, j), (A, B, S, C, _, _) = support, share
    T = _combinations(part, buffer, INVERSE + j, steps, S, like)
    C = _over_cells(part, C, shape.cell)
    K = _combinations(1.0, buffer, EDGES + j, steps, C, like)
    middle = (part * A, _part_of(part, B), C)
    _scatter_each((buffer, j), 0, (G, offset, stride), middle, (K, T), like)


@inlined
def interpolated(G, offset, stride, t):
    """The two vectors of the records at the position t in a cell; arguments as for `spread`."""
    if len(t) == 0:
        return (load(G, offset), load(G, offset + 4))
    innermost = len(t) == 1
    u, a = interpolated(G, offset, stride[1:], t[1:])
    v, b = interpolated(G, offset + (RECORD if innermost else stride[0]), stride[1:], t[1:])
    s = 1.0 - t[0]
    return t[0] * v + s * u, t[0] * b + s * a


@inlined
def _sums(G, buffer, j, c, offset, stride, like, rest):
    """Sums over the corners c, c + 1, ... of both vectors, and of s_j U_c for each of `rest`."""
    if len(rest) == 0:
        t, cell = corner(buffer, c, j, like)
        u, a = interpolated(G, offset + cell, stride, t)
        return u, a, ()
    u, a, low = _sums(G, buffer, j, 2 * c, offset, stride, like, rest[1:])
    v, b, high = _sums(G, buffer, j, 2 * c + 1, offset, stride, like, rest[1:])
    return u + v, a + b, (v - u, *plus_scaled(1.0, low, high))


@inlined
def gather_corners(shape, G, support, offset, stride, like):
    """See `pgimp.kernels.transfer.gather.gather`; there is no `mean`."""
    part, steps = 0.5 ** len(like), (4 * len(like), 4)
    buffer, j = support
    U, A, E = _sums(G, buffer, j, 0, offset, stride, like, like)
    D = _combinations(part, buffer, INVERSE + j, steps, E, like)
    return part * U, part * A, D, ()
