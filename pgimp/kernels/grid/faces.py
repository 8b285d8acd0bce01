"""The conditions of all faces at one vertex.

Kernels get the faces as a table, so that they are compiled once for all sets of conditions.
"""

from typing import NamedTuple

from numba.core import types

from pgimp.jit.kernel import inlined, inner_kernel, specialise
from pgimp.jit.outside import NumbaObject
from pgimp.kernels.data.particles import FloatArray
from pgimp.physics.boundaries.base import constrain

#: Columns of `Faces.rows`: the condition's number, then its parameters, first axis and side.
KIND, PARAMETERS = 0, 1
_AXIS, _SIDE = PARAMETERS, PARAMETERS + 1


class Faces(NamedTuple):
    """The faces of a domain that have a condition; () stands for none.

    Attributes
    ----------
    kinds : tuple of NamedTuple
        Parameters of each possible kind of condition; only their types matter.
    rows : (faces, n) float64
        For each face the number of its kind, then its parameters one after the other: numbers,
        booleans, and entries of tuples.
    """

    kinds: tuple
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


def _read(like, rows, n, at):
    """Read a value of the type of `like` from a row, from `at` on."""


def _width(like: NumbaObject) -> int:
    """Width of a value of a type in a row."""
    members: NumbaObject = like if isinstance(like, types.BaseTuple) else None
    return 1 if members is None else sum(map(_width, members))


@specialise(_read)
def _read_value(like, rows, n, at):
    if isinstance(like, types.Boolean):
        return lambda like, rows, n, at: rows[n, at] != 0.0
    if isinstance(like, types.Integer):
        return lambda like, rows, n, at: int(rows[n, at])
    if isinstance(like, types.Float):
        return lambda like, rows, n, at: rows[n, at]
    if len(like) == 0:
        return lambda like, rows, n, at: ()
    width = _width(like[0])
    return lambda like, rows, n, at: (
        _read(like[0], rows, n, at),
        *_read(like[1:], rows, n, at + width),
    )


def constrained(kinds, k, rows, n, v, a, clearance):
    """Velocity and acceleration by the condition of face `n`, one of `kinds`, numbered from `k`."""


@specialise(constrained)
def _constrained_by(kinds, k, rows, n, v, a, clearance):
    kind = kinds[0].instance_class

    def of_kind(kinds, k, rows, n, v, a, clearance):
        return constrain(kind(*_read(kinds[0], rows, n, PARAMETERS)), v, a, clearance)

    def of_one(kinds, k, rows, n, v, a, clearance):
        if int(rows[n, KIND]) == k:
            return constrain(kind(*_read(kinds[0], rows, n, PARAMETERS)), v, a, clearance)
        return constrained(kinds[1:], k + 1, rows, n, v, a, clearance)

    return of_one if len(kinds) > 1 else of_kind


def unilateral_walls(kinds, k, kind):
    """Whether number `kind` is a unilateral condition; `kinds` are numbered from `k`."""


@specialise(unilateral_walls)
def _lets_go(kinds, k, kind):
    if len(kinds) == 0:
        return lambda kinds, k, kind: False
    if hasattr(kinds[0].instance_class, "approach"):
        return lambda kinds, k, kind: kind == k or unilateral_walls(kinds[1:], k + 1, kind)
    return lambda kinds, k, kind: unilateral_walls(kinds[1:], k + 1, kind)


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
