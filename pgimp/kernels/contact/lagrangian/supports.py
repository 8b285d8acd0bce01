"""Supports of single particles, in memory: for the few particles near contact.

Other supports are computed for four particles at once, on the stack, see
`pgimp.kernels.transfer.supports`. Those of cut boxes are as `pgimp.kernels.contact.volumes` has
them in the current configuration.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.tuples import plus_scaled, read, scaled
from pgimp.kernels.contact.volumes import MIN_HALF_WIDTH, cut_moments, cut_weights
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.transfer.first_vertex import first_vertex, is_axial, off_axis
from pgimp.kernels.transfer.rings import ring_weights
from pgimp.physics.shapes.base import weights


class Supports(NamedTuple):
    """Supports of n particles with k vertices each; some vertices may have no weight."""

    first: IntArray  #: (n, 3) int64: The first vertex of each.
    #: w, g: (n, 3, 4) float64: Weights and gradients times the cell, by direction; one vertex along
    #: directions that the scene does not have.
    w: FloatArray
    g: FloatArray
    #: (k, 3) uint32: Vertices of any support, counted from the first one, the last direction
    #: innermost.
    local: NDArray[np.uint32]
    #: (n, 4) or (0, 4) float64: In axisymmetry the weights T of the hoop, times the cell: see
    #: `pgimp.kernels.transfer.rings`.
    hoop: FloatArray

    @classmethod
    def empty(cls, count: int, local: NDArray[np.uint32], axial: bool) -> Self:
        """Allocate the supports of `count` particles; `local` is from `local_vertices`."""
        w, g = np.empty((2, count, 3, 4))
        hoop = np.empty((count if axial else 0, 4))
        return cls(np.empty((count, 3), np.int64), w, g, local, hoop)


def local_vertices(vertices: int, dimensions: int) -> NDArray[np.uint32]:
    """Return the vertices of any support, `vertices` in each direction; see `Supports`."""
    across = (vertices,) * dimensions + (1,) * (3 - dimensions)
    return np.array([*np.ndindex(across)], np.uint32)


@inner_kernel
def vertex_at(supports, i, q):
    """Numbers of vertex `q` of support `i`."""
    first, local = supports.first[i], supports.local[q]
    return first[0] + local[0], first[1] + local[1], first[2] + local[2]


@inner_kernel
def weights_at(supports, i, q):
    """Factors, one a direction, of the weight S of vertex `q` of support `i`."""
    w, local = supports.w[i], supports.local[q]
    return w[0, local[0]], w[1, local[1]], w[2, local[2]]


@inlined
def _keep_values(out, values):
    """Set `out[0]`, `out[1]`, ... to a tuple of numbers."""
    for k, value in enumerate(values):
        out[k] = value


@inlined
def _support(shape, frame, half, x, supports, i, begin):
    """Set support `i` along the directions from `begin` on."""
    for d in range(begin, len(frame.origin)):
        first = first_vertex(frame, d, half[d], x[d])
        f = (x[d] - frame.origin[d]) * frame.inverse[d] - (first - frame.ghost)
        values, slopes = weights(shape, half[d], f)
        supports.first[i, d] = first
        _keep_values(supports.w[i, d], values)
        _keep_values(supports.g[i, d], slopes)


@inlined
def _first_support(shape, frame, half, x, supports, i):
    """Set support `i` along all directions, in axisymmetry along the radius with rings."""
    if not is_axial(frame):
        return _support(shape, frame, half, x, supports, i, 0)
    inverse, near = frame.inverse[0], off_axis(frame, (x[0],))[0]
    r = near * inverse
    wide = min(half[0], r)
    first = first_vertex(frame, 0, wide, near)
    f = (near - frame.origin[0]) * inverse - (first - frame.ghost)
    values, slopes, hoop, _, _ = ring_weights(shape, wide, f, r)
    supports.first[i, 0] = first
    _keep_values(supports.w[i, 0], values)
    _keep_values(supports.g[i, 0], slopes)
    _keep_values(supports.hoop[i], hoop)
    _support(shape, frame, half, x, supports, i, 1)


@kernel
def find_supports(shape, frame, half, x, supports):
    """Set the supports of particles.

    Parameters
    ----------
    half, x : (n, D or more) float64
        Half-widths of the particles in cells, and their positions.
    supports : Supports
        Set here.
    """
    for i in range(len(x)):
        for d in range(3):
            supports.first[i, d] = 0
            for k in range(4):
                supports.w[i, d, k] = 1.0 if k == 0 else 0.0
                supports.g[i, d, k] = 0.0
        _first_support(shape, frame, half[i], x[i], supports, i)


@inlined
def _narrow(shape, frame, half, x, offset, supports, i):
    """Set the weights of a cut box in support `i`."""
    for d in range(len(x)):
        inverse, first = frame.inverse[d], supports.first[i, d]
        f = (x[d] + offset[d] - frame.origin[d]) * inverse - (first - frame.ghost)
        left = max(half[d] - abs(offset[d]) * inverse, MIN_HALF_WIDTH)
        values, slopes = cut_weights(shape, left, f)
        _keep_values(supports.w[i, d], values)
        _keep_values(supports.g[i, d], slopes)


@inlined
def _narrow_ring(shape, frame, place, whole, supports, i, cut):
    """In axisymmetry, set the weights of support `i` along the radius: of a `cut` box, or whole.

    `place` has its half-widths, its position and the offset to its centroid.
    """
    if not is_axial(frame):
        return None
    half, x, offset = place
    if not cut:
        for k in range(4):
            supports.hoop[i, k] = whole.hoop[i, k]
        return
    inverse, first = frame.inverse[0], supports.first[i, 0]
    r = max((x[0] + offset[0]) * inverse, MIN_HALF_WIDTH)
    f = r - frame.origin[0] * inverse - (first - frame.ghost)
    left = min(max(half[0] - abs(offset[0]) * inverse, MIN_HALF_WIDTH), r)
    by, (w, g) = 1.0 / r, cut_weights(shape, left, f)
    moments, ends = cut_moments(shape, left, f)
    _keep_values(supports.w[i, 0], plus_scaled(by, moments, w))
    _keep_values(supports.g[i, 0], plus_scaled(by, ends, g))
    _keep_values(supports.hoop[i], scaled(by, w))


@kernel
def narrow_supports(shape, frame, table, motion, whole, supports):
    """Set the supports of cut boxes; uncut particles keep their whole supports.

    Parameters
    ----------
    table, motion : (n,) NEAR_PARTICLE, (n,) NEAR_MOTION
        Particles at their current positions.
    whole : Supports
        Supports of their whole boxes.
    supports : Supports
        Set here.
    """
    zero = frame.origin
    for i in range(len(table)):
        row = table[i]
        for d in range(3):
            supports.first[i, d] = whole.first[i, d]
            for k in range(4):
                supports.w[i, d, k], supports.g[i, d, k] = whole.w[i, d, k], whole.g[i, d, k]
        half, x = read(table.half_width, i, 0, zero), read(motion.position, i, 0, zero)
        offset = read(motion.centroid_offset, i, 0, zero)
        if row.cut != 0:
            _narrow(shape, frame, half, x, offset, supports, i)
        _narrow_ring(shape, frame, (half, x, offset), whole, supports, i, row.cut != 0)


@inlined
def plus_hoop(frame, supports, i, a, V, slope):
    """The radial part `slope` of a closed surface with the hoop's, V times T of vertex `a`."""
    if not is_axial(frame):
        return slope
    return slope + V * supports.hoop[i, a]


@inlined
def from_centroid(frame, row, way):
    """The vector `way` from a particle, as one from where its velocity is the grid's.

    In axisymmetry that is the centroid of its ring in the initial configuration.
    """
    if not is_axial(frame):
        return way
    r = off_axis(frame, (row.weight_position[0],))[0] * frame.inverse[0]
    half = min(row.half_width[0], r)
    return way[0] - half * half * (1.0 / 3.0) / r, way[1], way[2]
