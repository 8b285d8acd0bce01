"""Particles that pass a periodic face: moved by the period, so that supports lie on the grid.

Not the position decides but the first vertex of the support, which lies on the low face or above
it, and below the high one. A particle may therefore be up to its half-width and a cell beyond the
high face. So each layer has all particles of its supports, at the seam as inside.
"""

from math import floor

from pgimp.jit.kernel import inner_kernel, kernel
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
def turn(frame, exits, particles, p, d, half):
    """Move particle `p` by whole periods along `d`, if its first vertex is beyond the seam.

    Parameters
    ----------
    frame, exits, particles
        See `Frame`, `KernelScene`, `Particles`.
    half : float
        The particle's half-width along `d`, in cells.

    Returns
    -------
    int
        The periods that it was moved down.
    """
    if not is_periodic(exits, d):
        return 0
    low, cells, now = frame.ghost, frame.cells[d], coordinate(frame, particles, p, d)
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
    particles.x[p, d] = x
    if particles.origin.shape[1] > 0:  # so that displacements stay
        same = particles.origin[p, d] == now
        particles.origin[p, d] = x if same else particles.origin[p, d] - turns * size
    particles.winding[p, d] += turns
    if d == 0:
        # As if it had come from the layers before the ring, or behind it: the order is geometric.
        particles.cell[p] -= turns * cells * cells_of_layer(frame)
    return turns


@kernel
def turn_all(shape, frame, exits, particles, rows):
    """Move the particles in `rows` by whole periods where their supports are beyond a seam."""
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        for d in range(len(frame.origin)):
            turn(frame, exits, particles, p, d, half[d])
