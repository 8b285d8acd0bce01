"""Vertices beyond a face, and the vertices inside that stand for them: mirrors and seams.

A rank stores the vertices on the high face of a periodic direction and beyond it, where supports
at the seam end, besides those that they are: the ones on the low face and inside. Across x the
exchange between ranks does that (`pgimp.decomposition.halo`).
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel


class Images(NamedTuple):
    """Images of the vertices beyond a face: of one that reflects or absorbs, or of a seam."""

    #: axis, side: The face: direction, and -1 for its low end or 1 for its high end.
    axis: int
    side: int
    number: int  #: Its number among all faces with a condition; 6 more than the axis for a seam.
    #: Whether it is unilateral: nothing is reflected beyond a vertex that moves away.
    releases: bool
    sticks: bool  #: Whether all components are reversed, not only the one across it.
    #: Whether nothing is reversed. Without a period, vertices beyond it have the vertex on it as
    #: their image.
    follows: bool = False
    #: Cells from a vertex on the face, or beyond it, to its image; 0 unless it is a seam.
    period: int = 0

    @classmethod
    def of_seam(cls, axis: int, cells: int) -> "Images":
        """The images at the seam of a periodic direction with so many cells."""
        return cls(axis, 1, 6 + axis, False, False, True, cells)


class Image(NamedTuple):
    """A vertex beyond a face, and the vertex inside that stands for it."""

    plane: int  #: The vertex's plane.
    #: beyond, inside: Offsets of both records; -1 if there is no image in the window, or in an
    #: active plane: then the vertex has no weight.
    beyond: int
    inside: int
    wall: int  #: Offset of the record between them, on the face.


@inner_kernel
def _range_beyond(frame, window, images, d):
    """First vertex along direction `d` that may lie beyond the face, and the number of them."""
    if d != images.axis:
        return 0, window.extent[d]
    if images.side < 0:
        return 0, min(window.extent[d], max(0, frame.ghost - window.lower[d]))
    on_face = 1 if images.period > 0 else 0
    first = max(0, frame.ghost + frame.cells[d] + 1 - on_face - window.lower[d])
    return first, max(0, window.extent[d] - first)


@inner_kernel
def box_beyond(frame, window, images):
    """First of the window's vertices that may lie beyond the face, and their number, by axis."""
    return (
        _range_beyond(frame, window, images, 0),
        _range_beyond(frame, window, images, 1),
        _range_beyond(frame, window, images, 2),
    )


@inner_kernel
def beyond_count(frame, window, images):
    """Number of the window's vertices that may lie beyond the face."""
    (_, x), (_, y), (_, z) = box_beyond(frame, window, images)
    return x * y * z


@inner_kernel
def image_of(frame, field, images, begin, n):
    """The `n`-th vertex beyond the face and its image.

    Offsets are in the velocity field that starts at `begin` in each plane.
    """
    (i0, _), (j0, y), (k0, z) = box_beyond(frame, field.window, images)
    i, j, k = i0 + n // (y * z), j0 + n // z % y, k0 + n % z
    return image_at(frame, field, images, begin, i, j, k)


@inner_kernel
def offset_of(window, begin, i, j, k):
    """Offset of the record of a vertex of the window."""
    return begin + i * window.stride[0] + j * window.stride[1] + k * window.stride[2]


@inner_kernel
def image_at(frame, field, images, begin, i, j, k):
    """A vertex beyond the face and its image, see `image_of`."""
    window, axis, side = field.window, images.axis, images.side
    if field.active[i] == 0:
        return Image(i, -1, -1, -1)
    number = window.lower[axis] + (i if axis == 0 else (j if axis == 1 else k))
    wall = frame.ghost if side < 0 else frame.ghost + frame.cells[axis]
    away = number - wall
    shift = -away if images.follows else -2 * away
    if images.period > 0:
        shift = -images.period
    image = number - window.lower[axis] + shift
    if image < 0 or image >= window.extent[axis]:
        return Image(i, -1, -1, -1)
    if axis == 0 and field.active[image] == 0:
        return Image(i, -1, -1, -1)
    beyond = offset_of(window, begin, i, j, k)
    step = shift * window.stride[axis]
    on_wall = beyond + step if images.follows else beyond + step // 2
    return Image(i, beyond, beyond + step, on_wall)


@inner_kernel
def mark_of(images):
    """What a vertex beyond the face has in place of its mass, while its image has its sums."""
    return -1.0 - images.number


@inner_kernel
def reverses(images, d):
    """Whether an image has component `d` of a vector reversed."""
    return (images.sticks or d == images.axis) and not images.follows
