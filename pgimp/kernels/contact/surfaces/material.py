"""Gaps between facets and material in the current configuration, from what it fills before them.

Around a facet's centroid a tent, 1 there and 0 a cell away along each direction, weighs the volume
that a body fills. Before a flat face, at a distance g in cells, that part is c (1 - g)^2/2, with
c = 1 if the body reaches as far sideways as the tent. Its slope along the facet's normal is
c (1 - g). Both give g, whatever c is. The facet's own body is not looked at: its side of the plane
is known.
"""

from math import floor, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.jit.tuples import read
from pgimp.kernels.contact.volumes import MIN_HALF_WIDTH
from pgimp.kernels.transfer.first_vertex import deformation
from pgimp.physics.shapes.base import size

#: A particle near facets: the centroid of its part of a box, half-widths of the box around it in
#: cells, its volume, the curvature's share of its gap, whether it is cut, its body, its number.
MATERIAL = structure(
    ("position", "f8", 3),
    ("half", "f8", 3),
    ("volume", "f8"),
    ("excess", "f8"),
    ("cut", "f8"),
    ("body", "i8"),
    ("id", "i8"),
)

#: Sums at a facet over the particles of a body: volume, its gradient, the curvature's share of the
#: gap and the weight of cut particles.
SUMS = 6

#: Least part of a neighbourhood that a body fills, least cosine between a facet's normal and the
#: direction into the body.
_LEAST, _FACING = 0.01, 0.5

#: Part of the curvature's share of a gap that is the mean over a neighbourhood less the least one,
#: see `pgimp.geometry`: 1/12 of 1/12 + 1/16.
_MEAN = 4.0 / 7.0

#: Cells between places on the way into a body at which a cell is looked for, and how many, until
#: all its vertices have a part of the greatest mass there; the least part.
STEP, TRIES, _ENOUGH, _TOO_LITTLE, ABOVE_ROUNDING = 0.25, 7, 0.1, 1e-4, 1e-6


def no_material(count: int) -> NDArray:
    """Allocate for so many particles near facets."""
    return np.empty(count, MATERIAL)


@kernel
def greatest_speed(frame, particles, rows):
    """Greatest speed along a direction of the particles in `rows`, in cells per unit of time."""
    fastest = 0.0
    for p in rows:
        for d in range(len(frame.origin)):
            fastest = max(fastest, abs(particles.v[p, d] * frame.inverse[d]))
    return fastest


@kernel
def mark_cells(frame, particles, rows, taken, low, marks):
    """Mark the cells, of a box that begins at cell `low`, in which bodies have particles.

    `taken`, (bodies,) uint8, says which bodies.
    """
    for p in rows:
        if taken[particles.body[p]] == 0:
            continue
        i, j, k = _cell_of(frame, particles, p, low)
        if 0 <= i < marks.shape[0] and 0 <= j < marks.shape[1] and 0 <= k < marks.shape[2]:
            marks[i, j, k] = 1


@inner_kernel
def _cell_of(frame, particles, p, low):
    """Numbers of a particle's cell from cell `low` on; 0 along missing directions."""
    D = len(frame.cell)
    i = floor((particles.x[p, 0] - frame.origin[0]) * frame.inverse[0]) - low[0]
    j, k = 0, 0
    if D > 1:
        j = floor((particles.x[p, 1] - frame.origin[1]) * frame.inverse[1]) - low[1]
    if D > 2:
        k = floor((particles.x[p, 2] - frame.origin[2]) * frame.inverse[2]) - low[2]
    return i, j, k


