"""Particles to the planes of one layer: the inner part of (16, 18, 21, 22)."""

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.contact.volumes import summed_supports
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.used_rows import layer_marks, mark_support
from pgimp.kernels.flows.calming import motion_share
from pgimp.kernels.flows.filling import FillingSums, ratio_arms
from pgimp.kernels.loads.body_forces import weight
from pgimp.kernels.loads.following import DisplacementSums, displacement_arms
from pgimp.kernels.loads.loads import scatter_loads
from pgimp.kernels.step.contribution import contribution, hoop_force
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.mean_dilatation_weights import keep_means
from pgimp.kernels.transfer.scatter import Share, scatter
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, first_offset
from pgimp.kernels.transfer.transfer import Support
from pgimp.kernels.update.affine import affine_momentum
from pgimp.kernels.update.mean_dilatation import mean_force
from pgimp.kernels.update.mean_dilatation_lagrangian import (
    keep_mean_lagrangian,
    scatter_mean_lagrangian,
)
from pgimp.kernels.update.piola import PIOLA_SIZE, keep_forces


@inlined
def arms(loads, frame, particles, p):
    """Gradients of particle `p`, times its mass: of velocity, of J in flows, of displacement."""
    if isinstance(loads, FillingSums):
        return ratio_arms(loads, frame, particles, p)
    if isinstance(loads, DisplacementSums):
        return displacement_arms(frame, particles, p)
    return affine_momentum(loads.affine, frame, particles, p)


@inlined
def second(loads, frame, particles, p):
    """Second vector to be weighted for the vertices: weight of particle `p`, or (m, m v)."""
    if isinstance(loads, FillingSums):
        return motion_share(loads.calming, frame, particles, p)
    return weight(loads.force, loads.approached, frame, particles, p)


@inlined
def sum_layer(setting, field, particles, loads, rows, span, number):
    """Sum the particles of one layer, in canonical order, into its own planes.

    Parameters
    ----------
    setting, field, particles, loads
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
        summed_supports(loads, shape, frame, window, particles, four, number, buffer)
        keep_means(loads.mean, shape, frame, buffer)
        keep_mean_lagrangian(loads.mean_lagrangian, shape, frame, buffer, weights)
        keep_forces(loads, frame, particles, four, forces)
        for j in range(min(LANES, end - k)):
            p = rows[k + j]
            offset = first_offset(buffer, j)
            A, S = contribution(loads, frame, particles, p, forces, j)
            B = second(loads, frame, particles, p)
            C = arms(loads, frame, particles, p)
            M = mean_force(loads, frame, particles, p)
            share = Share(A, B, S, C, M, hoop_force(loads, frame, particles, p, forces, j))
            scatter(shape, scratch, Support(buffer, j), offset, window.stride, share)
            scatter_mean_lagrangian(
                loads.mean_lagrangian, (shape, frame), scratch, Support(weights, j), offset,
                window.stride, forces,
            )  # fmt: skip
            mark_support(marks, window, particles.body[p], offset)
            low = min(low, offset)
            high = max(high, offset)
    scatter_loads(loads, setting, field, particles, rows, span, number)
    # Behind the last particle's first vertex lies the rest of its support within the plane.
    high += RECORD
    for d in range(1, len(frame.origin)):
        high += (vertices - 1) * window.stride[d]
    return low, high
