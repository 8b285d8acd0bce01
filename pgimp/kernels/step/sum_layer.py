"""Particles to the planes of one layer: the inner part of (16, 18, 21, 22)."""

from pgimp.jit.kernel import class_of, inlined
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.used_rows import layer_marks, mark_supports
from pgimp.kernels.loads.body_forces import weight
from pgimp.kernels.loads.loads import Loads, scatter_loads
from pgimp.kernels.step.contribution import contribution, hoop_force
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.mean_dilatation_weights import keep_means
from pgimp.kernels.transfer.scatter import Share, scatter
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, first_offset, first_offsets, supports
from pgimp.kernels.transfer.transfer import Support
from pgimp.kernels.update.affine import affine_momentum
from pgimp.kernels.update.mean_dilatation import mean_force
from pgimp.kernels.update.mean_dilatation_lagrangian import (
    keep_mean_lagrangian,
    scatter_mean_lagrangian,
)
from pgimp.kernels.update.piola import PIOLA_SIZE, keep_forces


@inlined
def _share(loads, frame, particles, p, forces, j):
    """Share of particle `p`, number `j` of four, in the sums of mass, momentum and forces."""
    A, S = contribution(loads, frame, particles, p, forces, j)
    B = weight(loads.force, loads.approached, frame, particles, p)
    C = affine_momentum(loads.affine, frame, particles, p)
    M = mean_force(loads, frame, particles, p)
    return Share(A, B, S, C, M, hoop_force(loads, frame, particles, p, forces, j))


@inlined
def sum_layer(setting, field, particles, quantity, rows, span, number):
    """Sum the particles of one layer, in canonical order, into its own planes.

    Parameters
    ----------
    setting, field, particles, quantity
        As in `particles_to_grid`.
    rows : (n,) int32
        Rows of the rank's particles in canonical order.
    span : (int, int)
        Range of the layer's particles in `rows`; at least one.
    number : int
        The layer's number.

    Returns
    -------
    low, high : int
        Range of a plane with added sums, in float64 from its beginning.
    """
    shape, frame, window, scratch = setting.shape, setting.frame, field.window, field.scratch
    begin, end = span
    plane = window.stride[0]
    vertices = len(scratch) // plane
    low = plane
    high = 0
    buffer = stack(SUPPORT_SIZE)
    forces = stack(PIOLA_SIZE)
    weights = stack(SUPPORT_SIZE)
    marks = layer_marks(field, vertices, len(frame.origin))
    for k in range(begin, end, LANES):
        four = four_rows(rows, k, end)
        if isinstance(quantity, Loads):
            supports(shape, frame, window, particles, four, number, buffer, quantity.affine)
            keep_means(quantity.mean, shape, frame, buffer)
            keep_mean_lagrangian(quantity.mean_lagrangian, shape, frame, buffer, weights)
            keep_forces(quantity, (shape, frame), particles, four, forces)
        else:
            own = class_of(quantity)
            own.supports(quantity, shape, frame, window, particles, four, number, buffer)
        mark_supports(marks, window, first_offsets(buffer))
        for j in range(min(LANES, end - k)):
            p = rows[k + j]
            offset = first_offset(buffer, j)
            support = Support(buffer, j)
            if isinstance(quantity, Loads):
                share = _share(quantity, frame, particles, p, forces, j)
                scatter(shape, scratch, support, offset, window.stride, share)
                scatter_mean_lagrangian(
                    quantity.mean_lagrangian, (shape, frame), scratch, Support(weights, j), offset,
                    window.stride, forces,
                )  # fmt: skip
            else:
                share = class_of(quantity).share(quantity, shape, frame, particles, p)
                scatter(shape, scratch, support, offset, window.stride, share)
            low = min(low, offset)
            high = max(high, offset)
    if isinstance(quantity, Loads):
        scatter_loads(quantity, setting, field, particles, rows, span, number)
    # Behind the last particle's first vertex lies the rest of its support within the plane.
    high += RECORD
    for d in range(1, len(frame.origin)):
        high += (vertices - 1) * window.stride[d]
    return low, high
