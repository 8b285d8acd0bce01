"""Cells of the grid in which material before facets moves, also across seams.

It is the cell at the place, if all its vertices have some mass: so uniform stress there gives each
vertex the force that the facets give it. Material without such a cell moves as a cell behind.
"""

from math import inf

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.material.particles import cell_at, vertex_in

#: Cells between places on the way into a body at which a cell is looked for, and how many, until
#: all its vertices have a part of the greatest mass there; the least part.
STEP, TRIES, ENOUGH, TOO_LITTLE, ABOVE_ROUNDING = 0.25, 7, 1e-3, 1e-4, 1e-6


@inner_kernel
def _cell(frame, region, near, way, tries, d):
    """Number along `d` of the cell that is some tries deep in the body; images within the domain.

    Number 0 is the domain's first. Beyond seams they are images.
    """
    if d >= len(frame.cell):
        return 0
    c = cell_at(frame, near.place[d] + (STEP * tries + ABOVE_ROUNDING) * way[d] * frame.cell[d], d)
    return c if region.period[d] > 0 else min(max(c, 0), frame.cells[d] - 1)


@inner_kernel
def _vertex(frame, region, first, corner, s):
    """Number of a vertex of the cell `first` in a field, -1 without one."""
    D, at = len(frame.cell), (0, 0, 0)
    i = vertex_in(region, first[0] + (corner >> (D - 1) & 1), 0)
    j = vertex_in(region, first[1] + (corner >> (D - 2) & 1), 1) if D > 1 else at[1]
    k = vertex_in(region, first[2] + (corner & 1), 2) if D > 2 else at[2]
    most = region.number.shape
    if not (0 <= i < most[0] and 0 <= j < most[1] and 0 <= k < most[2]):
        return -1
    return region.number[i, j, k, s]


@inner_kernel
def _masses(frame, region, first, s, values):
    """Least and greatest mass of the vertices of a cell in a field; 0 of those without a number."""
    least, most = inf, 0.0
    for corner in range(1 << len(frame.cell)):
        n = _vertex(frame, region, first, corner, s)
        mass = values[n].mass if n >= 0 else 0.0
        least, most = min(least, mass), max(most, mass)
    return least, most


@kernel
def choose_cells(frame, region, every, into, values, columns) -> float:
    """Choose the cell of the other body's grid that moves each facet's place there.

    It is the first, on the way into the body, whose vertices all have enough mass. Its velocities
    are continued to the place: rows keep their sum and their first moments.

    Parameters
    ----------
    every : (n,) NEAR_FACET
        Facets near material. Places become those in the cells. Where there is no cell, the gap
        becomes infinite.
    into : (n, 3) float64
        Directions into the other body.
    values : (v,) REFERENCE_VERTEX
        Vertices, of which the region has the numbers.
    columns : (n, 2^D) int64
        Set to the vertices of the cells, as numbers of `values`.

    Returns
    -------
    float
        Greatest component of a velocity.
    """
    D, fastest = len(frame.cell), 0.0
    for v in range(len(values)):
        for d in range(D):
            fastest = max(fastest, abs(values[v].velocity[d]))
    for n in range(len(every)):
        near, s, best, whole = every[n], region.slot[every[n].body], 0.0, 0.0
        chosen, last, least, most = (0, 0, 0), (-1, -1, -1), 0.0, 0.0
        for way in range(2):
            for tries in range(TRIES):
                if way == 1 and best >= ENOUGH * whole and best > 0.0:
                    continue
                first = (
                    _cell(frame, region, near, into[n], tries, 0),
                    _cell(frame, region, near, into[n], tries, 1),
                    _cell(frame, region, near, into[n], tries, 2),
                )
                if first != last or (way == 1 and tries == 0):
                    least, most = _masses(frame, region, first, s, values)
                    last = first
                whole = max(whole, most)
                if way == 1 and least > best:
                    best, chosen = least, first
        if best < TOO_LITTLE * whole or best == 0.0:
            near.gap = inf
        for corner in range(1 << D):
            columns[n, corner] = max(_vertex(frame, region, chosen, corner, s), 0)
        for d in range(D):
            x = near.place[d] - frame.origin[d]
            near.place[d] = x * frame.inverse[d] - chosen[d]
    return fastest
