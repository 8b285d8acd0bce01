"""Scatter to the vertices of a particle's support; see `pgimp.kernels.transfer.transfer`."""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.outside import NumbaObject
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.simd import load, store
from pgimp.kernels.transfer.cornertransfer import scatter_corners
from pgimp.kernels.transfer.mean_dilatation_weights import factor, factored, plus_factored
from pgimp.kernels.transfer.parts import scatter_parts
from pgimp.kernels.transfer.supports import HOOP, entry
from pgimp.kernels.transfer.transfer import last_step, transfer_products
from pgimp.physics.shapes.base import by_corners, by_parts


class Share(NamedTuple):
    """A particle's contributions to the vertices of its support, vectors (m, p) and (0, f)."""

    #: Vec4 or (): Mass and momentum; a vertex gets the part S_vp, see `contribution`.
    A: NumbaObject
    B: NumbaObject  #: Vec4 or (): Force; a vertex gets the part S_vp, see `weight`.
    #: tuple of D Vec4 or of D (): Force along each direction i times dS_vp/dx_i, see
    #: `contribution`.
    S: tuple
    #: tuple of D Vec4 or (): Momentum times S_vp and the arm along each direction, see
    #: `affine_momentum`.
    C: tuple
    M: NumbaObject  #: Vec4 or (): Force times dD_p/dv_v, see `mean_force`.
    H: NumbaObject  #: Vec4 or (): Force times T_vp, see `hoop_force`.

    @staticmethod
    def lines(G, support, d, offset, counts, stride, Z, what):
        """See `pgimp.kernels.transfer.transfer.lines`."""
        return _scatter_lines(G, support, d, offset, counts, stride, Z, what)


@inlined
def _sloped(w, A, e, C):
    """The vector w A + e C_0; w A if C is (), () if A is ()."""
    if is_empty(A):
        return ()
    if len(C) == 0:
        return w * A
    return w * A + e * C[0]


@inlined
def _add(G, offset, w, A, e, C):
    """Add w A + e C_0 to the vector at `offset`; nothing where A is ()."""
    if is_empty(A):
        return None
    store(G, offset, load(G, offset) + _sloped(w, A, e, C))


@inlined
def _add_force(G, offset, force):
    """Add a force to the vector at `offset`; nothing where it is ()."""
    if is_empty(force):
        return None
    store(G, offset, load(G, offset) + force)


@inlined
def _slopes(w, S):
    """The forces w S; S if they are ()."""
    if len(S) == 0 or is_empty(S[0]):
        return S
    return scaled(w, S)


@inlined
def _force(w, B, g, S):
    """The vector w B + g S, with () for those that are not there."""
    if is_empty(S):
        return () if is_empty(B) else w * B
    if is_empty(B):
        return g * S
    return w * B + g * S


@inlined
def _plus_hoop(buffer, i, j, H, V):
    """The vector V + T_i H, with the weights T along the radius; V where H is ()."""
    if is_empty(H):
        return V
    return V + entry(buffer, HOOP, 0, i, j) * H


@inlined
def _scatter_line(G, offset, step, w, g, e, f, share):
    """Add a particle to a line of vertices, which are `step` apart."""
    A, B, S, C, M, _ = share
    _add(G, offset, w[0], A, e[0], C)
    _add_force(G, offset + 4, plus_factored(f[0], M, _force(w[0], B, g[0], S[0])))
    if len(w) > 1:
        _scatter_line(G, offset + step, step, w[1:], g[1:], e[1:], f[1:], share)


@inlined
def _scatter_lines(G, support, d, offset, counts, stride, Z, what):
    """A and B include the sums over the previous directions.

    S and C of the current and following ones are times the weights so far, M times the factors.
    """
    if len(counts) == 0:
        return _scatter_line(G, offset, last_step(stride), Z[0], Z[1], Z[2], Z[3], what)
    (buffer, j), (A, B, S, C, M, H) = support, what
    for i in range(counts[0]):
        w, g = entry(buffer, d, 0, i, j), entry(buffer, d, 1, i, j)
        e = entry(buffer, d, 2, i, j)
        at = offset + i * stride[0]
        part = Share(
            _sloped(w, A, e, C),
            _plus_hoop(buffer, i, j, H, _force(w, B, g, S[0])),
            _slopes(w, S[1:]),
            scaled(w, C[1:]),
            factored(factor(M, H, buffer, d, i, j), M),
            (),
        )
        _scatter_lines(G, support, d + 1, at, counts[1:], stride[1:], Z, part)
    return None


@inlined
def scatter(shape, G, support, offset, stride, share):
    """Add a particle's share to its support.

    Parameters
    ----------
    support : Support
        Its weights.
    offset : int
        Offset of the first vertex in `G`.
    stride : tuple of int
        The window's.
    share : Share
        Its contributions.
    """
    if by_corners(shape):
        return scatter_corners(shape, G, support, offset, stride, share)
    if by_parts(shape):
        return scatter_parts(G, support, offset, stride, share)
    return scatter_products(shape, G, support, offset, stride, share)


@inlined
def scatter_products(shape, G, support, offset, stride, share):
    """As `scatter`, for weights that are products by direction, of any shape."""
    return transfer_products(shape, G, support, offset, stride, share.S, share)
