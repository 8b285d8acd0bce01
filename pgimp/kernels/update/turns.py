"""Particles that pass a periodic face: moved by the period, so that supports lie on the grid.

Not the position decides but the first vertex of the support, which lies on the low face or above
it, and below the high one. A particle may therefore be up to its half-width and a cell beyond the
high face. So each layer has all particles of its supports, at the seam as inside.
"""

from math import floor, isfinite

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
def _turn(frame, columns, p, d, half, now):
    """Move particle `p` by whole periods along `d`, if its first vertex is beyond the seam.

    Parameters
    ----------
    frame : Frame
        See there.
    columns : tuple of arrays
        Of the particles: position, initial position, turns, cell.
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
    if turns == 0 or abs(turns) > 1:  # farther away are particles at fault
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


@kernel
def turn_particles(shape, frame, exits, particles, rows):
    """Move the particles in `rows` by whole periods where their supports are beyond a seam.

    It is not in the loop of G2P, where it would cost scenes without periodic faces registers.

    Parameters
    ----------
    shape, frame, exits, particles
        See `KernelScene`, `Particles`; layers may be beyond the ring along x.
    rows : (n,) int32
        The rows. Particles at fault, and those that have left, stay.
    """
    columns = particles.x, particles.origin, particles.winding, particles.cell
    for p in rows:
        half = half_widths(shape, frame, particles, p)
        for d in range(len(frame.origin)):
            now = coordinate(frame, particles, p, d)
            if is_periodic(exits, d) and isfinite(now) and particles.layer[p] >= 0:
                if _turn(frame, columns, p, d, half[d], now) != 0 and d == 0:
                    now = coordinate(frame, particles, p, 0)
                    particles.layer[p] = first_vertex(frame, 0, half[0], now)
