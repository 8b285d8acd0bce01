"""Selection of the particles near vertices at which bodies meet: others are not summed again."""

from pgimp.jit.kernel import inner_kernel, kernel

#: Columns of `vertex_ranges`: least and greatest vertex along y, then along z, in the window.
LOW_Y, HIGH_Y, LOW_Z, HIGH_Z, VERTEX_RANGE = 0, 1, 2, 3, 4


@inner_kernel
def include(vertex_ranges, i, j, k):
    """Widen the range of plane `i` by a vertex."""
    vertex_ranges[i, LOW_Y], vertex_ranges[i, HIGH_Y] = (
        min(vertex_ranges[i, LOW_Y], j),
        max(vertex_ranges[i, HIGH_Y], j),
    )
    vertex_ranges[i, LOW_Z], vertex_ranges[i, HIGH_Z] = (
        min(vertex_ranges[i, LOW_Z], k),
        max(vertex_ranges[i, HIGH_Z], k),
    )


@kernel
def select_near(frame, window, particles, order, vertex_ranges, shared, rows, start):
    """Select the particles that may have weight on some vertices, in their order.

    Parameters
    ----------
    window : Window
        That of the planes.
    order : Order
        Of all particles of the rank.
    vertex_ranges : (planes, SPREAD) int64
        Range of the vertices in each plane; empty if the least is above the greatest.
    shared : int
        Vertices a direction in a support, less one.
    rows : (n,) int32
        Filled with the particles' rows.
    start : (layers + 1,) int64
        Set to where each layer begins in `rows`.
    """
    D, found = len(frame.cell), 0
    reach = 0.5 * (shared + 1) + 1e-6  # of a particle: half of its support, at most
    for layer in range(len(start) - 1):
        start[layer] = found
        low_y, high_y, low_z, high_z = 1 << 40, -1, 1 << 40, -1
        for i in range(layer, layer + shared + 1):
            low_y, high_y = (
                min(low_y, vertex_ranges[i, LOW_Y]),
                max(high_y, vertex_ranges[i, HIGH_Y]),
            )
            low_z, high_z = (
                min(low_z, vertex_ranges[i, LOW_Z]),
                max(high_z, vertex_ranges[i, HIGH_Z]),
            )
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
