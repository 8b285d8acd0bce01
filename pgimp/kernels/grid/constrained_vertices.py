"""Constrained vertices: the vertices in the supports of constrained particles.

So the material around moves with the particles and does not tear from them prematurely. A
constraint therefore acts up to a vertex near the edge of its region. The edge is exact if it is a
plane of vertices; else it is up to a cell further, and changes as the region moves.
Marks in planes that two ranks share are combined with ``or``, so that their order does not matter.
"""

from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.constraint_flags import LEAST_WEIGHT
from pgimp.kernels.transfer.cornertransfer import corner
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, entry, extent, first_offset, supports
from pgimp.kernels.transfer.transfer import Support
from pgimp.physics.shapes.base import by_corners


@inlined
def _any_held(particles, rows):
    """Whether a constraint holds one of four particles."""
    held = particles.constraint
    return (held[rows[0], 0] | held[rows[1], 0] | held[rows[2], 0] | held[rows[3], 0]) > 0


@inlined
def _mark(shape, mask, bit, offset, support, d, stride, like):
    """Set a bit at the vertices in a particle's support; `like` has its number of directions."""
    if len(like) == 0:
        mask[offset // RECORD] |= bit
    else:
        buffer, j = support
        for i in range(extent(shape, buffer, d, j)):
            if entry(buffer, d, 0, i, j) >= LEAST_WEIGHT:
                at = offset + i * stride[0]
                _mark(shape, mask, bit, at, support, d + 1, stride[1:], like[1:])


@inlined
def _mark_cell(mask, bit, offset, w, t, stride):
    """Set a bit at the vertices round the position t in a cell, as `spread` in `cornertransfer`."""
    if len(t) == 0:
        if w >= LEAST_WEIGHT:
            mask[offset // RECORD] |= bit
    else:
        _mark_cell(mask, bit, offset, w * (1.0 - t[0]), t[1:], stride[1:])
        _mark_cell(mask, bit, offset + stride[0], w * t[0], t[1:], stride[1:])


@inlined
def _mark_support(shape, mask, bit, offset, support, stride, like):
    """Set a bit at the vertices in a particle's support, for any kind of support."""
    corners, part = 2 ** len(like), 0.5 ** len(like)
    if by_corners(shape):
        for c in range(corners):
            t, cell = corner(support.buffer, c, support.j, like)
            _mark_cell(mask, bit, offset + cell, part, t, stride)
        return
    return _mark(shape, mask, bit, offset, support, 0, stride, like)


@kernel
def mark_constrained_vertices(setting, window, particles, order, mask):
    """Mark the vertices in the supports of constrained particles.

    Parameters
    ----------
    setting, window, particles, order
        See `KernelScene`, `Window`, `Particles`, `Order`.
    mask : (planes * plane / 8,) int64
        Grows: bit k of a vertex is set where constraint k holds it.
    """
    shape, frame, rows_of_all, start = setting.shape, setting.frame, order.rows, order.start
    buffer = stack(SUPPORT_SIZE)
    for layer in range(len(start) - 1):
        plane = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(rows_of_all, k, start[layer + 1])
            if not _any_held(particles, rows):
                continue
            supports(shape, frame, window, particles, rows, plane, buffer, ())
            for j in range(min(LANES, start[layer + 1] - k)):
                p = rows_of_all[k + j]
                number = particles.constraint[p, 0]
                if number > 0:
                    offset = first_offset(buffer, j) + layer * window.stride[0]
                    bit = 1 << (number - 1)
                    support = Support(buffer, j)
                    _mark_support(shape, mask, bit, offset, support, window.stride, frame.origin)
