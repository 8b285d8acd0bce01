"""Reference vertices: vertices of the reference grid near contact, in the initial configuration.

The key of a vertex combines its numbers in the whole grid and the velocity field, equal on all
ranks. Each has bits of its own: to read them by divisions takes several times as long.
"""

from typing import NamedTuple

from numpy.typing import NDArray

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.kernels.data.motion import keeps
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import ACCELERATION, MASS, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.conditions import held_velocity

#: A face of the domain: direction, side, position along that direction as a vertex number, number
#: of the face.
FACE_PLANE = structure(("axis", "i8"), ("side", "i8"), ("vertex", "i8"), ("face", "i8"))

#: A reference vertex: velocity and mass, inverse mass by component (0 if held by a face or a
#: constraint), and the velocity before the step. Vectors of four numbers, see `NUMBERS`.
REFERENCE_VERTEX = structure(
    ("velocity", "f8", 3),
    ("mass", "f8"),
    ("inverse_mass", "f8", 3),
    ("_", "f8"),
    ("velocity_before", "f8", 3),
    ("__", "f8"),
)

#: Numbers in a reference vertex, and the first ones of its vectors.
NUMBERS, OF_VELOCITY, OF_INVERSE_MASS, OF_VELOCITY_BEFORE = 12, 0, 4, 8


class ReferenceVertices(NamedTuple):
    """Data of reference vertices."""

    keys: IntArray  #: (m,) int64.
    values: NDArray  #: (m,) REFERENCE_VERTEX.


class Changes(NamedTuple):
    """What impulses change at reference vertices."""

    keys: IntArray  #: (m,) int64: The vertices.
    velocities: FloatArray  #: (m, 3) float64: Changes of their velocities.
    held: FloatArray  #: (m, 3) float64: Impulses that faces and constraints bear.


@inner_kernel
def key_bits(frame, fields):
    """Bits of a key for a vertex's numbers along y and z, and for one of `fields` fields."""
    y, z, f, more = 0, 0, 0, 1 + 2 * frame.ghost
    D = len(frame.cell)
    while D > 1 and 1 << y < frame.cells[min(1, D - 1)] + more:
        y += 1
    while D > 2 and 1 << z < frame.cells[min(2, D - 1)] + more:
        z += 1
    while 1 << f < fields:
        f += 1
    return y, z, f


@inner_kernel
def key_of_vertex(bits, number, field):
    """Key of a vertex, given by its numbers, for a velocity field; `bits` are from `key_bits`."""
    return ((((number[0] << bits[0]) + number[1]) << bits[1]) + number[2] << bits[2]) + field


@inner_kernel
def depth(plane, number):
    """Vertices, along its axis, from a face outwards to a vertex, given by its numbers."""
    return (number[plane.axis] - plane.vertex) * plane.side


@kernel
def read_reference_vertices(holding, field, keys, values):
    """Copy reference vertices.

    Parameters
    ----------
    holding : Holding
        Faces and constraints.
    field : Field
        After the update of momentum.
    keys : (m,) int64
        Their keys.
    values : (m,) REFERENCE_VERTEX
        Set here.
    """
    frame, forcing, G = holding.frame, holding.forcing, field.G
    D, bits = len(frame.origin), key_bits(frame, field_count(field.window))
    for n in range(len(keys)):
        row = values[n]
        row.mass = row._ = row.__ = 0.0
        for d in range(3):
            row.velocity[d] = row.inverse_mass[d] = row.velocity_before[d] = 0.0
        r, number = offset_of_key(field, bits, keys[n])
        if r < 0:  # rounding gives it weight, but no mass
            continue
        m, v = G[r + MASS], (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
        row.mass = m
        u = held_velocity(holding, number, r, v, True)
        for d in range(3):
            row.velocity[d] = v[d]
            row.velocity_before[d] = v[d] - forcing.dt * G[r + ACCELERATION + d]
            if d < D and m > forcing.mass_cutoff:
                pushed = tuple(v[e] + (1.0 if d == e else 0.0) for e in range(3))
                s = held_velocity(holding, number, r, pushed, True)
                row.inverse_mass[d] = 0.0 if s[d] == u[d] else 1.0 / m


@inner_kernel
def offset_of_key(field, bits, key):
    """Offset of a vertex's record on a rank, -1 without one, and the vertex's numbers."""
    window, rest = field.window, key >> bits[2]
    size, one, line = field_size(window), key & (1 << bits[2]) - 1, rest >> bits[1]
    number = (line >> bits[0], line & (1 << bits[0]) - 1, rest & (1 << bits[1]) - 1)
    x, y, z = number[0] - window.lower[0], number[1] - window.lower[1], number[2] - window.lower[2]
    if x < 0 or x >= len(field.active) or y < 0 or y >= window.extent[1]:
        return -1, number
    if z < 0 or z >= window.extent[2] or field.active[x] == 0:
        return -1, number
    return x * window.stride[0] + one * size + y * window.stride[1] + z * window.stride[2], number


@kernel
def change_velocities(frame, field, changes, forcing, work):
    """Change velocities and accelerations of the vertices on a rank.

    Parameters
    ----------
    changes : Changes
        The keys of vertices of all ranks, and the changes of their velocities.
    forcing : Forcing
        Gravity, whose work was booked with the old velocities.
    work : (planes,) float64
        Grows by the changes' share of that work.
    """
    G, dt, gravity = field.G, forcing.dt, forcing.gravity
    bits = key_bits(frame, field_count(field.window))
    for n in range(len(changes.keys)):
        r, number = offset_of_key(field, bits, changes.keys[n])
        if r < 0:
            continue
        power = 0.0
        for d in range(3):
            change = changes.velocities[n, d]
            G[r + VELOCITY + d] += change
            G[r + ACCELERATION + d] += change / dt
            power += gravity[d] * change
        i = number[0] - field.window.lower[0]
        if i < field.owned:
            work[i] += dt * G[r + MASS] * power


@kernel
def add_accelerations(frame, field, keys, accelerations, A, reach):
    """Add accelerations of some reference vertices to those of a rank's vertices.

    Parameters
    ----------
    keys : (m,) int64
        The keys of vertices of all ranks.
    accelerations : (m, 3) float64
        What contact adds there.
    A, reach
        See `pgimp.kernels.lagrangian.averaged_mass.find_accelerations`.
    """
    window, half = field.window, field.window.stride[0] // 2
    fields = field_count(window)
    bits = key_bits(frame, fields)
    for n in range(len(keys)):
        r, _ = offset_of_key(field, bits, keys[n])
        f = keys[n] & (1 << bits[2]) - 1
        if r < 0 or f >= fields or not keeps(field.motion, f):
            continue
        for d in range(3):
            A[reach * half + r // 2 + 1 + d] += accelerations[n, d]
