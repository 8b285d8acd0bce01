"""Velocity fields: their number in a plane, and the offset of a particle's field.

Bodies that may touch have separate fields, one after the other in each plane of the grid. So
layers, planes and messages are as for one field; only code that splits a plane handles several.
"""

from pgimp.jit.kernel import inlined, inner_kernel, is_empty
from pgimp.jit.vectors.simd import load, pack, store
from pgimp.kernels.data.record import RECORD


@inner_kernel
def field_size(window):
    """Distance of the fields of a plane, in float64."""
    return RECORD * window.extent[1] * window.extent[2]


@inlined
def field_count(window):
    """Number of fields."""
    if is_empty(window.bodies):
        return 1
    return window.stride[0] // field_size(window)


@inlined
def field_of(window, particles, p):
    """Offset of particle `p`'s field in a plane, in float64."""
    if is_empty(window.bodies):
        return 0
    return window.bodies[particles.body[p]] if len(window.bodies) else 0


@inlined
def move_to_fields(window, particles, rows, buffer, at):
    """Shift four offsets, in the buffer from `at` on, to the fields of their particles."""
    if is_empty(window.bodies):
        return None
    bodies, body = window.bodies, particles.body
    if len(bodies) > 0:
        begin = pack(
            bodies[body[rows[0]]],
            bodies[body[rows[1]]],
            bodies[body[rows[2]]],
            bodies[body[rows[3]]],
        )
        store(buffer, at, load(buffer, at) + begin)
