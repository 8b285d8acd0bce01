"""Velocity fields: their number in a plane, and the offset of a particle's field.

Bodies that may touch have separate fields, one after the other in each plane of the grid. So
layers, planes and messages are as for one field; only code that splits a plane handles several.
"""

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.vectors.simd import load, pack, store
from pgimp.kernels.data.record import RECORD


@inner_kernel
def field_size(window):
    """Distance of the fields of a plane, in float64."""
    return RECORD * window.extent[1] * window.extent[2]


def field_count(window):
    """Number of fields."""


@specialise(field_count)
def _field_count(window):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window: 1
    return lambda window: window.stride[0] // field_size(window)


def field_of(window, particles, p):
    """Offset of particle `p`'s field in a plane, in float64."""


@specialise(field_of)
def _field_of(window, particles, p):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window, particles, p: 0
    return lambda window, particles, p: (
        window.bodies[particles.body[p]] if len(window.bodies) else 0
    )


def move_to_fields(window, particles, rows, buffer, at):
    """Shift four offsets, in the buffer from `at` on, to the fields of their particles."""


@specialise(move_to_fields)
def _move_to_fields(window, particles, rows, buffer, at):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window, particles, rows, buffer, at: None

    def move(window, particles, rows, buffer, at):
        bodies, body = window.bodies, particles.body
        if len(bodies) > 0:
            begin = pack(
                bodies[body[rows[0]]],
                bodies[body[rows[1]]],
                bodies[body[rows[2]]],
                bodies[body[rows[3]]],
            )
            store(buffer, at, load(buffer, at) + begin)

    return move