@kernel
def copy_material(setting, particles, rows, taken, cells, found) -> int:
    """Copy the particles of bodies in marked cells; returns their number.

    Parameters
    ----------
    taken : (bodies,) uint8
        Which bodies.
    cells : ((3,) int64, (x, y, z) uint8)
        First cell and marks, see `mark_cells`.
    found : (room,) MATERIAL
        Filled as far as there is room.
    """
    count, frame, (low, marks) = 0, setting.frame, cells
    D = len(frame.origin)
    for p in rows:
        if taken[particles.body[p]] == 0:
            continue
        i, j, k = _cell_of(frame, particles, p, low)
        if not (0 <= i < marks.shape[0] and 0 <= j < marks.shape[1] and 0 <= k < marks.shape[2]):
            continue
        if marks[i, j, k] == 0:
            continue
        if count < len(found):
            row, F = found[count], deformation(frame, particles, p)
            x, own = (
                read(particles.x, p, 0, frame.origin),
                read(particles.offset, p, 0, frame.origin),
            )
            half = size(setting.shape, frame.cell, F)[0]
            row.cut = 0.0
            for d in range(3):
                row.position[d] = row.half[d] = 0.0
            for d in range(D):
                moved = 0.0
                for e in range(D):
                    moved += F[D * d + e] * own[e]
                row.position[d] = x[d] + moved
                row.half[d] = max(half[d] - abs(moved) * frame.inverse[d], MIN_HALF_WIDTH)
                if own[d] != 0.0:
                    row.cut = 1.0
            row.volume = particles.V0[p] * determinant(F)
            row.excess, row.body, row.id = (
                particles.excess[p, 0], particles.body[p], particles.id[p]
            )  # fmt: skip
        count += 1
    return count


@inner_kernel
def _tent(x):
    """Tent, 1 at 0 and 0 from -1 and 1 on."""
    return max(1.0 - abs(x), 0.0)


@inner_kernel
def _below(x):
    """Integral of the tent up to a place."""
    if x <= 0.0:
        return 0.5 * max(1.0 + x, 0.0) ** 2
    return 1.0 - 0.5 * max(1.0 - x, 0.0) ** 2


@inner_kernel
def _add(frame, row, x, sums):
    """Add a particle to the sums of its body at a facet's centroid `x`."""
    D, S = len(frame.cell), 1.0
    gx, gy, gz = 1.0, 1.0, 1.0
    for d in range(D):
        at, half = (row.position[d] - x[d]) * frame.inverse[d], row.half[d]
        if abs(at) >= 1.0 + half:
            return
        part = 0.5 / half
        w = (_below(at + half) - _below(at - half)) * part
        g = (_tent(at - half) - _tent(at + half)) * part * frame.inverse[d]
        S *= w
        gx *= g if d == 0 else w
        gy *= g if d == 1 else w
        gz *= g if d == 2 else w
    V = row.volume
    sums[0] += V * S
    sums[1] += V * gx
    sums[2] += V * gy if D > 1 else 0.0
    sums[3] += V * gz if D > 2 else 0.0
    sums[4] += S * row.excess
    sums[5] += S * row.cut


@kernel
def sum_material(frame, surface, some, table, bins, sums):
    """Sum the particles around the centroids of facets, by body.

    Parameters
    ----------
    some : (n,) int64
        The facets.
    table : (m,) MATERIAL
        The particles, by bins and numbers.
    bins : ((m,) int64, (3,) int64, (3,) int64, (3,) float64)
        Keys of the bins that they are in, ascending; strides of keys by direction; first bin; the
        bins' sides, over which no particle reaches.
    sums : (n, bodies, SUMS) float64
        Zero before.
    """
    D, (keys, strides, low, side) = len(frame.cell), bins
    for n in range(len(some)):
        x = surface.now[some[n]]
        at = (floor(x[0] / side[0]), floor(x[1] / side[1]), floor(x[2] / side[2]))
        middle = 0
        for d in range(D):
            middle += (at[d] - low[d]) * strides[d]
        for way in range(9):
            i, j = way // 3 - 1, way % 3 - 1
            if (i != 0 and D < 2) or (j != 0 and D < 3):
                continue
            # The last direction's neighbours have neighbouring keys.
            key = middle
            if D == 2:
                key += i * strides[0]
            elif D == 3:
                key += i * strides[0] + j * strides[1]
            first, last = 0, len(keys)
            while first < last:
                m = (first + last) // 2
                if keys[m] < key - 1:
                    first = m + 1
                else:
                    last = m
            while first < len(keys) and keys[first] <= key + 1:
                _add(frame, table[first], x, sums[n, table[first].body])
                first += 1


