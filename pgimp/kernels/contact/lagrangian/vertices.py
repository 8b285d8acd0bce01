"""Present places of bodies in the initial configuration, and their sums at the grid's vertices.

Their own grid is that of the start, without neighbours. Where they come near each other, a rigid
body or a wall that lets go, the particles there are summed once more, at their present places, into
the vertices of the domain's grid: part filled, surface, and gap follow as they do in
the current configuration (`pgimp.kernels.contact.data`). Pairs at such a vertex are in
`pgimp.kernels.contact.lagrangian.pairs`, responses to impulses there in
`pgimp.kernels.contact.lagrangian.gauss_seidel`.

A vertex has a number for each *group* of bodies that are bonded; those of the vertices that are
shared are found by hash tables (`pgimp.kernels.contact.lagrangian.shared_vertices`), so that memory
does not grow with their distances.
"""

from typing import NamedTuple

from pgimp.jit.algebra import determinant, inverse
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.tuples import read
from pgimp.kernels.contact.lagrangian.supports import slope_at, vertex_at, weights_at
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.transfer.first_vertex import deformation, first_vertex
from pgimp.physics.shapes.base import size

#: Columns of a particle near a meeting: present position and that of its weights, mass, volume,
#: offset of the volume's centroid, the curvature's share of the gap, whether it is cut, body,
#: group, field, whether its weights are those of the start, its half-widths in cells, the inverse
#: of its deformation gradient, and the first vertex of its present support.
PLACE, START, WEIGHS, VOLUME, OFFSET, BENT, CUT, BODY, GROUP, FIELD, BEGUN, HALF, BACK, FIRST = (
    0, 3, 6, 7, 8, 11, 12, 13, 14, 15, 16, 17, 20, 29,
)  # fmt: skip
NEAR = 32

#: Columns of a group's sums at a vertex: mass, volume, surface, the offset's correction of the
#: volume, the curvature's share of the gap and the number in its mean, body; way to the centre of
#: mass, times the mass, of bodies in the initial configuration: others have the vertex itself.
HEAVY, FILLS, FACES, MORE, CURVED, OF_CUT, WHOSE, WAY, SUMMED = 0, 1, 2, 5, 6, 7, 8, 9, 12


class Present(NamedTuple):
    """Sums of groups at the vertices of the domain's grid, one entry a group and vertex.

    Attributes
    ----------
    low, extent : (3,) int64
        The least vertex, and how many there may be from it on, by direction.
    groups : int
        How many groups there are.
    keys : (m,) int64
        Keys of the entries; in the order of x, y, z, group if sorted.
    sums : (m, SUMMED) float64
        The sums.
    order : (n,) int64
        The numbers of the entries with mass, so that keys ascend.
    """

    low: IntArray
    extent: IntArray
    groups: int
    keys: IntArray
    sums: FloatArray
    order: IntArray


@inner_kernel
def key_of(present, number, group):
    """Key of a group at a vertex, given by its numbers."""
    low, extent = present.low, present.extent
    key = (number[0] - low[0]) * extent[1] + number[1] - low[1]
    return (key * extent[2] + number[2] - low[2]) * present.groups + group


@inner_kernel
def number_of(present, vertex):
    """Numbers of a vertex, which is a key over the number of groups."""
    low, extent = present.low, present.extent
    rest = vertex // extent[2]
    return rest // extent[1] + low[0], rest % extent[1] + low[1], vertex % extent[2] + low[2]


@kernel
def take_near(setting, particles, rows, groups, fields, begun, table):
    """Copy the particles near a meeting, (n, NEAR) float64, in canonical order.

    `groups`, `fields` and `begun`, of the bodies, are as in `PresentMeetings`.
    """
    frame = setting.frame
    for i in range(len(rows)):
        p, row = rows[i], table[i]
        row[:] = 0.0
        F = deformation(frame, particles, p)
        own, x = read(particles.offset, p, 0, frame.origin), read(particles.x, p, 0, frame.origin)
        X, D = read(particles.origin, p, 0, frame.origin), len(frame.origin)
        row[BEGUN] = begun[particles.body[p]]
        kept = setting.identity if begun[particles.body[p]] else F
        half = size(setting.shape, frame.cell, kept)[0]
        for d in range(D):
            row[PLACE + d], row[START + d] = x[d], X[d] if row[BEGUN] else x[d]
            row[HALF + d] = half[d]
            row[FIRST + d] = first_vertex(frame, d, half[d], x[d])
            for e in range(D):
                row[OFFSET + d] += F[D * d + e] * own[e]
            if own[d] != 0.0:
                row[CUT] = 1.0
        back = inverse(F)
        for d in range(D):
            for e in range(D):
                row[BACK + 3 * d + e] = back[D * d + e]
        body = particles.body[p]
        row[WEIGHS], row[VOLUME] = particles.m[p], particles.V0[p] * determinant(F)
        row[BENT], row[BODY] = particles.excess[p, 0], body
        row[GROUP], row[FIELD] = groups[body], fields[body]


@kernel
def sum_present(frame, table, supports, left, linear, patch, numbers, present):
    """Sum particles into the vertices at their present places, by group.

    Parameters
    ----------
    table, supports
        The particles, and their supports, of which `at` is set.
    left : Supports
        Of what is left of cut particles, for the sums of volumes.
    linear : float
        1 where these are the whole ones, and their change over the offset counts, else 0.
    patch, numbers
        See `pgimp.kernels.contact.lagrangian.shared_vertices.Patches`.
    present : Present
        With keys; the sums are set.
    """
    D, sums = len(frame.origin), present.sums
    sums[:, :] = 0.0
    for i in range(len(table)):
        row = table[i]
        for q in range(len(supports.local)):
            x, y, z = weights_at(supports, i, q)
            S, n = x * y * z, numbers[patch[i], q]
            supports.at[i, q] = n if S != 0.0 else -1
            if n < 0 or S == 0.0:
                continue
            if sums[n, HEAVY] == 0.0:
                sums[n, WHOSE] = row[BODY]
            sums[n, HEAVY] += row[WEIGHS] * S
            sums[n, CURVED] += row[BENT] * S
            sums[n, OF_CUT] += row[CUT] * S
            number = vertex_at(supports, i, q)
            for d in range(D):
                at = frame.origin[d] + (number[d] - frame.ghost) * frame.cell[d]
                sums[n, WAY + d] += row[BEGUN] * row[WEIGHS] * S * (row[PLACE + d] - at)
            x, y, z = weights_at(left, i, q)
            sums[n, FILLS] += row[VOLUME] * (x * y * z)
            for d in range(D):
                slope = slope_at(left, i, q, d) * (frame.inverse[d] * row[VOLUME])
                sums[n, FACES + d] += slope
                sums[n, MORE] += linear * (slope * row[OFFSET + d])
