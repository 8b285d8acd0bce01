"""The conditions of all faces at one vertex."""

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.kernels.clearance import clearance_at
from pgimp.kernels.loads import given
from pgimp.physics.boundaries.base import constrain


@inner_kernel
def _beyond(face, frame, number):
    """Whether a vertex, given by its numbers, is on a face or beyond it."""
    wall = frame.ghost if face.side < 0 else frame.ghost + frame.cells[face.axis]
    return (number[face.axis] - wall) * face.side >= 0


@inner_kernel
def _is_on(face, frame, number):
    """Whether a vertex is on a face."""
    wall = frame.ghost if face.side < 0 else frame.ghost + frame.cells[face.axis]
    return number[face.axis] == wall


def beyond_any(faces, frame, number):
    """Whether a vertex is on one of the faces or beyond it."""


@specialise(beyond_any)
def _beyond_any(faces, frame, number):
    if len(faces) == 0:
        return lambda faces, frame, number: False
    return lambda faces, frame, number: (
        _beyond(faces[0], frame, number) or beyond_any(faces[1:], frame, number)
    )


def hold(faces, n, forcing, frame, number, r, v, a, mass, impulse):
    """Apply the conditions of all faces that a vertex is on or beyond, one after the other.

    A face's part of the momentum that the particles gain in a step is what its condition adds to
    it, see `given`; `impulse`, (faces, 3), grows by that, from row `n` on. The vertex's record is
    at `r`. Returns its velocity and acceleration.
    """


@specialise(hold)
def _hold(faces, n, forcing, frame, number, r, v, a, mass, impulse):
    if len(faces) == 0:
        return lambda faces, n, forcing, frame, number, r, v, a, mass, impulse: (v, a)

    def hold_first(faces, n, forcing, frame, number, r, v, a, mass, impulse):
        if _beyond(faces[0], frame, number):
            u, b, relaxation, dt = v, a, forcing.loads.relaxation, forcing.dt
            v, a = constrain(faces[0], v, a, clearance_at(forcing.clearances, n, r))
            for d in range(3):
                impulse[n, d] += given(relaxation, mass, dt, u[d], b[d], v[d], a[d])
        return hold(faces[1:], n + 1, forcing, frame, number, r, v, a, mass, impulse)

    return hold_first


def on_walls(faces, frame, number):
    """On how many of the faces a vertex is."""


@specialise(on_walls)
def _on_walls(faces, frame, number):
    if len(faces) == 0:
        return lambda faces, frame, number: 0

    return lambda faces, frame, number: (
        int(_is_on(faces[0], frame, number)) + on_walls(faces[1:], frame, number)
    )


def wall_sides(faces, frame, number):
    """For each direction -1 or 1 where the vertex is on a low or a high wall, else 0."""


@specialise(wall_sides)
def _wall_sides(faces, frame, number):
    if len(faces) == 0:
        return lambda faces, frame, number: (0, 0, 0)

    def sides(faces, frame, number):
        x, y, z = wall_sides(faces[1:], frame, number)
        axis, side = faces[0].axis, faces[0].side if _is_on(faces[0], frame, number) else 0
        return x + side * (axis == 0), y + side * (axis == 1), z + side * (axis == 2)

    return sides
