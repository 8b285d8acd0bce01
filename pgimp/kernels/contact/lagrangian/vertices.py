"""Sums at contact vertices of bodies in the initial configuration, at their current positions.

The reference grid has no neighbours. Near each other, rigid bodies or unilateral walls, particles
are summed again, at their current positions, into the vertices of the domain's grid. Filled part,
surface and gap follow as in the current configuration (`pgimp.kernels.contact.gap`). Candidate
pairs are in `pgimp.kernels.contact.lagrangian.pairs`, the impulses in
`pgimp.kernels.contact.lagrangian.gauss_seidel`.

A vertex has an entry for each *group* of bonded bodies. Hash tables number the entries of shared
vertices (`pgimp.kernels.contact.lagrangian.shared_vertices`), so that memory does not grow with
distances.
"""

from typing import NamedTuple

from numpy.typing import NDArray

from pgimp.jit.algebra import determinant, inverse
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.jit.tuples import read
from pgimp.kernels.contact.lagrangian.supports import slope_at, vertex_at, weights_at
from pgimp.kernels.data.particles import IntArray
from pgimp.kernels.transfer.first_vertex import deformation, first_vertex
from pgimp.physics.shapes.base import size

#: A particle near contact: position and position of its weights, mass, volume, vector to the
#: centroid of its remaining part, curvature's share of the gap. Whether it is cut; its body, group
#: and field; whether it has reference weights. Half-widths in cells, inverse of the deformation
#: gradient, and first vertex of the current support.
NEAR_PARTICLE = structure(
    ("position", "f8", 3),
    ("weight_position", "f8", 3),
    ("mass", "f8"),
    ("volume", "f8"),
    ("centroid_offset", "f8", 3),
    ("curvature_gap", "f8"),
    ("cut", "i8"),
    ("body", "i8"),
    ("group", "i8"),
    ("field", "i8"),
    ("lagrangian", "i8"),
    ("half_width", "f8", 3),
    ("inverse_F", "f8", (3, 3)),
    ("first_vertex", "i8", 3),
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


class ContactVertices(NamedTuple):
    """Sums of groups at the vertices of the domain's grid, one entry for each group and vertex.

    Attributes
    ----------
    low, extent : (3,) int64
        The least vertex, and the greatest number of vertices from there, by direction.
    groups : int
        Number of groups.
    keys : (m,) int64
        Keys of the entries; in the order x, y, z, group if sorted.
    sums : (m,) VERTEX_SUMS
        The sums.
    order : (n,) int64
        Numbers of the entries with mass, by ascending key.
    """

    low: IntArray
    extent: IntArray
    groups: int
    keys: IntArray
    sums: NDArray
    order: IntArray


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
def _clear_particle(row):
    """Set accumulated fields, and fields with fewer than three directions, to zero."""
    row.cut = 0
    for d in range(3):
        row.position[d] = row.weight_position[d] = row.centroid_offset[d] = row.half_width[d] = 0.0
        row.first_vertex[d] = 0
        for e in range(3):
            row.inverse_F[d, e] = 0.0


@inner_kernel
def _clear_sums(row):
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
        _clear_particle(row)
        F = deformation(frame, particles, p)
        own, x = read(particles.offset, p, 0, frame.origin), read(particles.x, p, 0, frame.origin)
        X, D = read(particles.origin, p, 0, frame.origin), len(frame.origin)
        row.lagrangian = 1 if lagrangian[particles.body[p]] else 0
        kept = setting.identity if lagrangian[particles.body[p]] else F
        half = size(setting.shape, frame.cell, kept)[0]
        for d in range(D):
            row.position[d], row.weight_position[d] = x[d], X[d] if row.lagrangian else x[d]
            row.half_width[d] = half[d]
            row.first_vertex[d] = first_vertex(frame, d, half[d], x[d])
            for e in range(D):
                row.centroid_offset[d] += F[D * d + e] * own[e]
            if own[d] != 0.0:
                row.cut = 1
        back = inverse(F)
        for d in range(D):
            for e in range(D):
                row.inverse_F[d, e] = back[D * d + e]
        body = particles.body[p]
        row.mass, row.volume = particles.m[p], particles.V0[p] * determinant(F)
        row.curvature_gap, row.body = particles.excess[p, 0], body
        row.group, row.field = groups[body], fields[body]


@kernel
def sum_at_contact_vertices(frame, table, supports, left, linear, patch, numbers, contact_vertices):
    """Sum particles into the vertices at their current positions, by group.

    Parameters
    ----------
    table, supports
        The particles, and their supports with `at`.
    left : Supports
        Supports of cut boxes, for the sums of volumes.
    linear : float
        1 if `left` has the whole supports, corrected by their gradient over the offset; else 0.
    patch, numbers
        See `pgimp.kernels.contact.lagrangian.shared_vertices.Patches`.
    contact_vertices : ContactVertices
        With keys; the sums are set.
    """
    D, sums = len(frame.origin), contact_vertices.sums
    for n in range(len(sums)):
        _clear_sums(sums[n])
    for i in range(len(table)):
        row = table[i]
        for q in range(len(supports.local)):
            x, y, z = weights_at(supports, i, q)
            S, n = x * y * z, numbers[patch[i], q]
            supports.at[i, q] = n if S != 0.0 else -1
            if n < 0 or S == 0.0:
                continue
            if sums[n].mass == 0.0:
                sums[n].body = row.body
            sums[n].mass += row.mass * S
            sums[n].curvature_gap += row.curvature_gap * S
            sums[n].cut_weight += row.cut * S
            number = vertex_at(supports, i, q)
            for d in range(D):
                at = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d]
                sums[n].mass_offset[d] += row.lagrangian * row.mass * S * (row.position[d] - at)
            x, y, z = weights_at(left, i, q)
            sums[n].volume += row.volume * (x * y * z)
            for d in range(D):
                slope = slope_at(left, i, q, d) * (frame.inverse[d] * row.volume)
                sums[n].surface[d] += slope
                sums[n].volume_correction += linear * (slope * row.centroid_offset[d])
