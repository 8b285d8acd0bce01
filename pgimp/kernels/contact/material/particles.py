"""Particles of the current configuration near facets: the cells there, copies, their order.

The cells, and the vertices that may move material there, are known for several steps.
"""

from math import floor, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.jit.tuples import read
from pgimp.kernels.contact.volumes import MIN_HALF_WIDTH
from pgimp.kernels.data.particles import IntArray
from pgimp.kernels.transfer.first_vertex import deformation, half_widths, is_axial

#: A particle near facets: the centroid of its part of a box, half-widths of the box around it in
#: cells, its volume (of rings the area of their section), the curvature's share of its gap, whether
#: it is cut, its body, the number of the cell that it is in, the greatest half-width of its box.
MATERIAL = structure(
    ("position", "f8", 3),
    ("half", "f8", 3),
    ("volume", "f8"),
    ("excess", "f8"),
    ("cut", "f8"),
    ("body", "i8"),
    ("cell", "i8"),
    ("reach", "f8"),
)

#: Vertices beyond a cell, below and above, on which its particles may have weight.
_BELOW, _ABOVE = 1, 2


class Region(NamedTuple):
    """Cells around facets near material, for several steps."""

    low: IntArray  #: (3,) int64: The first cell; 0 along periodic directions.
    period: IntArray  #: (3,) int64: Cells of a period by direction, 0 without one.
    near: IntArray  #: (x, y, z) int64: Numbers of the cells whose particles count; -1 of others.
    #: (x, y, z, slots) int64: Vertices by their places, see `vertex_in`, and velocity fields; -1
    #: for none.
    number: IntArray
    slot: IntArray  #: (bodies,) int64: Which of these fields a body has; -1 of bodies not met.


def no_material(count: int) -> NDArray:
    """Allocate for so many particles near facets."""
    return np.empty(count, MATERIAL)


@inner_kernel
def cell_in(region, c, d):
    """Place along `d` of a cell, which may be an image, in a region; -1 outside."""
    if region.period[d] > 0:
        return c % region.period[d]
    at = c - region.low[d]
    return at if at < region.near.shape[d] else -1


@inner_kernel
def image(frame, region, c, d):
    """Length by which the image of a cell along `d` is beyond the cell itself."""
    if region.period[d] == 0:
        return 0.0
    return (c - c % region.period[d]) * frame.cell[d]


@inner_kernel
def vertex_in(region, v, d):
    """Place along `d` of a vertex, by its number from the domain's first, among a region's."""
    if region.period[d] > 0:
        return v % region.period[d]
    return v - region.low[d] + _BELOW


@inner_kernel
def cell_at(frame, x, d):
    """Number along `d` of the cell at a place, from the domain's first; 0 of missing directions."""
    if d >= len(frame.cell):
        return 0
    return floor((x - frame.origin[d]) * frame.inverse[d])


@inner_kernel
def _place_in(frame, region, particles, p):
    """Places of a particle's cell in a region; the first is -1 outside."""
    D = len(frame.cell)
    i = cell_in(region, cell_at(frame, particles.x[p, 0], 0), 0)
    j = cell_in(region, cell_at(frame, particles.x[p, 1], 1), 1) if D > 1 else 0
    k = cell_in(region, cell_at(frame, particles.x[p, 2], 2), 2) if D > 2 else 0
    return (i, j, k) if min(i, j, k) >= 0 else (-1, 0, 0)


@kernel
def greatest_speed(frame, particles, rows):
    """Greatest speed along a direction of the particles in `rows`, in cells per unit of time."""
    fastest = 0.0
    for p in rows:
        for d in range(len(frame.origin)):
            fastest = max(fastest, abs(particles.v[p, d] * frame.inverse[d]))
    return fastest


@kernel
def mark_cells(frame, region, particles, rows, marks):
    """Mark the cells of a region in which bodies have particles.

    Parameters
    ----------
    marks : (x, y, z, slots) uint8
        Set to 1, by velocity fields.
    """
    for p in rows:
        s = region.slot[particles.body[p]]
        if s < 0:
            continue
        i, j, k = _place_in(frame, region, particles, p)
        if i >= 0:
            marks[i, j, k, s] = 1


@kernel
def find_near_clusters(ends, region, marks, found):
    """Find the boxes of cells in which there is material, and mark all their cells as near, by 0.

    Parameters
    ----------
    ends : (2, n, 3) int64
        First and last cells of the boxes.
    marks : (x, y, z, slots) uint8
        See `mark_cells`.
    found : (n,) uint8
        Set to 1 of those with material.
    """
    near = region.near
    for n in range(len(found)):
        found[n] = 0
        for way in range(2):
            if way == 1 and found[n] == 0:
                continue
            for a in range(ends[0, n, 0], ends[1, n, 0] + 1):
                i = cell_in(region, a, 0)
                for b in range(ends[0, n, 1], ends[1, n, 1] + 1):
                    j = cell_in(region, b, 1)
                    for c in range(ends[0, n, 2], ends[1, n, 2] + 1):
                        k = cell_in(region, c, 2)
                        if min(i, j, k) < 0:
                            continue
                        if way == 1:
                            near[i, j, k] = 0
                            continue
                        for s in range(marks.shape[3]):
                            if marks[i, j, k, s]:
                                found[n] = 1


