"""Momentum and energy of vertices by particles, in the initial configuration.

Vertices have more kinetic energy and angular momentum than the means that particles see. A particle
accounts for its part of each vertex: m_p S_vp of its mass. So sums by layer and body stay sums over
particles, and bodies that share vertices have each their own.
"""

from pgimp.jit.kernel import class_of, inlined, inner_kernel, is_empty, kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.velocity_fields import field_of
from pgimp.kernels.sums.sums import ANGULAR, KINETIC, MOMENTUM, remaining_across
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.parts import corner_weights
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, entry, first_offset, supports
from pgimp.physics.shapes.base import by_parts


@inner_kernel
def _coordinate(frame, window, d, number):
    """Coordinate of a vertex along `d`, from its number in the window; 0 along missing ones."""
    if d >= len(frame.origin):
        return 0.0
    return frame.origin[d] + (number + window.lower[d] - frame.ghost) * frame.cell[d]


@inlined
def _weight(shape, buffer, j, corner):
    """Weight of a vertex of particle `j`, by its numbers along all directions."""
    if by_parts(shape):
        return corner_weights(buffer, j, corner)[0]
    return _product(buffer, j, corner)


@inlined
def _product(buffer, j, corner):
    """Product of the weights along the first directions."""
    last = len(corner) - 1
    if last == 0:
        return entry(buffer, 0, 0, corner[0], j)
    return _product(buffer, j, corner[:last]) * entry(buffer, last, 0, corner[last], j)


@inlined
def vertex_count(shape):
    """Vertices a direction in a support; a grid may have room for more, of other bodies' shapes."""
    count = class_of(shape).vertices()
    return count


@kernel
def motion_sums(setting, field, particles, order, lumped, sums):
    """Add what the vertices have beyond particles: momentum, angular momentum, kinetic energy.

    Parameters
    ----------
    setting, particles, order
        See `KernelScene`, `Particles`, `Order`: particles in the initial configuration, whose sums
        by `layer_sums` this completes.
    field : Field
        With the vertices' motion.
    lumped : (bodies,) float64 or ()
        Part of the lumped mass in energy and angular momentum; () if it is all, without averaged
        mass. The rest is of the consistent mass, by which particles have what they see.
    sums : (layers, bodies, columns) float64
        From `layer_sums`.
    """
    shape, frame, window, start = setting.shape, setting.frame, field.window, order.start
    values, D = field.motion.values, len(setting.frame.origin)
    vertices, across = vertex_count(shape), remaining_across(frame)
    ny, nz = vertices if D > 1 else 1, vertices if D > 2 else 1
    buffer = stack(SUPPORT_SIZE)
    for layer in range(len(start) - 1):
        for first in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, first, start[layer + 1])
            number = layer + window.lower[0]
            supports(shape, frame, window, particles, rows, number, buffer, ())
            for j in range(min(LANES, start[layer + 1] - first)):
                p = order.rows[first + j]
                offset = first_offset(buffer, j)
                inside = offset - field_of(window, particles, p)
                y0, z0 = inside // window.stride[1], inside % window.stride[1] // RECORD
                begin = layer * window.stride[0] + offset
                px, py, pz, ax, ay, az, square = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                for a in range(vertices):
                    for b in range(ny):
                        for c in range(nz):
                            w = _weight(shape, buffer, j, (a, b, c)[:D])
                            r = begin + a * window.stride[0] + b * window.stride[1] + c * RECORD
                            if w == 0.0:
                                continue
                            u, v = r + DISPLACEMENT, r + KEPT_VELOCITY
                            x = _coordinate(frame, window, 0, layer + a) + values[u]
                            y = _coordinate(frame, window, 1, y0 + b) + values[u + 1]
                            z = _coordinate(frame, window, 2, z0 + c) + values[u + 2]
                            vx, vy, vz = values[v], values[v + 1], values[v + 2]
                            px, py, pz = px + w * vx, py + w * vy, pz + w * vz
                            ax += w * (y * vz - z * vy)
                            ay += w * (z * vx - x * vz)
                            az += w * (x * vy - y * vx)
                            square += w * (vx * vx + vy * vy + vz * vz)
                row, m = sums[layer, particles.body[p]], particles.m[p]
                x, y, z = particles.x[p, 0], 0.0, 0.0
                vx, vy, vz = particles.v[p, 0], 0.0, 0.0
                if D > 1:
                    y, vy = particles.x[p, 1], particles.v[p, 1]
                if D > 2:
                    z, vz = particles.x[p, 2], particles.v[p, 2]
                row[MOMENTUM] += across * (m * (px - vx))
                row[MOMENTUM + 1] += m * (py - vy)
                row[MOMENTUM + 2] += m * (pz - vz)
                if not is_empty(lumped):
                    m *= lumped[particles.body[p]]
                row[ANGULAR] += m * (ax - (y * vz - z * vy))
                row[ANGULAR + 1] += m * (ay - (z * vx - x * vz))
                row[ANGULAR + 2] += across * (m * (az - (x * vy - y * vx)))
                row[KINETIC] += 0.5 * m * (square - (vx * vx + vy * vy + vz * vz))
