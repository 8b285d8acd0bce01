"""Vertices beyond a face that reflects, and the vertices inside that stand for them."""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel


class Image(NamedTuple):
    """A vertex beyond a face, and the vertex inside that stands for it.

    Attributes
    ----------
    plane : int
        The vertex's plane.
    beyond, inside : int
        Offsets of both records; -1 if there is no image in the window, or in an active plane: then
        the vertex has no weight.
    wall : int
        Offset of the record between them, on the face.
    """

    plane: int
    beyond: int
    inside: int
    wall: int


@inner_kernel
def _range_beyond(frame, window, mirror, d):
    """First vertex along direction `d` that may lie beyond the face, and the number of them."""
    if d != mirror.axis:
        return 0, window.extent[d]
    if mirror.side < 0:
        return 0, min(window.extent[d], max(0, frame.ghost - window.lower[d]))
    first = max(0, frame.ghost + frame.cells[d] + 1 - window.lower[d])
    return first, max(0, window.extent[d] - first)


@inner_kernel
def box_beyond(frame, window, mirror):
    """First of the window's vertices that may lie beyond the face, and their number, by axis."""
    return (
        _range_beyond(frame, window, mirror, 0),
        _range_beyond(frame, window, mirror, 1),
        _range_beyond(frame, window, mirror, 2),
    )


@inner_kernel
def beyond_count(frame, window, mirror):
    """Number of the window's vertices that may lie beyond the face."""
    (_, x), (_, y), (_, z) = box_beyond(frame, window, mirror)
    return x * y * z


@inner_kernel
def image_of(frame, field, mirror, begin, n):
    """The `n`-th vertex beyond the face and its image.

    Offsets are in the velocity field that starts at `begin` in each plane.
    """
    (i0, _), (j0, y), (k0, z) = box_beyond(frame, field.window, mirror)
    i, j, k = i0 + n // (y * z), j0 + n // z % y, k0 + n % z
    return image_at(frame, field, mirror, begin, i, j, k)


@inner_kernel
def offset_of(window, begin, i, j, k):
    """Offset of the record of a vertex of the window."""
    return begin + i * window.stride[0] + j * window.stride[1] + k * window.stride[2]


@inner_kernel
def image_at(frame, field, mirror, begin, i, j, k):
    """A vertex beyond the face and its image, see `image_of`."""
    window, axis, side = field.window, mirror.axis, mirror.side
    if field.active[i] == 0:
        return Image(i, -1, -1, -1)
    number = window.lower[axis] + (i if axis == 0 else (j if axis == 1 else k))
    wall = frame.ghost if side < 0 else frame.ghost + frame.cells[axis]
    away = number - wall
    shift = -away if mirror.follows else -2 * away
    image = number - window.lower[axis] + shift
    if image < 0 or image >= window.extent[axis]:
        return Image(i, -1, -1, -1)
    if axis == 0 and field.active[image] == 0:
        return Image(i, -1, -1, -1)
    beyond = offset_of(window, begin, i, j, k)
    step = shift * window.stride[axis]
    on_wall = beyond + step if mirror.follows else beyond + step // 2
    return Image(i, beyond, beyond + step, on_wall)
