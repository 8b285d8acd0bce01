"""The weights of four particles' supports, in a buffer on the stack.

They are computed for four particles in one vector register. Transfers, with different vertices,
take one particle after the other.
"""

from pgimp.jit.kernel import class_of, inlined, is_empty
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.lanes import numbers
from pgimp.jit.vectors.simd import bits, load, number, store, vector
from pgimp.kernels.data.velocity_fields import move_to_fields
from pgimp.kernels.transfer.corners import keep_corners
from pgimp.kernels.transfer.first_vertex import box, first_vertex, is_axial
from pgimp.kernels.transfer.lane_io import coordinates, deformations
from pgimp.kernels.transfer.parts import keep_parts
from pgimp.kernels.transfer.rings import ring_weights
from pgimp.physics.shapes.base import by_corners, weights

#: Numbers in the buffer for supports of four particles: by direction weights (19), gradients (20),
#: weights times arms, each of up to four vertices. Then the offset of the first vertex; each four
#: times. From `MEANS` on there is space for `pgimp.kernels.update.mean_dilatation`. Supports by
#: corners have the numbers of `pgimp.kernels.transfer.corners`, on either side of the offset; those
#: of parts the numbers of `pgimp.kernels.transfer.parts`, from `MEANS` on.
SUPPORT_SIZE = 288
_DIRECTION, _QUANTITY, _OFFSET, MEANS = 48, 16, 144, 152

#: The direction, in axisymmetry, whose weights are those of the hoop.
HOOP = 2

#: There half-width, place and radius of four rings, in cells, and the gradients of their boxes.
PLAIN, BOX = HOOP * _DIRECTION + _QUANTITY, HOOP * _DIRECTION + 2 * _QUANTITY


@inlined
def _arms(w, f, cell):
    """Weights times the vertices' coordinates relative to the particle's."""
    if len(w) == 1:
        return (-w[0] * f * cell,)
    return (-w[0] * f * cell, *_arms(w[1:], f - 1.0, cell))


@inlined
def keep_vectors(buffer, at, V):
    """Store vectors in a buffer, one after the other."""
    if len(V) == 1:
        return store(buffer, at, vector(V[0]))
    store(buffer, at, vector(V[0]))
    keep_vectors(buffer, at + 4, V[1:])


