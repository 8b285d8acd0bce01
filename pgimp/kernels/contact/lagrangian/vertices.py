"""Sums at contact vertices of bodies in the initial configuration, at their current positions.

The reference grid has no neighbours. Near each other, rigid bodies or unilateral walls, particles
are summed again, at their current positions, into the vertices of the domain's grid. Filled part,
surface and gap follow as in the current configuration (`pgimp.kernels.contact.gap`). Candidate
pairs are in `pgimp.kernels.contact.lagrangian.pairs`, the impulses in
`pgimp.kernels.contact.lagrangian.gauss_seidel`.

A vertex has an entry for each *group* of bonded bodies. Hash tables number the entries of shared
vertices (`pgimp.kernels.contact.lagrangian.candidates`), so that memory does not grow with
distances.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.algebra import determinant, inverse
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.jit.tuples import read
from pgimp.kernels.contact.lagrangian.supports import plus_hoop
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.rigid.bodies import position_of
from pgimp.kernels.transfer.first_vertex import deformation
from pgimp.physics.shapes.base import size

#: A particle near contact: position of its weights, mass, curvature's share of the gap. Whether it
#: is cut; its body, group and field; whether it has reference weights, or `EXACT` those of its part
#: of a cell. Half-widths in cells.
NEAR_PARTICLE = structure(
    ("weight_position", "f8", 3),
    ("mass", "f8"),
    ("curvature_gap", "f8"),
    ("cut", "i8"),
    ("body", "i8"),
    ("group", "i8"),
    ("field", "i8"),
    ("lagrangian", "i8"),
    ("half_width", "f8", 3),
)

#: Of a particle of a body that is exact to its surface.
EXACT = 2

#: What changes of it in a step: position, volume, vector to the centroid of its remaining part,
#: inverse of the deformation gradient.
NEAR_MOTION = structure(
    ("position", "f8", 3),
    ("volume", "f8"),
    ("centroid_offset", "f8", 3),
    ("inverse_F", "f8", (3, 3)),
)

#: Sums of a group at a vertex: mass, volume, surface, the offset's correction of the volume. The
#: curvature's share of the gap, the count in its mean, and the body. `mass_offset` is the vector to
#: the centre of mass, times the mass, in the initial configuration: others have the vertex.
VERTEX_SUMS = structure(
    ("mass", "f8"),
    ("volume", "f8"),
    ("surface", "f8", 3),
    ("volume_correction", "f8"),
    ("curvature_gap", "f8"),
    ("cut_weight", "f8"),
    ("body", "i8"),
    ("mass_offset", "f8", 3),
)


class Reached(NamedTuple):
    """The particles with weight at each entry in a step."""

    #: (m,) int64: End of those of each entry, which begin where the particles within its reach do.
    end: IntArray
    #: (k,) uint32: Their offsets, in canonical order: without signs, as indices below 0 would be
    #: looked for.
    particle: NDArray[np.uint32]
    weight: FloatArray  #: (k,) float64: S of the particle there.

    @classmethod
    def empty(cls, entries: int, count: int) -> "Reached":
        """Allocate for so many entries and particles within reach of them."""
        return cls(np.empty(entries, np.int64), np.empty(count, np.uint32), np.empty(count))


class ContactVertices(NamedTuple):
    """Sums of groups at the vertices of the domain's grid, one entry for each group and vertex."""

    #: low, extent: (3,) int64: The least vertex, and the greatest number of vertices from there, by
    #: direction.
    low: IntArray
    extent: IntArray
    groups: int  #: Number of groups.
    keys: IntArray  #: (m,) int64: Keys of the entries, ascending: in the order x, y, z, group.
    start: IntArray  #: (m + 1,) int64: First item of each entry in `particle`.
    #: (k,) uint32: Offsets of the particles within reach of each entry, in canonical order.
    particle: NDArray[np.uint32]
    reached: Reached  #: Those with weight in this step.
    sums: NDArray  #: (m,) VERTEX_SUMS.
    #: (m, rigid bodies) RIGID_FILL: What rigid bodies fill at each entry's vertex, while they rest.
    fills: NDArray
    order: IntArray  #: (n,) int64: Numbers of the entries with mass, by ascending key.


@inner_kernel
def key_of(contact_vertices, number, group):
    """Key of a group at a vertex, given by its numbers."""
    low, extent = contact_vertices.low, contact_vertices.extent
    key = (number[0] - low[0]) * extent[1] + number[1] - low[1]
    return (key * extent[2] + number[2] - low[2]) * contact_vertices.groups + group


@inner_kernel
def number_of(contact_vertices, vertex):
    """Numbers of a vertex from a key divided by the number of groups."""
    low, extent = contact_vertices.low, contact_vertices.extent
    rest = vertex // extent[2]
    return rest // extent[1] + low[0], rest % extent[1] + low[1], vertex % extent[2] + low[2]


@inner_kernel
def clear_sums(row):
    """Set the sums of a group at a vertex to zero."""
    row.mass = row.volume = row.volume_correction = row.curvature_gap = row.cut_weight = 0.0
    row.body = 0
    for d in range(3):
        row.surface[d] = row.mass_offset[d] = 0.0


