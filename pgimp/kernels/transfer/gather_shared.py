"""Gather for four particles: one after the other, or together on a shared support.

One after the other, each reads whole records of vertices, as vectors, with its own weights, and the
sums are transposed. In the initial configuration the particles of a lattice's cell always share
their vertices. Four of them read each number of a record once, with vectors of their weights. The
groups of four follow from the canonical order, constant in that configuration, so that the bits do
not depend on ranks.
"""

from pgimp.jit.kernel import class_of, inlined, inner_kernel
from pgimp.jit.tuples import joined, plus_scaled, scaled
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import vector
from pgimp.kernels.data.record import ACCELERATION, HELD, RECORD, VELOCITY
from pgimp.kernels.transfer.first_vertex import is_axial, is_initial
from pgimp.kernels.transfer.gather import gather
from pgimp.kernels.transfer.lane_io import LANES
from pgimp.kernels.transfer.mean_dilatation_weights import keep_rates
from pgimp.kernels.transfer.supports import extents, first_offset, four_entries, share_support
from pgimp.kernels.transfer.transfer import Support
from pgimp.kernels.transfer.transpose import (
    collected,
    gradients,
    held_weights,
    keep_sums,
    repeat_sums,
)
from pgimp.physics.shapes.base import by_parts


@inlined
def take_from_grid(layout, field, mean, four, buffer, sums):
    """Gather velocity, acceleration and gradient for four particles.

    Parameters
    ----------
    layout : tuple
        The shape and the frame, without materials and loads, of which there are many.
    field, four
        See `Field`, `FourParticles`.
    mean
        See `Loads`.
    buffer, sums
        The supports of the four particles, and scratch for `keep_sums`.

    Returns
    -------
    u, a : tuple of D Vec4
        Velocity and acceleration at their positions.
    grad : tuple of D*D Vec4
        Gradient of the velocity, row-major.
    held : Vec4
        Weighted sums of `HELD` over the vertices.
    hoop : tuple of 2 Vec4 or ()
        In axisymmetry, sums of velocities times T_vp; `grad` then has that of the radial ones.
    """
    if is_initial(layout[1]) and not is_axial(layout[1]) and not by_parts(layout[0]):
        if four.size < LANES or not share_support(buffer):
            return _take_separately(layout, field, mean, four, buffer, sums)
        (shape, frame), window = layout, field.window
        offset = four.layer * window.stride[0] + first_offset(buffer, 0)
        u, a, D, held = gather_shared(
            shape, field.G, buffer, offset, window.stride, frame.origin, frame.origin
        )
        return u, a, row_major(D), held, ()
    return _take_separately(layout, field, mean, four, buffer, sums)


@inlined
def _take_separately(layout, field, mean, four, buffer, sums):
    """As `take_from_grid`, one particle after the other."""
    if is_axial(layout[1]):
        like = layout[1].origin
        _gather_each(layout, field, mean, four, buffer, sums, (0.0,))
        repeat_sums(sums, four.size, (0.0, 0.0, 0.0))
        u, a, hoop = collected(sums, 0, like), collected(sums, 1, like), collected(sums, 4, like)
        return u, a, (*gradients(sums, 2, like), hoop[0]), held_weights(sums), hoop
    like = layout[1].origin
    _gather_each(layout, field, mean, four, buffer, sums, ())
    repeat_sums(sums, four.size, like)
    u, a = collected(sums, 0, like), collected(sums, 1, like)
    return u, a, gradients(sums, 2, like), held_weights(sums), ()


@inner_kernel
def _gather_each(layout, field, mean, four, buffer, sums, hoop):
    """Gather for four particles into `sums`; `hoop` is one zero in axisymmetry, else empty."""
    (shape, frame), window = layout, field.window
    begin = four.layer * window.stride[0]
    for j in range(four.size):
        offset, support = begin + first_offset(buffer, j), Support(buffer, j)
        U, A, D, M = gather(
            shape, field.G, support, offset, window.stride, frame.origin, mean, hoop
        )
        keep_sums(sums, j, U, A, D)
        keep_rates(M, buffer, j)