@inner_kernel
def flat_gap(part, slope):
    """Gap in cells before a flat face, below 0 behind it, by the part that a body fills.

    `slope` is the part's change by a cell along the facet's normal.
    """
    if 2.0 * part >= slope * slope and slope > 0.0:
        q = part / slope
        return 1.0 - 2.0 * q if q <= 0.5 else sqrt(q * q + 2.0) - q - 1.0
    if part <= 0.5:
        return 1.0 - sqrt(2.0 * part)
    return sqrt(2.0 * max(1.0 - part, 0.0)) - 1.0


@kernel
def find_material_gaps(frame, surface, some, sums, groups, far, every, into) -> int:
    """Find the gaps between facets and material before them; returns how many there are.

    Parameters
    ----------
    some : (n,) int64
        The facets, by patch.
    sums : (n, bodies, SUMS) float64
        See `sum_material`.
    groups : (bodies,) int64
        Groups of bonded bodies, whose parts add up; -1 of bodies that facets do not meet.
    far : float
        Greatest gap, in smallest sides of a cell.
    every : (room,) NEAR_FACET
        Filled as far as there is room: the body with most in each group, and as `place` the point
        of its surface before the facet.
    into : (room, 3) float64
        Filled with directions into it.
    """
    D, found, volume, least = len(frame.cell), 0, 1.0, inf
    for d in range(D):
        volume *= frame.cell[d]
        least = min(least, frame.cell[d])
    for n in range(len(some)):
        f = some[n]
        for b in range(sums.shape[1]):
            if groups[b] < 0 or not sums[n, b, 0] > 0.0:
                continue
            part, most, excess, cut = 0.0, True, 0.0, 0.0
            gx, gy, gz = 0.0, 0.0, 0.0
            for c in range(sums.shape[1]):
                if groups[c] != groups[b]:
                    continue
                part += sums[n, c, 0] / volume
                gx += sums[n, c, 1] / volume
                gy += sums[n, c, 2] / volume
                gz += sums[n, c, 3] / volume
                excess += sums[n, c, 4]
                cut += sums[n, c, 5]
                if sums[n, c, 0] > sums[n, b, 0] or (sums[n, c, 0] == sums[n, b, 0] and c < b):
                    most = False
            length, along, steep = 0.0, 0.0, sqrt(gx * gx + gy * gy + gz * gz)
            for d in range(D):
                length += (surface.turned[f, d] * frame.inverse[d]) ** 2
            length = 1.0 / sqrt(length)
            normal = (surface.turned[f, 0], surface.turned[f, 1], surface.turned[f, 2])
            along = normal[0] * gx + normal[1] * gy + normal[2] * gz
            if not most or part < _LEAST or not along > _FACING * steep:
                continue
            gap = flat_gap(part, min(along * length, 1.0)) * length
            if cut > 0.0:
                gap -= _MEAN * max(excess / cut, 0.0)
            if gap > far * least:
                continue
            if found < len(every):
                near, up = every[found], max(gap, 0.0)
                near.facet, near.body, near.other = f, b, -1
                near.gap, near.facing, near.pieces = gap, 1.0, 0
                for d in range(3):
                    near.normal[d] = -normal[d]
                    near.edges[0, d] = near.edges[1, d] = near.offset[d] = 0.0
                    near.place[d] = surface.now[f, d] + up * normal[d]
                into[found, 0], into[found, 1] = gx / steep, gy / steep
                into[found, 2] = gz / steep
            found += 1
    return found


