"""Velocity fields: how many there are in a plane, and where that of a particle's body begins.

Bodies that may meet have fields of their own, one behind the other in each plane of the grid. So
layers, planes and messages are those of one field, and only what takes a plane apart knows more.
"""

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.simd import load, pack, store
from pgimp.kernels.record import RECORD


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
    """Where the field of particle `p` begins in a plane, in float64."""


@specialise(field_of)
def _field_of(window, particles, p):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window, particles, p: 0
    return lambda window, particles, p: (
        window.bodies[particles.body[p]] if len(window.bodies) else 0
    )


def move_to_fields(window, particles, rows, buffer, at):
    """Move four places, which the buffer has from `at` on, to where their particles' fields begin."""


@specialise(move_to_fields)
def _move_to_fields(window, particles, rows, buffer, at):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window, particles, rows, buffer, at: None

    def move(window, particles, rows, buffer, at):
        bodies, body = window.bodies, particles.body
        if len(bodies) > 0:
            begin = pack(
                bodies[body[rows[0]]], bodies[body[rows[1]]], bodies[body[rows[2]]],
                bodies[body[rows[3]]],
            )  # fmt: skip
            store(buffer, at, load(buffer, at) + begin)

    return move