@inlined
def row_major(D):
    """Gradients, row-major, from the derivatives of a vector along each direction."""
    if len(D) == 1:
        return D[0]
    if len(D) == 2:
        return (D[0][0], D[1][0], D[0][1], D[1][1])
    return (D[0][0], D[1][0], D[2][0], D[0][1], D[1][1], D[2][1], D[0][2], D[1][2], D[2][2])


@inlined
def _numbers(G, at, like):
    """Numbers from `at` on, as many as `like` has."""
    if len(like) == 1:
        return (G[at],)
    return (G[at], *_numbers(G, at + 1, like[1:]))


@inlined
def _zero_gradients(counts, like):
    """Zero derivatives, of as many directions as there are counts."""
    if len(counts) == 1:
        return (zeros(like),)
    return (zeros(like), *_zero_gradients(counts[1:], like))


@inlined
def _add_gradients(w, ds, Ds):
    """Derivatives Ds + w ds, direction by direction."""
    if len(ds) == 1:
        return (plus_scaled(w, ds[0], Ds[0]),)
    return (plus_scaled(w, ds[0], Ds[0]), *_add_gradients(w, ds[1:], Ds[1:]))


@inlined
def _line(G, buffer, d, i, offset, step, like, most):
    """Sums over the vertices i, i + 1, ... of a line, as many as `most` has, `step` apart."""
    if len(most) == 1:
        w, g = four_entries(buffer, d, 0, i), four_entries(buffer, d, 1, i)
        v = _numbers(G, offset + VELOCITY, like)
        a = _numbers(G, offset + ACCELERATION, like)
        return scaled(w, v), scaled(w, a), (scaled(g, v),), w * G[offset + HELD]
    U, A, D, held = _line(G, buffer, d, i + 1, offset + step, step, like, most[1:])
    w, g = four_entries(buffer, d, 0, i), four_entries(buffer, d, 1, i)
    v = _numbers(G, offset + VELOCITY, like)
    a = _numbers(G, offset + ACCELERATION, like)
    return (
        plus_scaled(w, v, U),
        plus_scaled(w, a, A),
        (plus_scaled(g, v, D[0]),),
        w * G[offset + HELD] + held,
    )


@inlined
def _line_of_some(most, count, G, buffer, d, offset, step, like):
    """Sums over a line of `count` vertices, at least two and at most as many as in `most`."""
    if len(most) == 2:
        return _line(G, buffer, d, 0, offset, step, like, most)
    if count < len(most):
        return _line_of_some(most[1:], count, G, buffer, d, offset, step, like)
    return _line(G, buffer, d, 0, offset, step, like, most)


@inlined
def _lines(G, buffer, d, offset, counts, stride, like, most):
    """Sums over the lines of a support, from direction `d` on."""
    if len(counts) == 1:
        if len(like) == 1:
            return _line_of_some(most, counts[0], G, buffer, d, offset, stride[0], like)
        return _line_of_some(most, counts[0], G, buffer, d, offset, RECORD, like)
    U, A, D, held = zeros(like), zeros(like), _zero_gradients(counts, like), vector(0.0)
    for i in range(counts[0]):
        w, g = four_entries(buffer, d, 0, i), four_entries(buffer, d, 1, i)
        u, a, b, h = _lines(
            G, buffer, d + 1, offset + i * stride[0], counts[1:], stride[1:], like, most
        )
        D = joined(plus_scaled(g, u, D[0]), _add_gradients(w, b, D[1:]))
        U, A, held = plus_scaled(w, u, U), plus_scaled(w, a, A), w * h + held
    return U, A, D, held


@inlined
def gather_shared(shape, G, buffer, offset, stride, directions, like):
    """Sums of velocities, accelerations, derivatives along each direction, and codes.

    For as many numbers of a record as `like` has, in a scene of as many `directions`.
    """
    most = (0.0,) * class_of(shape).vertices()
    counts = extents(shape, buffer, 0, (), directions)
    return _lines(G, buffer, 0, offset, counts, stride, like, most)
