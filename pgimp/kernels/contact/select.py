"""Selection of the particles near contact vertices: other particles are not summed again."""

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel

#: The least and the greatest vertex along y and z, in the window; empty if least > greatest.
VERTEX_RANGE = np.dtype([("low", "i8", 2), ("high", "i8", 2)], align=True)


@inner_kernel
def clear_range(row):
    """Empty a range of vertices."""
    row.low[0] = row.low[1] = 1 << 40
    row.high[0] = row.high[1] = -1


@inner_kernel
def include(row, j, k):
    """Widen a range by a vertex."""
    row.low[0], row.low[1] = min(row.low[0], j), min(row.low[1], k)
    row.high[0], row.high[1] = max(row.high[0], j), max(row.high[1], k)


@kernel
def select_near(frame, window, particles, order, vertex_ranges, shared, rows, start):
    """Select the particles that may have weight on some vertices, in their order.

    Parameters
    ----------
    window : Window
        The window of the planes.
    order : Order
        Order of all particles of the rank.
    vertex_ranges : (planes,) VERTEX_RANGE
        Range of the vertices in each plane.
    shared : int
        Vertices in one direction of a support, less one.
    rows : (n,) int32
        Filled with the particles' rows.
    start : (layers + 1,) int64
        Set to the beginning of each layer in `rows`.
    """
    D, found = len(frame.cell), 0
    reach = 0.5 * (shared + 1) + 1e-6  # of a particle: half of its support, at most
    for layer in range(len(start) - 1):
        start[layer] = found
        low_y, high_y, low_z, high_z = 1 << 40, -1, 1 << 40, -1
        for i in range(layer, layer + shared + 1):
            row = vertex_ranges[i]
            low_y, low_z = min(low_y, row.low[0]), min(low_z, row.low[1])
            high_y, high_z = max(high_y, row.high[0]), max(high_z, row.high[1])
        if high_y < 0:
            continue
        for k in range(order.start[layer], order.start[layer + 1]):
            p = order.rows[k]
            near = True
            for d in range(1, D):
                low, high = (low_y, high_y) if d == 1 else (low_z, high_z)
                x = (particles.x[p, d] - frame.origin[d]) * frame.inverse[d]
                x += frame.ghost - window.lower[d]
                near = near and x > low - reach and x < high + reach
            if near:
                rows[found] = p
                found += 1
    start[len(start) - 1] = found
