"""Marks of vertices: which velocity fields have mass there, as bits of a whole number."""

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.words import lowest_bit
from pgimp.kernels.data.record import MASS, RECORD
from pgimp.kernels.data.used_rows import next_rows, rows_with, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: Fields with a bit of their own; further ones share these. The bit behind them is set as well
#: where two fields at a vertex share one: so several fields always have several bits.
_BITS = 62


@inner_kernel
def has_several(mark):
    """Whether several fields have mass at a vertex with this mark."""
    return mark & (mark - 1) != 0


@inner_kernel
def mark_fields(field, i, marks):
    """Set the marks of plane `i`, see `Contact.marks`, in the rows that any field uses."""
    window, G, size = field.window, field.G, field_size(field.window)
    of_row = window.extent[2]
    own, left = marks[i].reshape(marks[i].size), rows_with(field, i, 1)
    while left:
        begin, end, left = next_rows(field, left)
        own[begin * of_row : end * of_row] = 0
    for f in range(field_count(window)):
        first, bit, left = i * window.stride[0] + f * size, 1 << f % _BITS, used_rows(field, i, f)
        while left:
            begin, end, left = next_rows(field, left)
            for v in range(begin * of_row, end * of_row):
                if G[first + v * RECORD + MASS] > 0.0:
                    twice = (own[v] & bit != 0) << _BITS
                    own[v] |= bit | twice


@inner_kernel
def fields_marked(window, mark, out):
    """List the fields that a vertex with this mark may have, ascending; returns how many."""
    count, most = 0, field_count(window)
    for first in range(0, most, _BITS):
        left = mark & ((1 << _BITS) - 1)
        while left:
            f = first + lowest_bit(left)
            left &= left - 1
            if f < most:
                out[count] = f
                count += 1
    return count