@inner_kernel
def _cell_at(frame, near, into, n, tries, d):
    """Number of the cell along `d` that is some tries deep in the body, within the domain."""
    if d >= len(frame.cell):
        return 0
    at = (near.place[d] - frame.origin[d]) * frame.inverse[d]
    at += (STEP * tries + ABOVE_ROUNDING) * into[n, d]
    return min(max(floor(at), 0), frame.cells[d] - 1) + frame.ghost


@inner_kernel
def _corner_at(frame, near, into, n, tries, corner, d):
    """Number along `d` of a vertex of the cell at `_cell_at`."""
    D = len(frame.cell)
    first = _cell_at(frame, near, into, n, tries, d)
    return first + (corner >> (D - 1 - d) & 1) if d < D else 0


@kernel
def mark_vertices(frame, every, into, fields, low, marks):
    """Mark the vertices that may move facets' places in the other body.

    Parameters
    ----------
    fields : (bodies,) int64
        The bodies' velocity fields.
    low : (3,) int64
        The least vertex in `marks`.
    marks : (x, y, z, fields) int64
        Set to 1.
    """
    for n in range(len(every)):
        near = every[n]
        for tries in range(TRIES):
            for corner in range(1 << len(frame.cell)):
                x = _corner_at(frame, near, into, n, tries, corner, 0) - low[0]
                y = _corner_at(frame, near, into, n, tries, corner, 1) - low[1]
                z = _corner_at(frame, near, into, n, tries, corner, 2) - low[2]
                marks[x, y, z, fields[near.body]] = 1


@inner_kernel
def _set_corners(frame, every, into, fields, low, number, at, corners):
    """Set the numbers of a cell's vertices; `at` is which entry, and the tries."""
    n, tries = at
    for corner in range(1 << len(frame.cell)):
        x = _corner_at(frame, every[n], into, n, tries, corner, 0) - low[0]
        y = _corner_at(frame, every[n], into, n, tries, corner, 1) - low[1]
        z = _corner_at(frame, every[n], into, n, tries, corner, 2) - low[2]
        corners[n, corner] = number[x, y, z, fields[every[n].body]]


@kernel
def choose_cells(frame, every, into, fields, vertices, masses, corners):
    """Choose the cell of the other body's grid that moves each facet's place there.

    It is the first, on the way into the body, whose vertices all have enough mass. Its velocities
    are continued to the place: rows keep their sum and their first moments.

    Parameters
    ----------
    vertices : ((3,) int64, (x, y, z, fields) int64)
        The least vertex, and the numbers of the marked ones.
    masses : (m,) float64
        Their masses.
    corners : (n, 2^D) int64
        Set to the cells' vertices. Places become those in the cells. Where there is no cell, the
        gap becomes infinite.
    """
    D, (low, number) = len(frame.cell), vertices
    for n in range(len(every)):
        near, best, chosen, whole = every[n], 0.0, -1, 0.0
        for tries in range(TRIES):
            _set_corners(frame, every, into, fields, low, number, (n, tries), corners)
            for corner in range(1 << D):
                whole = max(whole, masses[corners[n, corner]])
        for tries in range(TRIES):
            if chosen >= 0 and best >= _ENOUGH * whole:
                continue
            least = inf
            _set_corners(frame, every, into, fields, low, number, (n, tries), corners)
            for corner in range(1 << D):
                least = min(least, masses[corners[n, corner]])
            if least > best:
                best, chosen = least, tries
        if chosen < 0 or best < _TOO_LITTLE * whole:
            near.gap = inf
            continue
        _set_corners(frame, every, into, fields, low, number, (n, chosen), corners)
        first = (
            _cell_at(frame, near, into, n, chosen, 0), _cell_at(frame, near, into, n, chosen, 1),
            _cell_at(frame, near, into, n, chosen, 2),
        )  # fmt: skip
        for d in range(D):
            x = near.place[d] - frame.origin[d]
            near.place[d] = x * frame.inverse[d] - (first[d] - frame.ghost)
