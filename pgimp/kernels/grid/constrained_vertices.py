"""Constrained vertices: the vertices in the supports of constrained particles.

So the material around moves with the particles and does not tear from them prematurely. A
constraint therefore acts up to a vertex near the edge of its region. The edge is exact if it is a
plane of vertices; else it is up to a cell further, and changes as the region moves.

In the initial configuration, where nothing tears, these are the vertices nearest to constrained
particles, and those with a part of their mass from them (`release_light`). But grips that a given
force moves hold all: what their particles gain is what these vertices gain.

Marks in planes that two ranks share are combined with ``or``, so that their order does not matter.
Masses there are counted in whole numbers, for the same reason.
"""

from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.record import MASS, RECORD
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.grid.constraint_flags import LEAST_WEIGHT
from pgimp.kernels.transfer.cornertransfer import corner
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, entry, extent, first_offset, supports
from pgimp.kernels.transfer.transfer import Support
from pgimp.physics.shapes.base import by_corners

#: Bit of a vertex that constraints hold whatever its mass, beside those of constraints.
CERTAIN = 1 << 62

#: Most that a particle counts at a vertex, so that sums have room.
_MAX_UNITS = 1e15


@inlined
def _any_held(particles, rows):
    """Whether a constraint holds one of four particles."""
    held = particles.constraint
    return (held[rows[0], 0] | held[rows[1], 0] | held[rows[2], 0] | held[rows[3], 0]) > 0


@inlined
def _mark(shape, noted, offset, support, d, w, stride, like):
    """Mark the vertices in a particle's support; `like` has its number of directions.

    `noted` are the marks, the bits of the nearest vertex, and those of others; `w` is the mass that
    the particle gives.
    """
    marks, near, far = noted
    if len(like) == 0:
        marks[0][offset // RECORD] |= near
        if len(marks) > 1:
            units = int(min(w, _MAX_UNITS)) + 1  # not less, for light vertices
            marks[1][offset // RECORD] += units
    else:
        buffer, j = support
        most = 0.0
        if len(marks) > 1:
            for i in range(extent(shape, buffer, d, j)):
                most = max(most, entry(buffer, d, 0, i, j))
        for i in range(extent(shape, buffer, d, j)):
            S = entry(buffer, d, 0, i, j)
            if S >= LEAST_WEIGHT:
                at, bits = offset + i * stride[0], near if S >= most - LEAST_WEIGHT else far
                one = (marks, bits, far)
                _mark(shape, one, at, support, d + 1, w * S, stride[1:], like[1:])


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
def _mark_support(shape, noted, offset, support, m, stride, like):
    """Mark the vertices in the support of a particle of mass m, for any kind of support."""
    corners, part = 2 ** len(like), 0.5 ** len(like)
    if by_corners(shape):
        for c in range(corners):
            t, cell = corner(support.buffer, c, support.j, like)
            _mark_cell(noted[0][0], noted[1], offset + cell, part, t, stride)
        return
    return _mark(shape, noted, offset, support, 0, m, stride, like)


@kernel
def mark_constrained_vertices(setting, window, particles, order, marks, units):
    """Mark the vertices in the supports of constrained particles.

    Parameters
    ----------
    setting, window, particles, order
        See `KernelScene`, `Window`, `Particles`, `Order`.
    marks : tuple of 1 or 2 (planes * plane / 8,) int64
        The first grows: bit k of a vertex is set where constraint k holds it. With the second, it
        is set where it may, `CERTAIN` where it does, and the second grows by the mass from there.
        `release_light` has to follow, once the sums and the marks of all ranks are complete.
    units : (constraints,) float64 or ()
        Mass that counts as 1, for each constraint; 0: it holds all vertices in the supports.
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
                    near, far, m = _counted(bit, units, number - 1, particles.m[p])
                    noted, support, stride = (marks, near, far), Support(buffer, j), window.stride
                    _mark_support(shape, noted, offset, support, m, stride, frame.origin)


@inlined
def _counted(bit, units, k, m):
    """Bits of the nearest vertex and of others of a particle of constraint k; its mass in units."""
    if len(units) == 0:
        return bit, bit, 0.0
    if units[k] > 0.0:
        return bit | CERTAIN, bit, m / units[k]
    return bit | CERTAIN, bit | CERTAIN, 0.0


@kernel
def release_light(field, marks, unit):
    """Take the marks from vertices with too little of their mass from constrained particles.

    Only of bodies in the initial configuration.

    Parameters
    ----------
    field : Field
        With all sums.
    marks
        Both, as in `mark_constrained_vertices`.
    unit : float
        A vertex is held from a count of its mass in this unit on.
    """
    G, plane, size, (mask, held) = field.G, field.window.stride[0], field_size(field.window), marks
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, RECORD):
            v = r // RECORD
            if mask[v] == 0 or not field.motion.fields[(r - i * plane) // size]:
                continue
            if mask[v] & CERTAIN == 0 and held[v] * unit < G[r + MASS]:
                mask[v] = 0
            mask[v] &= ~CERTAIN
