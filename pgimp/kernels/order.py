"""Canonical order: (layer now, cell at the last re-sort, id)."""

from pgimp.kernels.jit import kernel
from pgimp.kernels.transfer import first_vertex


@kernel
def locate(shape, frame, particles, rows, vertices):
    """Set `layer` and `cell` of the particles in `rows`, from their positions.

    `cell` numbers the first vertex of the support row-major over the whole grid, so that sorting
    by it keeps the particles of one support together; `vertices` is the grid's size by direction.
    """
    for p in rows:
        cell = 0
        for d in range(len(vertices)):
            cell = cell * vertices[d] + first_vertex(shape, frame, d, particles.x[p, d])
        particles.cell[p] = cell
        particles.layer[p] = first_vertex(shape, frame, 0, particles.x[p, 0])


@kernel
def reach_of(shape, frame, particles, rows, reach):
    """Grow `reach`, (2, 2) int64, to the first vertices (least, greatest; y, z) of `rows`."""
    for p in rows:
        for d in range(1, len(frame.origin)):
            j = first_vertex(shape, frame, d, particles.x[p, d])
            reach[0, d - 1] = min(reach[0, d - 1], j)
            reach[1, d - 1] = max(reach[1, d - 1], j)


@kernel
def merge(particles, order, start, first, moved, arrivals, order_out, start_out):
    """Restore the canonical order after particles have changed their layers.

    Parameters
    ----------
    order, start
        The old order; `start` holds the beginnings of the layers ``first, first + 1, ...``.
    moved : (layers,) uint8
        1 for layers that have lost particles.
    arrivals : (k,) int32
        Rows of the particles that have come into a layer, in canonical order among themselves.
    order_out, start_out
        The new order.
    """
    layer, cell, number = particles.layer, particles.cell, particles.id
    q = 0
    n = 0
    for j in range(len(start) - 1):
        here = first + j
        start_out[j] = n
        coming = q < len(arrivals) and layer[arrivals[q]] == here
        if not coming and moved[j] == 0:
            for k in range(start[j], start[j + 1]):
                order_out[n] = order[k]
                n += 1
            continue
        for k in range(start[j], start[j + 1]):
            p = order[k]
            if layer[p] != here:
                continue
            while q < len(arrivals):
                a = arrivals[q]
                if layer[a] != here or cell[a] > cell[p]:
                    break
                if cell[a] == cell[p] and number[a] > number[p]:
                    break
                order_out[n] = a
                n += 1
                q += 1
            order_out[n] = p
            n += 1
        while q < len(arrivals) and layer[arrivals[q]] == here:
            order_out[n] = arrivals[q]
            n += 1
            q += 1
    start_out[len(start) - 1] = n
    return n