@kernel
def copy_near_particles(setting, particles, rows, groups, fields, lagrangian, table):
    """Copy the particles near contact, (n,) NEAR_PARTICLE, in canonical order.

    `groups`, `fields` and `lagrangian`, of the bodies, are as in `LagrangianContact`.
    """
    frame = setting.frame
    for i in range(len(rows)):
        p, row = rows[i], table[i]
        F, body = deformation(frame, particles, p), particles.body[p]
        x, X = read(particles.x, p, 0, frame.origin), read(particles.origin, p, 0, frame.origin)
        own = read(particles.offset, p, 0, frame.origin)
        row.lagrangian, row.cut = 1 if lagrangian[body] else 0, 0
        kept = setting.identity if lagrangian[body] else F
        half = size(setting.shape, frame.cell, kept)[0]
        for d in range(3):
            row.weight_position[d] = row.half_width[d] = 0.0
        for d in range(len(frame.origin)):
            row.weight_position[d] = X[d] if row.lagrangian else x[d]
            row.half_width[d] = half[d]
            if own[d] != 0.0:
                row.cut = 1
        row.mass, row.curvature_gap, row.body = particles.m[p], particles.excess[p, 0], body
        row.group, row.field = groups[body], fields[body]


@kernel
def copy_near_motion(setting, particles, rows, motion):
    """Copy what changes in a step of the particles near contact, (n,) NEAR_MOTION."""
    frame = setting.frame
    D = len(frame.origin)
    for i in range(len(rows)):
        p, row = rows[i], motion[i]
        F = deformation(frame, particles, p)
        own, x = read(particles.offset, p, 0, frame.origin), read(particles.x, p, 0, frame.origin)
        for d in range(3):
            row.position[d] = row.centroid_offset[d] = 0.0
            for e in range(3):
                row.inverse_F[d, e] = 0.0
        for d in range(D):
            row.position[d] = x[d]
            for e in range(D):
                row.centroid_offset[d] += F[D * d + e] * own[e]
        back = inverse(F)
        for d in range(D):
            for e in range(D):
                row.inverse_F[d, e] = back[D * d + e]
        row.volume = particles.V0[p] * determinant(F)


@kernel
def sum_at_contact_vertices(frame, table, motion, supports, left, linear, contact_vertices):
    """Sum particles into the vertices at their current positions, by group.

    Parameters
    ----------
    table, motion, supports
        The particles, and their supports.
    left : Supports
        Supports of cut boxes, for the sums of volumes.
    linear : float
        1 if `left` has the whole supports, corrected by their gradient over the offset; else 0.
    contact_vertices : ContactVertices
        The entries; the sums are set.
    """
    D, sums, start = len(frame.origin), contact_vertices.sums, contact_vertices.start
    keys, reached = contact_vertices.keys, contact_vertices.reached
    w, v, g, first = supports.w, left.w, left.g, supports.first
    last = supports.local[len(supports.local) - 1]
    nx, ny, nz = int(last[0]) + 1, int(last[1]) + 1, int(last[2]) + 1
    ix, iy, iz = frame.inverse[0], frame.inverse[min(1, D - 1)], frame.inverse[min(2, D - 1)]
    for n in range(len(sums)):
        # Numbers, not the record's: these would be read and written for each particle.
        mass = volume = correction = gap = cut = 0.0
        x_mass = y_mass = z_mass = x_surface = y_surface = z_surface = 0.0
        total, found, lagrangian = sums[n], start[n], 0
        clear_sums(total)
        number = number_of(contact_vertices, keys[n] // contact_vertices.groups)
        here = position_of(frame, number)
        for k in range(start[n], start[n + 1]):
            i = contact_vertices.particle[k]
            a, b, c = number[0] - first[i, 0], number[1] - first[i, 1], number[2] - first[i, 2]
            if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
                continue
            S = w[i, 0, a] * w[i, 1, b] * w[i, 2, c]
            if S == 0.0:
                continue
            row, moved = table[i], motion[i]
            reached.particle[found], reached.weight[found] = i, S
            if found == start[n]:
                total.body, lagrangian = row.body, row.lagrangian
            found += 1
            m, V = row.mass * S, moved.volume
            mass, gap, cut = mass + m, gap + row.curvature_gap * S, cut + row.cut * S
            x_mass += m * (moved.position[0] - here[0])
            y_mass += m * (moved.position[1] - here[1])
            z_mass += m * (moved.position[2] - here[2])
            x, y, z = v[i, 0, a], v[i, 1, b], v[i, 2, c]
            volume += V * (x * y * z)
            x_slope, y_slope = V * (g[i, 0, a] * y * z), V * (x * g[i, 1, b] * z)
            z_slope = V * (x * y * g[i, 2, c])
            x_surface = plus_hoop(frame, left, i, a, V * (y * z), x_surface + x_slope)
            y_surface += y_slope
            z_surface += z_slope
            if linear != 0.0:
                offset = moved.centroid_offset
                way = x_slope * ix * offset[0] + y_slope * iy * offset[1]
                correction += way + z_slope * iz * offset[2]
        total.mass, total.volume, total.volume_correction = mass, volume, correction
        total.curvature_gap, total.cut_weight = gap, cut
        if lagrangian != 0:  # as the whole group
            total.mass_offset[0], total.mass_offset[1] = x_mass, y_mass
            total.mass_offset[2] = z_mass
        total.surface[0], total.surface[1] = x_surface * ix, y_surface * iy
        total.surface[2] = z_surface * iz
        reached.end[n] = found
