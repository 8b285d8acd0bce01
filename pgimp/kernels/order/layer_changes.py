"""Particles that change their layer: partitioned by destination, packed, unpacked, sorted.

A particle's record holds all its columns, one after the other, bit by bit; an int32 is stored as an
int64.
"""

from pgimp.jit.kernel import kernel, separate_kernel
from pgimp.kernels.data.particles import OUTFLOW


@kernel
def partition_migrants(layer, order, ranks_in_order, first, layers, ring, kept, migrants):
    """Partition the particles that have changed their layer by whether they leave the slab.

    Parameters
    ----------
    layer : (c,) int32
        Of all particles; `OUTFLOW` marks particles without destination.
    order : (n,) int32
        Rows in canonical order.
    ranks_in_order : (k,) int32
        Offsets in `order`.
    first, layers : int
        The slab.
    ring : int
        Number of layers of a ring, where the layers below the lowest are the highest; else 0.
    kept, migrants : (k,) int32
        Filled with rows: `kept`, from its beginning, with particles that stay. `migrants` from its
        beginning with particles for the lower rank, back from its end for the upper rank.

    Returns
    -------
    stay, down, up : int
        Their numbers.
    """
    stay, down, up = 0, 0, 0
    for k in ranks_in_order:
        p = order[k]
        if layer[p] == OUTFLOW:
            continue
        above = layer[p] >= first + layers
        if not above and layer[p] >= first:
            kept[stay] = p
            stay += 1
            continue
        if ring > 0:
            above = (first - layer[p]) % ring != 1
        if not above:
            migrants[down] = p
            down += 1
        else:
            up += 1
            migrants[len(migrants) - up] = p
    return stay, down, up


@separate_kernel
def _pack(column, row, wire, at):
    """Write a row of a column from `at` on; returns the place behind it."""
    for i in range(column.shape[1]):
        wire[at + i] = column[row, i]
    return at + column.shape[1]


@separate_kernel
def _unpack(column, row, wire, at):
    """Set a row of a column from what `_pack` wrote; returns the place behind it."""
    for i in range(column.shape[1]):
        column[row, i] = wire[at + i]
    return at + column.shape[1]


@kernel
def pack_rows(words, halves, rows, wire, offset, width):
    """Write the records, of `width` numbers each, of the particles in `rows` from `offset` on.

    Parameters
    ----------
    words, halves : tuples of arrays
        See `Particles.columns`: of one type each in all scenes, so that this is compiled once.
    rows : (k,) int32
    wire : int64
        A message.
    """
    for k in range(len(rows)):
        at = offset + k * width
        for column in words:
            at = _pack(column, rows[k], wire, at)
        for column in halves:
            at = _pack(column, rows[k], wire, at)


@kernel
def unpack_rows(words, halves, rows, wire, offset, width):
    """Set the particles in `rows` from records that `pack_rows` wrote."""
    for k in range(len(rows)):
        at = offset + k * width
        for column in words:
            at = _unpack(column, rows[k], wire, at)
        for column in halves:
            at = _unpack(column, rows[k], wire, at)


@kernel
def sort_rows(layer, cell, number, rows, buffer):
    """Sort rows by (layer, cell, number); `buffer` has their length.

    A merge sort that skips pairs of pieces in order: rows come as a few sorted runs.
    """
    n = len(rows)
    length = 1
    while length < n:
        for low in range(0, n - length, 2 * length):
            middle, high = low + length, min(low + 2 * length, n)
            if not _after(layer, cell, number, rows[middle - 1], rows[middle]):
                continue
            for k in range(low, middle):  # an assignment of slices takes seconds to compile
                buffer[k] = rows[k]
            i, j = low, middle
            for k in range(low, high):
                if i < middle and (j == high or _after(layer, cell, number, rows[j], buffer[i])):
                    rows[k] = buffer[i]
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