@inner_kernel
def _mark_vertices(frame, region, at, s):
    """Mark the vertices on which particles of a cell may have weight; `at` is its place."""
    D = len(frame.cell)
    for way in range(4**D):
        inside, i, j, k = True, 0, 0, 0
        for d in range(D):
            v = at[d] + region.low[d] - _BELOW + (way // 4**d) % 4
            inside = inside and (region.period[d] > 0 or 0 <= v <= frame.cells[d])
            place = vertex_in(region, v, d)
            if d == 0:
                i = place
            elif d == 1:
                j = place
            else:
                k = place
        if inside:
            region.number[i, j, k, s] = 0


@kernel
def number_region(frame, region, marks, numbers) -> tuple[int, int]:
    """Number the cells that are near, and the vertices that may move material in them.

    Returns how many there are of both.

    Parameters
    ----------
    region : Region
        Its `number` is -1 before.
    marks : (x, y, z, slots) uint8
        See `mark_cells`.
    numbers : (room, 4) int64
        Filled as far as there is room: numbers in the whole grid, and slots.
    """
    near, number, cells, found, D = region.near, region.number, 0, 0, len(frame.cell)
    for i in range(near.shape[0]):
        for j in range(near.shape[1]):
            for k in range(near.shape[2]):
                if near[i, j, k] < 0:
                    continue
                near[i, j, k] = cells
                cells += 1
                for s in range(marks.shape[3]):
                    if marks[i, j, k, s]:
                        _mark_vertices(frame, region, (i, j, k), s)
    for i in range(number.shape[0]):
        for j in range(number.shape[1]):
            for k in range(number.shape[2]):
                for s in range(number.shape[3]):
                    if number[i, j, k, s] < 0:
                        continue
                    number[i, j, k, s] = found
                    if found < len(numbers):
                        for d in range(3):
                            v = i if d == 0 else (j if d == 1 else k)
                            v += 0 if region.period[d] > 0 else region.low[d] - _BELOW
                            numbers[found, d] = v + frame.ghost if d < D else 0
                        numbers[found, 3] = s
                    found += 1
    return cells, found


def room_for_vertices(extent: np.ndarray, period: np.ndarray, D: int, slots: int) -> NDArray:
    """The `number` of a `Region` whose cells have an extent, without any vertex."""
    size = np.where(period > 0, extent, extent + _BELOW + _ABOVE)
    size[D:] = 1
    return np.full((*size, slots), -1, np.int64)


@inlined
def _section(frame, volume, x):
    """Volume of a particle; of a ring about a place the area of its section."""
    return volume / (2.0 * pi * x) if is_axial(frame) else volume


@kernel
def copy_material(setting, region, particles, rows, found) -> int:
    """Copy the particles of bodies in cells that are near; returns their number.

    Parameters
    ----------
    found : (room,) MATERIAL
        Filled as far as there is room; positions are those of images in the domain.
    """
    count, frame = 0, setting.frame
    D = len(frame.origin)
    for p in rows:
        if region.slot[particles.body[p]] < 0:
            continue
        i, j, k = _place_in(frame, region, particles, p)
        if i < 0 or region.near[i, j, k] < 0:
            continue
        count += 1
        if count > len(found):
            continue
        row, F = found[count - 1], deformation(frame, particles, p)
        own = read(particles.offset, p, 0, frame.origin)
        half = half_widths(setting.shape, frame, particles, p)
        row.cut, row.cell, row.reach = 0.0, region.near[i, j, k], 0.0
        for d in range(3):
            row.position[d] = row.half[d] = 0.0
        for d in range(D):
            moved = 0.0
            for e in range(D):
                moved += F[D * d + e] * own[e]
            x = particles.x[p, d]
            row.position[d] = x + moved - image(frame, region, cell_at(frame, x, d), d)
            row.reach = max(row.reach, half[d])
            row.half[d] = max(half[d] - abs(moved) * frame.inverse[d], MIN_HALF_WIDTH)
            if own[d] != 0.0:
                row.cut = 1.0
        row.volume = _section(frame, particles.V0[p] * determinant(F), row.position[0])
        row.excess, row.body = particles.excess[p, 0], particles.body[p]
    return count


@kernel
def sort_material(table, start, order) -> float:
    """Sort particles by their cells; those of one cell stay in their order.

    Returns how far they reach from their places at most, in cells.

    Parameters
    ----------
    table : (n,) MATERIAL
        The particles.
    start : (cells + 1,) int64
        Set to the first of each cell in the order.
    order : (n,) int64
        Set to their offsets.
    """
    start[:], reach = 0, 0.0
    for n in range(len(table)):
        start[table[n].cell + 1] += 1
        reach = max(reach, table[n].reach)
    for c in range(1, len(start)):
        start[c] += start[c - 1]
    for n in range(len(table)):
        c = table[n].cell
        order[start[c]] = n
        start[c] += 1
    for c in range(len(start) - 1, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0
    return reach
