"""Particles to the planes of one layer: the inner part of (16, 18, 21, 22)."""

from pgimp.kernels.charges import charges, slopes
from pgimp.kernels.jit import kernel
from pgimp.kernels.loads import scatter_loads, weight
from pgimp.kernels.transfer import scatter, support


@kernel
def sum_layer(shape, frame, window, particles, loads, order, begin, end, number, scratch):
    """Sum the particles of one layer, in canonical order, into its own planes.

    Parameters
    ----------
    shape, frame, window, particles, loads, order, scratch
        As in `particles_to_grid`.
    begin, end : int
        Where the layer's particles begin and end in `order`; there is at least one.
    number : int
        The layer's number.

    Returns
    -------
    low, high : int
        Places, in float64 from the beginning of a plane, between which something was added.
    """
    plane = window.stride[0]
    vertices = len(scratch) // plane
    low = plane
    high = 0
    for k in range(begin, end):
        p = order[k]
        place, W = support(shape, frame, window, particles, p, number)
        A, S = charges(frame, loads.viscosity, particles, p)
        B = weight(loads.force, frame, particles, p)
        C = slopes(loads.affine, frame, particles, p)
        scatter(scratch, place, W[0][0], W[0][1], W[0][3], W[0][2], W[1:], A, B, S, C)
        scatter_loads(loads, shape, frame, window, particles, p, number, W, scratch)
        low = min(low, place)
        high = max(high, place)
    # Behind the last particle's first vertex lies the rest of its support within the plane.
    high += 8
    for d in range(1, len(frame.origin)):
        high += (vertices - 1) * window.stride[d]
    return low, high
