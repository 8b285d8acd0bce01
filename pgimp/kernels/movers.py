"""Particles that change their layer: sorted out by where they go, packed, unpacked, put in order.

A particle's record holds all its columns, one after the other, whole numbers bit by bit. `wire` and
`bits` are the same memory, as float64 and as int64.
"""

from pgimp.kernels.g2p import GONE
from pgimp.kernels.jit import kernel, specialise


@kernel
def sort_out(layer, order, places, first, layers, staying, leaving):
    """Sort the particles that have changed their layer by whether they leave the slab.

    Parameters
    ----------
    layer : (c,) int32
        Of all particles; `GONE` marks those that go nowhere.
    order : (n,) int32
        Rows in canonical order.
    places : (k,) int32
        Places in `order`.
    first, layers : int
        The slab.
    staying, leaving : (k,) int32
        Filled with rows: from the beginning of `staying`, those that stay; from that of `leaving`,
        those that go to the rank below, and back from its end those that go to the rank above.

    Returns
    -------
    stay, down, up : int
        Their numbers.
    """
    stay, down, up = 0, 0, 0
    for place in places:
        p = order[place]
        if layer[p] == GONE:
            continue
        if layer[p] < first:
            leaving[down] = p
            down += 1
        elif layer[p] >= first + layers:
            up += 1
            leaving[len(leaving) - up] = p
        else:
            staying[stay] = p
            stay += 1
    return stay, down, up


def _put(columns, p, wire, bits, place):
    """Write row `p` of all columns to `place` and on."""


@specialise(_put)
def _put_each(columns, p, wire, bits, place):
    if len(columns) == 0:
        return lambda columns, p, wire, bits, place: None
    flat, whole = columns[0].ndim == 1, columns[0].dtype.name.startswith("int")

    def put(columns, p, wire, bits, place):
        column = columns[0]
        to = bits if whole else wire
        if flat:
            to[place] = column[p]
            _put(columns[1:], p, wire, bits, place + 1)
        else:
            for i in range(column.shape[1]):
                to[place + i] = column[p, i]
            _put(columns[1:], p, wire, bits, place + column.shape[1])

    return put


def _take(columns, p, wire, bits, place):
    """Set row `p` of all columns from what `_put` wrote."""


@specialise(_take)
def _take_each(columns, p, wire, bits, place):
    if len(columns) == 0:
        return lambda columns, p, wire, bits, place: None
    flat, whole = columns[0].ndim == 1, columns[0].dtype.name.startswith("int")

    def take(columns, p, wire, bits, place):
        column = columns[0]
        source = bits if whole else wire
        if flat:
            column[p] = source[place]
            _take(columns[1:], p, wire, bits, place + 1)
        else:
            for i in range(column.shape[1]):
                column[p, i] = source[place + i]
            _take(columns[1:], p, wire, bits, place + column.shape[1])

    return take


@kernel
def pack_rows(particles, rows, wire, bits, place, width):
    """Write the records, of `width` numbers each, of the particles in `rows` from `place` on."""
    for k in range(len(rows)):
        _put(particles, rows[k], wire, bits, place + k * width)


@kernel
def unpack_rows(particles, rows, wire, bits, place, width):
    """Set the particles in `rows` from records that `pack_rows` wrote."""
    for k in range(len(rows)):
        _take(particles, rows[k], wire, bits, place + k * width)


@kernel
def sort_rows(layer, cell, number, rows, room):
    """Sort rows by (layer, cell, number), with `room` for as many.

    Merges pieces twice as long each time, and only where they are not in order: rows come as a few
    runs, each of which is.
    """
    n = len(rows)
    length = 1
    while length < n:
        for low in range(0, n - length, 2 * length):
            middle, high = low + length, min(low + 2 * length, n)
            if not _after(layer, cell, number, rows[middle - 1], rows[middle]):
                continue
            room[low:middle] = rows[low:middle]
            i, j = low, middle
            for k in range(low, high):
                if i < middle and (j == high or _after(layer, cell, number, rows[j], room[i])):
                    rows[k] = room[i]
                    i += 1
                else:
                    rows[k] = rows[j]
                    j += 1
        length *= 2


@kernel
def _after(layer, cell, number, a, b):
    """Whether row `a` comes after row `b`."""
    if layer[a] != layer[b]:
        return layer[a] > layer[b]
    if cell[a] != cell[b]:
        return cell[a] > cell[b]
    return number[a] > number[b]