@inlined
def _along(shape, frame, buffer, arms, d, half, x, vertex):
    """Store weights, gradients and, if asked for, arms along direction `d` in the buffer."""
    armed = not is_empty(arms)
    f = (x - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
    w, g = weights(shape, half, f)
    at = d * _DIRECTION
    keep_vectors(buffer, at, w)
    keep_vectors(buffer, at + _QUANTITY, scaled(frame.inverse[d], g))
    if armed:
        keep_vectors(buffer, at + 2 * _QUANTITY, _arms(w, f, frame.cell[d]))


@inlined
def _along_first(shape, frame, buffer, arms, half, x, vertex):
    """As `_along`, along x."""
    armed = not is_empty(arms)
    if not is_axial(frame):
        return _along(shape, frame, buffer, arms, 0, half, x, vertex)
    inverse = frame.inverse[0]
    f = (x - frame.origin[0]) * inverse - (vertex - frame.ghost)
    w, g, t, centroid, plain = ring_weights(shape, half, f, x * inverse)
    keep_vectors(buffer, 0, w)
    keep_vectors(buffer, _QUANTITY, scaled(inverse, g))
    keep_hoop(buffer, scaled(inverse, t))
    keep_vectors(buffer, BOX, (half, f, x * inverse))
    keep_vectors(buffer, PLAIN, plain)
    if armed:
        keep_vectors(buffer, 2 * _QUANTITY, _arms(w, f + centroid, frame.cell[0]))


@inlined
def _across(shape, frame, window, buffer, arms, d, half, x):
    """Store the weights along the directions from `d` on in the buffer; offsets as float64."""
    if len(x) == 0:
        return vector(0.0)
    vertex = first_vertex(frame, d, half[0], x[0])
    _along(shape, frame, buffer, arms, d, half[0], x[0], vertex)
    offset = (vertex - window.lower[d]) * window.stride[d]
    return offset + _across(shape, frame, window, buffer, arms, d + 1, half[1:], x[1:])


@inlined
def supports(shape, frame, window, particles, rows, layer, buffer, arms):
    """Store the supports of four particles in a known layer in a buffer.

    The buffer is of `SUPPORT_SIZE` float64. They come with arms unless `arms` is ().
    """
    if by_corners(shape):
        F, x = deformations(frame, particles, rows), coordinates(frame, particles, rows)
        offset = keep_corners(shape, frame, window, F, x, layer, buffer, arms)
        store(buffer, _OFFSET, offset)
        move_to_fields(window, particles, rows, buffer, _OFFSET)
    else:
        x = coordinates(frame, particles, rows)
        half = box(shape, frame, deformations(frame, particles, rows), x)[0]
        _along_first(shape, frame, buffer, arms, half[0], x[0], layer)
        store(buffer, _OFFSET, _across(shape, frame, window, buffer, arms, 1, half[1:], x[1:]))
        keep_parts(shape, frame, particles, rows, buffer)
        move_to_fields(window, particles, rows, buffer, _OFFSET)


@inlined
def keep_support(buffer, d, w, g):
    """Store weights and gradients of one particle along direction `d` in a buffer, for j = 0."""
    keep_vectors(buffer, d * _DIRECTION, w)
    keep_vectors(buffer, d * _DIRECTION + _QUANTITY, g)


@inlined
def keep_hoop(buffer, t):
    """Store the weights of the hoop of four particles in a buffer."""
    return keep_vectors(buffer, HOOP * _DIRECTION, t)


@inlined
def first_offset(buffer, j):
    """Offset of the first vertex of particle `j` of four within its plane."""
    return int(number(buffer, _OFFSET + j))


@inlined
def first_offsets(buffer):
    """Offsets of the first vertices of all four particles, a vector."""
    return load(buffer, _OFFSET)


@inlined
def entry(buffer, d, quantity, i, j):
    """Weight (0), gradient (1) or arm (2) of vertex `i` along direction `d` of particle `j`."""
    return number(buffer, d * _DIRECTION + quantity * _QUANTITY + 4 * i + j)


@inlined
def four_entries(buffer, d, quantity, i):
    """The entries of all four particles, a vector."""
    return load(buffer, d * _DIRECTION + quantity * _QUANTITY + 4 * i)


@inlined
def entries(buffer, d, quantity, i, j, like):
    """The entries of the vertices i, i+1, ..., as many as `like` has."""
    return numbers(buffer, d * _DIRECTION + quantity * _QUANTITY + 4 * i + j, 4, like)


@inlined
def share_support(buffer):
    """Whether all four particles share their first vertex and field."""
    return bits(first_offsets(buffer) == number(buffer, _OFFSET)) == 15


@inlined
def _any_weight(buffer, d, i):
    """Whether any of four particles has weight at vertex `i` along direction `d`."""
    return bits(four_entries(buffer, d, 0, i) == 0.0) != 15


@inlined
def extent(shape, buffer, d, j):
    """Number of vertices along direction `d` with weight for particle `j`; at least two.

    With () for `j` it is the number of vertices with weight for any of the four particles.
    """
    vertices = class_of(shape).vertices()
    if vertices == 2:
        return 2
    if is_empty(j):
        if vertices == 3:
            return 3 if _any_weight(buffer, d, 2) else 2
        return 4 if _any_weight(buffer, d, 3) else (3 if _any_weight(buffer, d, 2) else 2)
    if vertices == 3:
        return 3 if entry(buffer, d, 0, 2, j) != 0.0 else 2
    return 4 if entry(buffer, d, 0, 3, j) != 0.0 else (3 if entry(buffer, d, 0, 2, j) != 0.0 else 2)


@inlined
def extents(shape, buffer, d, j, like):
    """Numbers of vertices along the directions from `d` on, as many as `like` has."""
    if len(like) == 0:
        return ()
    return (extent(shape, buffer, d, j), *extents(shape, buffer, d + 1, j, like[1:]))
