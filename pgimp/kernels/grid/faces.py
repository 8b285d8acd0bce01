"""The conditions of all faces at one vertex.

Kernels get the faces as a table, so that they are compiled once for all sets of conditions.
"""

from typing import NamedTuple

from numba.core import types

from pgimp.jit.kernel import class_of, inlined, inner_kernel, is_number, of_types
from pgimp.jit.outside import NumbaObject
from pgimp.kernels.data.particles import FloatArray
from pgimp.physics.boundaries.base import constrain

#: Columns of `Faces.rows`: the condition's number, then its parameters, first axis and side.
KIND, PARAMETERS = 0, 1
_AXIS, _SIDE = PARAMETERS, PARAMETERS + 1


class Faces(NamedTuple):
    """The faces of a domain that have a condition; () stands for none."""

    #: tuple of NamedTuple: Parameters of each possible kind of condition; only their types matter.
    kinds: tuple
    #: (faces, n) float64: For each face the number of its kind, then its parameters one after the
    #: other: numbers, booleans, and entries of tuples.
    rows: FloatArray


@inlined
def face_count(faces):
    """Number of the faces."""
    if len(faces):
        return len(faces.rows)
    return 0


@inner_kernel
def side_of(faces, n):
    """Axis of face `n`, 0 to 2, and -1 or 1 for the low or the high end of it."""
    return int(faces.rows[n, _AXIS]), int(faces.rows[n, _SIDE])


@inner_kernel
def wall_of(faces, n, frame):
    """Number of the vertices on face `n` along its axis."""
    axis, side = side_of(faces, n)
    return frame.ghost if side < 0 else frame.ghost + frame.cells[axis]


@inner_kernel
def is_beyond(faces, n, frame, number):
    """Whether a vertex, given by its numbers, is on face `n` or beyond it."""
    axis, side = side_of(faces, n)
    return (number[axis] - wall_of(faces, n, frame)) * side >= 0


@inner_kernel
def box_of(faces, n, frame, window, i):
    """Vertices of plane `i` of a window on face `n` or beyond it: ranges along y and along z."""
    axis, side = side_of(faces, n)
    wall = wall_of(faces, n, frame)
    j0, j1, k0, k1 = 0, window.extent[1], 0, window.extent[2]
    if axis == 0:
        if (i + window.lower[0] - wall) * side < 0:
            j1 = 0
    elif axis == 1:
        if side < 0:
            j1 = min(j1, wall - window.lower[1] + 1)
        else:
            j0 = max(j0, wall - window.lower[1])
    elif side < 0:
        k1 = min(k1, wall - window.lower[2] + 1)
    else:
        k0 = max(k0, wall - window.lower[2])
    return j0, j1, k0, k1


@inner_kernel
def _is_on(faces, n, frame, number):
    """Whether a vertex is on face `n`."""
    return number[side_of(faces, n)[0]] == wall_of(faces, n, frame)


@inlined
def beyond_any(faces, count, frame, number):
    """Whether a vertex is on one of the first `count` faces or beyond it."""
    if len(faces):
        for n in range(count):
            if is_beyond(faces, n, frame, number):
                return True
        return False
    return False


@inlined
def _read(like, rows, n, at):
    """Read a value of the type of `like` from a row, from `at` on."""
    if is_number(like):
        return _type_of(like)(rows[n, at])
    if len(like) == 0:
        return ()
    width = _width(like[0])
    return (_read(like[0], rows, n, at), *_read(like[1:], rows, n, at + width))


@of_types
def _type_of(like: NumbaObject) -> type:
    """Python's type of a number."""
    return {types.boolean: bool, types.int64: int, types.float64: float}[like]


@of_types
def _width(like: NumbaObject) -> int:
    """Width of a value of a type in a row."""
    members: NumbaObject = like if isinstance(like, types.BaseTuple) else None
    return 1 if members is None else sum(map(_width, members))


@inlined
def constrained(kinds, k, rows, n, v, a, clearance):
    """Velocity and acceleration by the condition of face `n`, one of `kinds`, numbered from `k`."""
    if len(kinds) == 1 or int(rows[n, KIND]) == k:
        face = class_of(kinds[0])(*_read(kinds[0], rows, n, PARAMETERS))
        return constrain(face, v, a, clearance)
    return constrained(kinds[1:], k + 1, rows, n, v, a, clearance)


@inlined
def unilateral_walls(kinds, k, kind):
    """Whether number `kind` is a unilateral condition; `kinds` are numbered from `k`."""
    return any(
        hasattr(class_of(each), "approach") and kind == k + n for n, each in enumerate(kinds)
    )


@inlined
def on_walls(faces, frame, number):
    """Number of the faces that a vertex is on."""
    if len(faces) == 0:
        return 0
    count = 0
    for n in range(face_count(faces)):
        count += _is_on(faces, n, frame, number)
    return count


@inlined
def wall_sides(faces, frame, number):
    """For each direction -1 or 1 where the vertex is on a low or a high wall, else 0."""
    if len(faces) == 0:
        return (0, 0, 0)
    x, y, z = 0, 0, 0
    for n in range(len(faces.rows)):
        axis, side = side_of(faces, n)
        if _is_on(faces, n, frame, number):
            x += side * (axis == 0)
            y += side * (axis == 1)
            z += side * (axis == 2)
    return x, y, z
