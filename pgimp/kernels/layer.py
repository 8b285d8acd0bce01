"""Particles to the planes of one layer: the inner part of (16, 18, 21, 22)."""

from pgimp.jit.kernel import specialise
from pgimp.jit.simd import stack
from pgimp.kernels.affine import slopes
from pgimp.kernels.batch import LANES, ROOM, first_place, four, supports
from pgimp.kernels.charges import charges
from pgimp.kernels.loads import scatter_loads, weight
from pgimp.kernels.transfer import scatter


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


@specialise(sum_layer)  # inlined: a call costs as much as a particle
def _sum_layer(shape, frame, window, particles, loads, order, begin, end, number, scratch):
    def sum_layer(shape, frame, window, particles, loads, order, begin, end, number, scratch):
        plane = window.stride[0]
        vertices = len(scratch) // plane
        low = plane
        high = 0
        room = stack(ROOM)
        for k in range(begin, end, LANES):
            rows = four(order, k, end)
            supports(shape, frame, window, particles, rows, number, room, loads.affine)
            for j in range(min(LANES, end - k)):
                p = order[k + j]
                place = first_place(room, j)
                A, S = charges(frame, loads.viscosity, particles, p)
                B = weight(loads.force, frame, particles, p)
                C = slopes(loads.affine, frame, particles, p)
                scatter(shape, scratch, room, j, place, window.stride, A, B, S, C)
                low = min(low, place)
                high = max(high, place)
        scatter_loads(
            loads, shape, frame, window, particles, order, begin, end, number, scratch
        )
        # Behind the last particle's first vertex lies the rest of its support within the plane.
        high += 8
        for d in range(1, len(frame.origin)):
            high += (vertices - 1) * window.stride[d]
        return low, high

    return sum_layer
