"""Rows of vertices that may be nonzero, by plane and velocity field.

A body fills a small part of its field's planes. So the rows along z with sums are noted, as bits in
`Field.used`, and others are left out. A scene that always has one field notes nothing.
"""

from math import floor

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import inlined, inner_kernel, kernel, of_types
from pgimp.jit.vectors.simd import lane, load, pack, store
from pgimp.jit.words import lowest_bit
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: Bits of an entry of `Field.used`, each for as many rows of vertices.
_BITS = 63


@inlined
def clear_plane(field, i):
    """Set plane `i` to zero; of several fields, only the used rows."""
    if is_single(field):
        plane = field.window.stride[0]
        field.G[i * plane : (i + 1) * plane] = 0.0
    else:
        window, size = field.window, field_size(field.window)
        for f in range(field_count(window)):
            left = used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                first = i * window.stride[0] + f * size
                field.G[first + begin * window.stride[1] : first + end * window.stride[1]] = 0.0
            field.used[i, f] = 0


@kernel
def clear_planes(field):
    """Set all planes to zero."""
    for i in range(len(field.active)):
        clear_plane(field, i)


@of_types
def is_single(field):
    """Whether scenes with such a `Field` always have one field."""
    return hasattr(field.types[field.fields.index("used")], "count")  # ()


@inlined
def used_rows(field, i, f):
    """Bits of the rows of field `f` of plane `i` that may be nonzero, see `next_rows`."""
    if is_single(field):
        return 1
    if len(field.window.bodies) == 0:
        ny = field.window.extent[1]
        return (1 << (ny + rows_of_bit(field.window) - 1) // rows_of_bit(field.window)) - 1
    return field.used[i, f]


@inlined
def next_rows(field, left):
    """The first run of rows of some bits: its beginning, its end, and the bits behind it."""
    if is_single(field):
        return (0, field.window.extent[1], 0)
    each, ny = rows_of_bit(field.window), field.window.extent[1]
    first = lowest_bit(left)
    count = lowest_bit(~(left >> first))
    left &= ~(((1 << count) - 1) << first)
    return first * each, min((first + count) * each, ny), left


@inlined
def next_bit(field, left):
    """The rows of the first of some bits: beginning, end, that bit, and the others."""
    if is_single(field):
        return (0, field.window.extent[1], 1, 0)
    each, first = rows_of_bit(field.window), lowest_bit(left)
    end = min((first + 1) * each, field.window.extent[1])
    return first * each, end, 1 << first, left & (left - 1)


@inner_kernel
def rows_of_bit(window):
    """Number of rows for which a bit of `Field.used` stands."""
    return (window.extent[1] + _BITS - 1) // _BITS


@inner_kernel
def rows_with(field, i, least):
    """Bits of the rows of plane `i` in which at least one, or two, fields may be nonzero."""
    once, twice = 0, 0
    for f in range(field_count(field.window)):
        rows = used_rows(field, i, f)
        twice |= once & rows
        once |= rows
    return once if least == 1 else twice


@inner_kernel
def fields_with(field, i, bit, out):
    """List the fields of plane `i` that may be nonzero in the rows of a bit; returns how many."""
    count = 0
    for f in range(field_count(field.window)):
        if used_rows(field, i, f) & bit:
            out[count] = f
            count += 1
    return count


@inner_kernel
def is_used(field, i, f):
    """Whether field `f` of plane `i` may be nonzero."""
    return used_rows(field, i, f) != 0


@inlined
def use(field, i, low, high):
    """Note that plane `i` is not zero between `low` and `high`, in float64 from its beginning."""
    if is_single(field):
        return None
    return note_range(field.window, field.used[i], low, high)


@inner_kernel
def note_range(window, used, low, high):
    """Note the rows between `low` and `high` in `used`, an entry by field."""
    size, span = field_size(window), rows_of_bit(window) * window.stride[1]
    for f in range(low // size, (high - 1) // size + 1):
        first = max(low - f * size, 0) // span
        last = (min(high - f * size, size) - 1) // span
        used[f] |= (2 << last) - (1 << first)


@inlined
def use_layer(field, low, high):
    """Note that a layer's own planes are not zero between `low` and `high`."""
    if is_single(field):
        return None
    if high > low:
        note_range(field.window, field.used[len(field.active)], low, high)


@inlined
def layer_marks(field, vertices, D):
    """What `mark_supports` needs to mark rows in a layer's own planes; () with a single field."""
    if is_single(field):
        return ()
    window = field.window
    reach = (vertices - 1) * window.stride[1] if D > 1 else 0
    span = rows_of_bit(window) * window.stride[1]
    return float(field_size(window)), 1.0 / span, reach, field.used[len(field.active)]


@inlined
def mark_supports(marks, window, offsets):
    """Mark the rows of four supports, whose first vertices are at `offsets` in a plane, a Vec4."""
    if len(marks) == 0:
        return None
    if len(window.bodies) == 0:
        return
    size, by_span, reach, used = marks
    # By products, as quotients are slow; half a record is far from rounding.
    middle = offsets + 0.5 * RECORD
    fields = floor(middle * (1.0 / size))
    rows = middle - fields * size
    first, last = floor(rows * by_span), floor((rows + reach) * by_span)
    for j in range(4):
        used[int(lane(fields, j))] |= (2 << int(lane(last, j))) - (1 << int(lane(first, j)))


@inlined
def add_layer(field, source, target, low, high):
    """Add a layer's own plane at `source` to plane `target` where it is used, leaving zeros."""
    if is_single(field):
        _add_between(field, source, target * field.window.stride[0], low, high)
    else:
        window, layer = field.window, len(field.active)
        if len(window.bodies) == 0:
            _add_between(field, source, target * window.stride[0], low, high)
            if high > 0:
                field.used[target, 0] = 1
            return
        for f in range(field_count(window)):
            left = field.used[layer, f]
            field.used[target, f] |= left
            while left:
                begin, end, left = next_rows(field, left)
                first = f * field_size(window)
                _add_between(
                    field,
                    source,
                    target * window.stride[0],
                    first + begin * window.stride[1],
                    first + end * window.stride[1],
                )


@inner_kernel
def _add_between(field, source, target, low, high):
    """Add entries `low` to `high` from `source` on in `scratch` to `G`, leaving zeros."""
    G, scratch, zero = field.G, field.scratch, pack(0.0, 0.0, 0.0, 0.0)
    for i in range(low, high, 4):
        store(G, target + i, load(G, target + i) + load(scratch, source + i))
        store(scratch, source + i, zero)


@inlined
def end_layer(field):
    """Forget the marks of a layer's own planes."""
    if is_single(field):
        return None
    field.used[len(field.active)] = 0
