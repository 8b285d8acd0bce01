"""Velocity fields: their number in a plane, and the offset of a particle's field.

Bodies that may touch have separate fields, one after the other in each plane of the grid. So
layers, planes and messages are as for one field; only code that splits a plane handles several.
"""

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.vectors.simd import load, pack, store
from pgimp.kernels.data.record import RECORD

#: The last bit of `Field.used` stands for all fields from this one on.
_LAST = 62


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


def clear_plane(field, i):
    """Set plane `i` to zero; of several fields, only the used ones."""


@specialise(clear_plane)
def _clear_plane(field, i):
    def clear(field, i):
        plane = field.window.stride[0]
        field.G[i * plane : (i + 1) * plane] = 0.0

    def clear_used(field, i):
        size = field_size(field.window)
        for f in range(field_count(field.window)):
            if is_used(field, i, f):
                begin = i * field.window.stride[0] + f * size
                field.G[begin : begin + size] = 0.0
        field.used[i] = 0

    return clear if _is_single(field) else clear_used


def _is_single(field):
    """Whether scenes with such a `Field` always have one field."""
    return hasattr(field.types[field.fields.index("used")], "count")  # ()


def is_used(field, i, f):
    """Whether field `f` of plane `i` may be nonzero."""


@specialise(is_used)
def _is_used(field, i, f):
    if _is_single(field):
        return lambda field, i, f: True
    return lambda field, i, f: (
        len(field.window.bodies) == 0 or field.used[i] >> min(f, _LAST) & 1 != 0
    )


def use(field, i, low, high):
    """Note that plane `i` is not zero between `low` and `high`, in float64 from its beginning."""


@specialise(use)
def _use(field, i, low, high):
    def note(field, i, low, high):
        size = field_size(field.window)
        for f in range(low // size, (high - 1) // size + 1):
            field.used[i] |= 1 << min(f, _LAST)

    return (lambda field, i, low, high: None) if _is_single(field) else note


@inner_kernel
def has_several(field, i):
    """Whether bodies of several fields may have mass in plane `i`."""
    used = field.used[i]
    return used & (used - 1) != 0 or used >> _LAST != 0
