"""Particles that pass a periodic face: moved by the period, so that supports lie on the grid.

Not the position decides but the first vertex of the support, which lies on the low face or above
it, and below the high one. A particle may therefore be up to its half-width and a cell beyond the
high face. So each layer has all particles of its supports, at the seam as inside.
"""

from math import floor

from pgimp.jit.kernel import inner_kernel, kernel, specialise
from pgimp.jit.vectors.lanes import of_lane
from pgimp.jit.vectors.simd import vec4
from pgimp.kernels.order.order import cells_of_layer
from pgimp.kernels.transfer.first_vertex import coordinate, first_vertex, half_widths

#: First bit of `KernelScene.exits` for periodic directions.
PERIODIC = 6

#: Part of the domain's greatest coordinate that is added until a particle is within it again.
_ULP = 2.0**-52


@inner_kernel
def is_periodic(exits, d):
    """Whether the domain is periodic along direction `d`."""
    return (exits >> (PERIODIC + d)) & 1 != 0


@inner_kernel
def _turn(frame, columns, p, d, half, now):
    """Move particle `p` by whole periods along `d`, if its first vertex is beyond the seam.

    Parameters
    ----------
    frame : Frame
        See there.
    columns : tuple of arrays
        See `turn`.
    half : float
        The particle's half-width along `d`, in cells.
    now : float
        Its coordinate, which decides.

    Returns
    -------
    int
        The periods that it was moved down.
    """
    position, origin, winding, cell = columns
    low, cells = frame.ghost, frame.cells[d]
    turns = floor((first_vertex(frame, d, half, now) - low) / cells)
    if turns == 0:
        return 0
    size = cells * frame.cell[d]
    x = now - turns * size
    # Rounding must not leave it on the other side of the seam.
    step = _ULP * (abs(frame.origin[d]) + size)
    while first_vertex(frame, d, half, x) < low:
        x += step
        step *= 2.0
    while first_vertex(frame, d, half, x) >= low + cells:
        x -= step
        step *= 2.0
    position[p, d] = x
    if origin.shape[1] > 0:  # so that displacements stay
        origin[p, d] = x if origin[p, d] == now else origin[p, d] - turns * size
    winding[p, d] += turns
    if d == 0:
        # As if it had come from the layers before the ring, or behind it: the order is geometric.
        cell[p] -= turns * cells * cells_of_layer(frame)
    return turns


@inner_kernel
def _turn_over(frame, exits, columns, p, half, layer):
    """See `turn`; `half` is of one particle."""
    for d in range(len(half)):
        if is_periodic(exits, d):
            if _turn(frame, columns, p, d, half[d], columns[0][p, d]) != 0 and d == 0:
                layer = int(first_vertex(frame, 0, half[0], columns[0][p, 0]))
    return layer


def turn(frame, exits, columns, p, half, j, layer):
    """Move particle `p` by whole periods where its support is beyond a seam; return its layer.

    Parameters
    ----------
    frame, exits
        See `Frame`, `KernelScene`.
    columns : tuple of arrays
        Of the particles: position, initial position, turns, cell.
    half : tuple
        Half-widths of four particles in cells, of which `p` is number `j`; or of all.
    layer : int
        Its layer before.
    """


@specialise(turn)
def _turn_of(frame, exits, columns, p, half, j, layer):
    if half[0] == vec4:
        return lambda frame, exits, columns, p, half, j, layer: _turn_over(
            frame, exits, columns, p, of_lane(half, j), layer
        )
    return lambda frame, exits, columns, p, half, j, layer: _turn_over(
        frame, exits, columns, p, half, layer
    )


@kernel
def turn_all(shape, frame, exits, particles, rows):
    """Move the particles in `rows` by whole periods where their supports are beyond a seam."""
    columns = particles.x, particles.origin, particles.winding, particles.cell
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        for d in range(len(frame.origin)):
            if is_periodic(exits, d):
                _turn(frame, columns, p, d, half[d], coordinate(frame, particles, p, d))
