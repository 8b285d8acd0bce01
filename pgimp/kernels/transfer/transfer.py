"""Scatter and gather between a particle and the vertices of its support.

They move records of vertices, see `pgimp.kernels.data.record`. Both transfers are written once for
all dimensions, and factor the sums by direction. In 3D the innermost vertex costs P2G three vector
multiply-adds, and G2P three. Vertices without weight at the support's end are left out. The
innermost direction, along which records follow each other, is unrolled for each number of vertices;
the others are loops.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import class_of, inlined
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.transfer.mean_dilatation_weights import factors
from pgimp.kernels.transfer.supports import entries, extent, extents


class Support(NamedTuple):
    """Support of one of four particles."""

    #: The supports of the four particles, see `pgimp.kernels.transfer.supports`.
    buffer: np.ndarray
    j: int  #: Number of the particle among the four.


@inlined
def last_step(stride):
    """Distance of neighbours along the last direction, given its stride and the following ones.

    In 1D it is the distance of planes, which may hold several fields; else it is a constant.
    """
    if len(stride) == 3:
        return stride[0]
    return RECORD


@inlined
def last_entries(support, d, like, mean):
    """Weights, gradients, arms and factors along the last direction, as many as `like` has."""
    return (
        entries(support.buffer, d, 0, 0, support.j, like),
        entries(support.buffer, d, 1, 0, support.j, like),
        entries(support.buffer, d, 2, 0, support.j, like),
        factors(mean, support.buffer, d, 0, support.j, like),
    )


@inlined
def lines(G, support, d, offset, counts, stride, Z, what):
    """Transfer between a particle and the lines of its support, from direction `d` on.

    Parameters
    ----------
    offset : int
        Offset of the first vertex.
    counts : tuple of int
        Vertices of the current direction and the following ones but the last; `stride` alike.
    Z : tuple
        Weights, gradients, arms and `factors` along the last direction.
    what : Share or Sums
        Contributions to scatter, or the kind of sums to gather, which are returned.
    """
    return class_of(what).lines(G, support, d, offset, counts, stride, Z, what)


@inlined
def _by_number(like, count, G, support, offset, counts, stride, what):
    """Transfer for a particle with weight on `count` vertices along the last direction.

    At most as many as `like` has; each number has its own code.
    """
    last = len(counts)
    if len(like) == 2:
        Z = last_entries(support, last, like, what.M)
        return lines(G, support, 0, offset, counts, stride, Z, what)
    if count < len(like):
        return _by_number(like[1:], count, G, support, offset, counts, stride, what)
    Z = last_entries(support, last, like, what.M)
    return lines(G, support, 0, offset, counts, stride, Z, what)


@inlined
def transfer_products(shape, G, support, offset, stride, directions, what):
    """Transfer for a particle whose weights are products by direction; see `lines`."""
    last = len(directions) - 1
    outer, most = (0,) * last, (0.0,) * class_of(shape).vertices()
    counts = extents(shape, support.buffer, 0, support.j, outer)
    count = extent(shape, support.buffer, last, support.j)
    return _by_number(most, count, G, support, offset, counts, stride, what)
