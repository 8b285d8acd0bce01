"""Canonical order: (current layer, cell at the last re-sort, id)."""

from math import prod

import numpy as np

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.memory import copy
from pgimp.kernels.transfer.first_vertex import box, coordinate, first_vertex, half_widths, off_axis
from pgimp.physics.shapes.base import by_corners, weights

#: Cells a block has along a direction, as a power of two.
BLOCK = 2
#: Combinations of one, two or three kinds of support along each direction.
_BREADTHS = 27


def cell_numbers(vertices: tuple[int, ...]) -> int:
    """Upper bound, exclusive, of the numbers that `locate` gives in a grid of `vertices`."""
    blocks = vertices[0] * prod((n >> BLOCK) + 1 for n in vertices[1:])
    return blocks * _BREADTHS << BLOCK * (len(vertices) - 1)


@inner_kernel
def cells_of_layer(frame):
    """Distance of the numbers that `locate` gives in a layer from those of the next."""
    blocks = 1
    for d in range(1, len(frame.cells)):
        blocks *= ((frame.cells[d] + 1 + 2 * frame.ghost) >> BLOCK) + 1
    return blocks * _BREADTHS << (BLOCK * (len(frame.cells) - 1))


def vertices_of(cell: np.ndarray, vertices: tuple[int, ...]) -> np.ndarray:
    """First vertices, (n, D), of the supports with the given numbers."""
    across = len(vertices) - 1
    within = cell & ((1 << BLOCK * across) - 1)
    block = (cell >> BLOCK * across) // _BREADTHS
    first = np.empty((len(cell), len(vertices)), np.int64)
    for d in range(across, 0, -1):
        block, high = np.divmod(block, (vertices[d] >> BLOCK) + 1)
        first[:, d] = (high << BLOCK) + (within & ((1 << BLOCK) - 1))
        within = within >> BLOCK
    first[:, 0] = block
    return first


@inlined
def _breadth(shape, half, f):
    """Vertices less two of a support, by its weights: its end vertices may have none.

    Transfers by corners do not branch on them.
    """
    if by_corners(shape):
        return 0
    return _weighted(weights(shape, half, f)[0])


@inlined
def _weighted(w):
    """Vertices with weight, less two."""
    if len(w) == 2:
        return 0
    if len(w) == 3:
        return int(w[2] != 0.0)
    return 2 if w[3] != 0.0 else int(w[2] != 0.0)


@kernel
def locate(shape, frame, particles, rows, vertices):
    """Set `layer` and `cell` of the particles in `rows`, from their positions.

    `cell` is a number to sort by. It grows with the layer, then the block of 4 x 4 cells across,
    the numbers of vertices with weight, the cell in the block. So the transfers take one branch
    many times in a row, while the vertices of a block stay in the cache. `vertices` is the grid's
    size by direction.
    """
    D = len(vertices)
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        block, within, breadth = 0, 0, 0
        for d in range(D):
            x = coordinate(frame, particles, p, d)
            vertex = first_vertex(frame, d, half[d], x)
            f = (x - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
            breadth = 3 * breadth + _breadth(shape, half[d], f)
            if d == 0:
                particles.layer[p] = vertex
                block = vertex
            else:
                block = block * ((vertices[d] >> BLOCK) + 1) + (vertex >> BLOCK)
                within = (within << BLOCK) + (vertex & ((1 << BLOCK) - 1))
        particles.cell[p] = ((block * _BREADTHS + breadth) << (BLOCK * (D - 1))) + within


@kernel
def layers_of(shape, frame, identity, x, layers):
    """Set `layers`, (n,) int64, of undeformed particles at coordinates `x` along x."""
    for i in range(len(x)):
        at = off_axis(frame, (x[i],))
        layers[i] = first_vertex(frame, 0, box(shape, frame, identity, at)[0][0], at[0])


@kernel
def grow_vertex_bounds(shape, frame, particles, rows, bounds):
    """Grow `bounds`, (2, 2) int64, to the first vertices (least, greatest; y, z) of `rows`."""
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        for d in range(1, len(frame.origin)):
            j = first_vertex(frame, d, half[d], coordinate(frame, particles, p, d))
            bounds[0, d - 1] = min(bounds[0, d - 1], j)
            bounds[1, d - 1] = max(bounds[1, d - 1], j)


@kernel
def merge(particles, order, start, left, first, arrivals, order_out, start_out):
    """Restore the canonical order after particles have changed their layers.

    Between the changes, whole runs of the old order are copied: a change costs a binary search.

    Parameters
    ----------
    order, start
        The old order; `start` holds the beginnings of the layers ``first, first + 1, ...``.
    left : (k,) int32
        Offsets in `order` of the particles that have left their layer, ascending.
    arrivals : (l,) int32
        Rows of the particles that have entered a layer, in canonical order among themselves.
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
        rank_in_order = -1  # offset of the next arrival; -1 when not yet known
        while True:
            if rank_in_order < 0:
                rank_in_order = end + 1
                if a < len(arrivals) and particles.layer[arrivals[a]] == first + j:
                    rank_in_order = _rank_in_order(particles, order, k, end, arrivals[a])
            leaves = left[gone] if gone < len(left) and left[gone] < end else end
            stop = min(rank_in_order, leaves)
            copy(order_out, n, order, k, stop - k)
            n += stop - k
            k = stop
            if rank_in_order <= leaves:
                order_out[n] = arrivals[a]
                n += 1
                a += 1
                rank_in_order = -1
            elif leaves < end:
                k += 1
                gone += 1
            else:
                break
    start_out[len(start) - 1] = n
    return n


@inner_kernel
def _rank_in_order(particles, order, low, high, arrival):
    """First offset in ``order[low:high]`` of a particle after `arrival` by (cell, id).

    Particles that leave the layer are passed over: a seam changes their cells.
    """
    cell, number, layer = particles.cell[arrival], particles.id[arrival], particles.layer[arrival]
    while low < high:
        middle = (low + high) // 2
        stays = middle
        while stays < high and particles.layer[order[stays]] != layer:
            stays += 1
        if stays == high:
            high = middle
            continue
        p = order[stays]
        after = particles.cell[p] > cell
        if particles.cell[p] == cell:
            after = particles.id[p] > number
        if after:
            high = middle
        else:
            low = stays + 1
    return low
