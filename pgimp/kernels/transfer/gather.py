"""Gather from the vertices of a particle's support; see `pgimp.kernels.transfer.transfer`."""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.outside import NumbaObject
from pgimp.jit.tuples import joined, plus_scaled
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import load, vector
from pgimp.kernels.transfer.cornertransfer import gather_corners
from pgimp.kernels.transfer.mean_dilatation_weights import factor, no_rates
from pgimp.kernels.transfer.parts import gather_parts
from pgimp.kernels.transfer.supports import HOOP, entry
from pgimp.kernels.transfer.transfer import last_step, transfer_products
from pgimp.physics.shapes.base import by_corners, by_parts


class Sums(NamedTuple):
    """Sums over a support."""

    M: NumbaObject  #: float or (): See `Loads.mean`: whether they include the mean dilatation's.
    #: (float,) or (): Whether they include the hoop's, of velocities times T_vp, as one more
    #: derivative.
    H: tuple

    @staticmethod
    def lines(G, support, d, offset, counts, stride, Z, what):
        """See `pgimp.kernels.transfer.transfer.lines`."""
        return _gather_lines(G, support, d, offset, counts, stride, Z, what)


@inlined
def _rates(mean, f, u):
    """The vector f u; () unless there is a `mean`."""
    if is_empty(mean):
        return ()
    return f * u


@inlined
def _plus_rates(mean, f, u, M):
    """The vector f u + M; () unless there is a `mean`."""
    if is_empty(mean):
        return ()
    return f * u + M


@inlined
def _plus_hoop(buffer, i, j, u, T):
    """The tuple (T + T_i u,), with the weights T along the radius; () if T is ()."""
    if len(T) == 0:
        return ()
    return (T[0] + entry(buffer, HOOP, 0, i, j) * u,)


@inlined
def _gather_line(G, offset, step, w, g, f, mean):
    """Sums over a line of vertices, which are `step` apart."""
    if len(w) == 1:
        u = load(G, offset)
        return w[0] * u, w[0] * load(G, offset + 4), (g[0] * u,), _rates(mean, f[0], u)
    U, A, D, M = _gather_line(G, offset + step, step, w[1:], g[1:], f[1:], mean)
    u = load(G, offset)
    M = _plus_rates(mean, f[0], u, M)
    return w[0] * u + U, w[0] * load(G, offset + 4) + A, (g[0] * u + D[0],), M


@inlined
def _gather_lines(G, support, d, offset, counts, stride, Z, what):
    """See `gather` for the sums."""
    if len(counts) == 0:
        return _gather_line(G, offset, last_step(stride), Z[0], Z[1], Z[3], what.M)
    (buffer, j), mean = support, what.M
    U, A, M = vector(0.0), vector(0.0), no_rates(mean)
    D, T = joined(vector(0.0), zeros(counts)), zeros(what.H)
    for i in range(counts[0]):
        w, g = entry(buffer, d, 0, i, j), entry(buffer, d, 1, i, j)
        u, a, b, m = _gather_lines(
            G, support, d + 1, offset + i * stride[0], counts[1:], stride[1:], Z, Sums(mean, ())
        )
        U, A = w * u + U, w * a + A
        D = joined(g * u + D[0], plus_scaled(w, b, D[1:]))
        M = _plus_rates(mean, factor(mean, what.H, buffer, d, i, j), m, M)
        T = _plus_hoop(buffer, i, j, u, T)
    return U, A, (*D, *T), M


@inlined
def gather(shape, G, support, offset, stride, like, mean, hoop):
    """Sums over a particle's support.

    Parameters
    ----------
    shape, G, support, offset, stride
        As in `scatter`.
    like : tuple
        One entry a direction of the scene.
    mean : float or ()
        See `Loads`.
    hoop : tuple
        (0.0,) in axisymmetry, else ().

    Returns
    -------
    U, A : Vec4
        Sums of the first and second vectors of the records times S_vp (26, 27).
    D : tuple of Vec4
        For each direction, the sum of the first vector times dS_vp/dx_i (30); with a `hoop` one
        more, times T_vp.
    M : Vec4 or ()
        With a `mean`, the sum of dD_p/dv_v times velocities, component by component.
    """
    if by_corners(shape):
        return gather_corners(shape, G, support, offset, stride, like)
    if by_parts(shape):
        return (*gather_parts(G, support, offset, stride, like, hoop), ())
    return gather_products(shape, G, support, offset, stride, like, mean, hoop)


@inlined
def gather_products(shape, G, support, offset, stride, like, mean, hoop):
    """As `gather`, for weights that are products by direction, of any shape."""
    return transfer_products(shape, G, support, offset, stride, like, Sums(mean, hoop))
