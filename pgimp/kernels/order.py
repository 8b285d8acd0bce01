"""Canonical order: (layer now, cell at the last re-sort, id)."""

from pgimp.kernels.jit import kernel
from pgimp.kernels.transfer import first_vertex, half_widths
from pgimp.shapes.base import size


@kernel
def locate(shape, frame, particles, rows, vertices):
    """Set `layer` and `cell` of the particles in `rows`, from their positions.

    `cell` numbers the first vertex of the support row-major over the whole grid, so that sorting
    by it keeps the particles of one support together; `vertices` is the grid's size by direction.
    """
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        cell = 0
        for d in range(len(vertices)):
            cell = cell * vertices[d] + first_vertex(frame, d, half[d], particles.x[p, d])
        particles.cell[p] = cell
        particles.layer[p] = first_vertex(frame, 0, half[0], particles.x[p, 0])


@kernel
def layers_of(shape, frame, identity, x, layers):
    """Set `layers`, (n,) int64, to those of undeformed particles at coordinates `x` along x."""
    for i in range(len(x)):
        layers[i] = first_vertex(frame, 0, size(shape, frame.cell, identity)[0][0], x[i])


@kernel
def reach_of(shape, frame, particles, rows, reach):
    """Grow `reach`, (2, 2) int64, to the first vertices (least, greatest; y, z) of `rows`."""
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        for d in range(1, len(frame.origin)):
            j = first_vertex(frame, d, half[d], particles.x[p, d])
            reach[0, d - 1] = min(reach[0, d - 1], j)
            reach[1, d - 1] = max(reach[1, d - 1], j)


@kernel
def merge(particles, order, start, left, first, arrivals, order_out, start_out):
    """Restore the canonical order after particles have changed their layers.

    Between the changes, whole runs of the old order are copied: a change costs a binary search.

    Parameters
    ----------
    order, start
        The old order; `start` holds the beginnings of the layers ``first, first + 1, ...``.
    left : (k,) int32
        Places in `order` of the particles that have left their layer, ascending.
    arrivals : (l,) int32
        Rows of the particles that have come into a layer, in canonical order among themselves.
    order_out, start_out
        The new order.

    Returns
    -------
    int
        Number of particles in the new order.
    """
    n, a, gone = 0, 0, 0
    for j in range(len(start) - 1):
        start_out[j] = n
        k, end = start[j], start[j + 1]
        place = -1  # where the next arrival belongs; -1 when not yet known
        while True:
            if place < 0:
                place = end + 1
                if a < len(arrivals) and particles.layer[arrivals[a]] == first + j:
                    place = _place(particles, order, k, end, arrivals[a])
            leaves = left[gone] if gone < len(left) and left[gone] < end else end
            stop = min(place, leaves)
            order_out[n : n + stop - k] = order[k:stop]
            n += stop - k
            k = stop
            if place <= leaves:
                order_out[n] = arrivals[a]
                n += 1
                a += 1
                place = -1
            elif leaves < end:
                k += 1
                gone += 1
            else:
                break
    start_out[len(start) - 1] = n
    return n


@kernel
def _place(particles, order, low, high, arrival):
    """First place in ``order[low:high]`` of a particle that comes after `arrival` by (cell, id)."""
    cell, number = particles.cell[arrival], particles.id[arrival]
    while low < high:
        middle = (low + high) // 2
        p = order[middle]
        after = particles.cell[p] > cell
        if particles.cell[p] == cell:
            after = particles.id[p] > number
        if after:
            high = middle
        else:
            low = middle + 1
    return low
