"""Boxes of particles cut by surfaces, and their supports: for the sums of volumes.

A cut particle keeps its lattice position and its box, but only part of it belongs to the body. This
part has its own centroid, which deforms with the particle. The sums of volumes use a box round the
centroid, as wide as the remaining part of the whole box. It is exact for surfaces along the grid,
lies within the whole box, and has its support within the whole support. Shapes that are no boxes
have the weights of whole particles, corrected by their gradient over the offset to the centroid.
"""

from typing import NamedTuple

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import class_of, inlined, is_number
from pgimp.jit.tuples import plus_scaled, read, scaled
from pgimp.jit.vectors.simd import pack
from pgimp.kernels.transfer.first_vertex import box, deformation, first_vertex, is_axial
from pgimp.kernels.transfer.lane_io import coordinates, deformations, take_row
from pgimp.kernels.transfer.scatter import Share
from pgimp.kernels.transfer.supports import keep_hoop, keep_support, supports
from pgimp.physics.shapes.finite_gimp import FiniteGimpParameters
from pgimp.physics.shapes.gimp import GimpParameters

#: Shapes that are boxes.
BOXES = GimpParameters | FiniteGimpParameters

#: Least half-width of a cut box, in cells.
MIN_HALF_WIDTH = 1e-4

#: The entry of a vertex's record with the correction of the sums of volumes.
VOLUME_CORRECTION = 4


class VolumeSums(NamedTuple):
    """Sums of volumes, in place of mass and momentum; see `Quantity`.

    The sums are then V_p and V_p (b + 1), b being the number of the particle's body. In place of
    the forces they have V_p grad S, the integral of S over the surface with its outward normal. Cut
    particles also add their number and the curvature's share of their gap.
    """

    #: float or (): A number where S belongs to whole particles: `VOLUME_CORRECTION` then has V_p d
    #: . grad S for the offset d of their volume; see `pgimp.kernels.contact.volumes`.
    gradient: float | tuple[()] = ()

    @staticmethod
    def supports(quantity, shape, frame, window, particles, rows, layer, buffer):
        """See `Quantity`: of cut boxes, or of whole particles with a `gradient`."""
        supports(shape, frame, window, particles, rows, layer, buffer, ())
        if is_number(quantity.gradient):
            return
        F = deformations(frame, particles, rows)
        offset = _moved(F, take_row(particles.offset, rows, 0, frame.origin))
        x = coordinates(frame, particles, rows)
        half = box(shape, frame, F, x)[0]
        _narrow(shape, frame, buffer, 0, half, x, offset, layer)
        _narrow_ring(shape, frame, buffer, half, x, offset, layer)

    @staticmethod
    def share(quantity, shape, frame, particles, p):
        """See `Quantity`; of rings with the hoop's part, for the sums of a closed surface."""
        F = deformation(frame, particles, p)
        V, d = particles.V0[p] * determinant(F), read(particles.offset, p, 0, frame.origin)
        cut = 0.0
        for e in d:
            cut = 1.0 if e != 0.0 else cut
        A = pack(V, V * (particles.body[p] + 1), particles.excess[p, 0], cut)
        by = _moved(F, d) if is_number(quantity.gradient) else scaled(0.0, d)
        hoop = pack(0.0, V, 0.0, 0.0) if is_axial(frame) else ()
        return Share(A, (), _outward(V, by), (), (), hoop)


@inlined
def _moved(F, d):
    """Offset F d of a particle deformed by F, as many numbers as `d` has."""
    D = len(d)
    return tuple(sum(F[D * i + k] * d[k] for k in range(D)) for i in range(D))


def volume_sums(shape: object) -> VolumeSums:
    """Sums of volumes for particles of a shape, given by its parameters."""
    return VolumeSums() if isinstance(shape, BOXES) else VolumeSums(gradient=1.0)


@inlined
def _outward(V, d):
    """Vectors V (d_i, e_i) of as many directions as the offset `d` has."""
    return tuple(
        pack(V * each, *tuple(V if k == i else 0.0 for k in range(3))) for i, each in enumerate(d)
    )


