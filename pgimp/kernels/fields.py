"""Velocity fields: how many there are in a plane, and where that of a particle's body begins.

Bodies that may meet have fields of their own, one behind the other in each plane of the grid. So
layers, planes and messages are those of one field, and only what takes a plane apart knows more.
"""

from pgimp.jit.kernel import inner_kernel, specialise
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
    # As long as there is one field, nothing is read.
    return lambda window, particles, p: (
        0 if window.stride[0] == field_size(window) else window.bodies[particles.body[p]]
    )


def share_field(window, particles, rows):
    """Whether four particles, in canonical order and in one cell, are of one field.

    In a cell particles follow each other by their bodies.
    """


@specialise(share_field)
def _share_field(window, particles, rows):
    if hasattr(window.types[3], "count"):  # ()
        return lambda window, particles, rows: True
    return lambda window, particles, rows: (
        window.stride[0] == field_size(window)
        or particles.body[rows[0]] == particles.body[rows[3]]
    )