@inlined
def _narrow(shape, frame, buffer, d, half, x, offset, vertex):
    """Store the weights of four cut boxes, from direction `d` on, in the buffer.

    Along `d` they begin at `vertex`.
    """
    if len(x) == 1:
        inverse = frame.inverse[d]
        f = (x[0] + offset[0] - frame.origin[d]) * inverse - (vertex - frame.ghost)
        w, g = cut_weights(shape, max(half[0] - abs(offset[0]) * inverse, MIN_HALF_WIDTH), f)
        keep_support(buffer, d, w, scaled(inverse, g))
    else:
        _narrow(shape, frame, buffer, d, half[:1], x[:1], offset[:1], vertex)
        first = first_vertex(frame, d + 1, half[1], x[1])
        _narrow(shape, frame, buffer, d + 1, half[1:], x[1:], offset[1:], first)


@inlined
def _narrow_ring(shape, frame, buffer, half, x, offset, vertex):
    """In axisymmetry, store the weights of four cut boxes along the radius."""
    if not is_axial(frame):
        return None
    inverse = frame.inverse[0]
    r = max((x[0] + offset[0]) * inverse, MIN_HALF_WIDTH)
    f = r - frame.origin[0] * inverse - (vertex - frame.ghost)
    left = min(max(half[0] - abs(offset[0]) * inverse, MIN_HALF_WIDTH), r)
    by, (w, g) = 1.0 / r, cut_weights(shape, left, f)
    first, ends = cut_moments(shape, left, f)
    keep_support(buffer, 0, plus_scaled(by, first, w), scaled(inverse, plus_scaled(by, ends, g)))
    keep_hoop(buffer, scaled(inverse * by, w))


@inlined
def cut_moments(shape, half, f):
    """As `pgimp.physics.shapes.base.moments`, for boxes as of `cut_weights`."""
    third = half * half * (1.0 / 3.0)
    if class_of(shape).vertices() == 3:
        K, e = _kink(half, f - 1.0)
        return (K - third, third - 2.0 * K, K), (e, -2.0 * e, e)
    K1, e1 = _kink(half, f - 1.0)
    K2, e2 = _kink(half, f - 2.0)
    return (
        (K1 - third, third - 2.0 * K1 + K2, K1 - 2.0 * K2, K2),
        (e1, e2 - 2.0 * e1, e1 - 2.0 * e2, e2),
    )


@inlined
def _kink(half, f):
    """Moment and end values, as of `moments`, of max(x, 0) over a box about f."""
    a, b, q = max(f + half, 0.0), max(f - half, 0.0), 0.25 / half
    A, B = a * a, b * b
    K = ((a * A - b * B) * (1.0 / 3.0) - 0.5 * (a - half) * (A - B)) * (2.0 * q)
    return K, 0.5 * (a + b) - (A - B) * q


@inlined
def cut_weights(shape, half, f):
    """Weights and gradients of boxes, including boxes without weight on the first vertex.

    As in `finite-gimp`.
    """
    if class_of(shape).vertices() == 3:
        t, u = max(1.0 + half - f, 0.0), max(1.0 - half - f, 0.0)
        a, b, q = max(f + half - 1.0, 0.0), max(f - half - 1.0, 0.0), 0.25 / half
        w0, w2 = (t * t - u * u) * q, (a * a - b * b) * q
        g0, g2 = -2.0 * (t - u) * q, 2.0 * (a - b) * q
        return (w0, 1.0 - w0 - w2, w2), (g0, -g0 - g2, g2)
    t, u = max(1.0 + half - f, 0.0), max(1.0 - half - f, 0.0)
    a1, b1 = max(f + half - 1.0, 0.0), max(f - half - 1.0, 0.0)
    a2, b2 = max(f + half - 2.0, 0.0), max(f - half - 2.0, 0.0)
    q = 0.25 / half
    w0, w3 = (t * t - u * u) * q, (a2 * a2 - b2 * b2) * q
    w2 = (a1 * a1 - b1 * b1) * q - 2.0 * w3
    g0, g3 = -2.0 * (t - u) * q, 2.0 * (a2 - b2) * q
    g2 = 2.0 * (a1 - b1) * q - 2.0 * g3
    return (w0, 1.0 - w0 - w2 - w3, w2, w3), (g0, -g0 - g2 - g3, g2, g3)
