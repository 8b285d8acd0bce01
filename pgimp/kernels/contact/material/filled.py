"""Gaps between facets and material in the current configuration, from what it fills before them.

Around a facet's centroid a tent, 1 there and 0 a cell away along each direction, weighs the volume
that a body fills. Before a flat face, at a distance g in cells, that part is c (1 - g)^2/2, with
c = 1 if the body reaches as far sideways as the tent. Its slope along the facet's normal is
c (1 - g). Both give g, whatever c is. The facet's own body is not looked at: its side of the plane
is known.
"""

from math import inf, isfinite, sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.material.particles import cell_at, cell_in, image

#: Sums at a facet over the particles of a body: volume, its gradient, the curvature's share of the
#: gap and the weight of cut particles.
SUMS = 6

#: Least part of a neighbourhood that a body fills, least cosine between a facet's normal and the
#: direction into the body.
_LEAST, _FACING = 0.01, 0.5

#: Part of the curvature's share of a gap that is the mean over a neighbourhood less the least one,
#: see `pgimp.geometry`: 1/12 of 1/12 + 1/16.
_MEAN = 4.0 / 7.0


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
    """Add a particle to the sums of its body at a facet's centroid; whether it reaches there."""
    D, S = len(frame.cell), 1.0
    gx, gy, gz = 1.0, 1.0, 1.0
    for d in range(D):
        at, half = (row.position[d] - x[d]) * frame.inverse[d], row.half[d]
        if abs(at) >= 1.0 + half:
            return False
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
    return True


@inner_kernel
def _cells(frame, x, reach, d):
    """First and last cell along `d` whose particles may reach a tent, given how far they do."""
    if d >= len(frame.cell):
        return 0, 0
    away = (1.0 + reach) * frame.cell[d]
    return cell_at(frame, x - away, d), cell_at(frame, x + away, d)


@inner_kernel
def _sum_around(frame, x, material, scratch):
    """Sum the particles around a place, by body; returns how many bodies there are.

    `scratch` are the sums, (bodies, SUMS), and the bodies found; `material` as of
    `find_material_gaps`.
    """
    (table, order, start, reach, region), (sums, bodies), count = material, scratch, 0
    D = len(frame.cell)
    for d in range(D):
        if not isfinite(x[d]) or abs(x[d] * frame.inverse[d]) > 1e15:
            return 0
    first, second, third = (
        _cells(frame, x[0], reach, 0), _cells(frame, x[1], reach, 1), _cells(frame, x[2], reach, 2)
    )  # fmt: skip
    for a in range(first[0], first[1] + 1):
        i = cell_in(region, a, 0)
        away = x[0] - image(frame, region, a, 0)
        for b in range(second[0], second[1] + 1):
            if i < 0:
                continue
            j = cell_in(region, b, 1) if D > 1 else 0
            aside = x[1] - image(frame, region, b, 1)
            for c in range(third[0], third[1] + 1):
                k = cell_in(region, c, 2) if D > 2 else 0
                cell = region.near[i, j, k] if min(j, k) >= 0 else -1
                if cell < 0:
                    continue
                at = (away, aside, x[2] - image(frame, region, c, 2))
                for n in range(start[cell], start[cell + 1]):
                    row, known = table[order[n]], False
                    for m in range(count):
                        known = known or bodies[m] == row.body
                    if not known:
                        for entry in range(SUMS):
                            sums[row.body, entry] = 0.0
                    if _add(frame, row, at, sums[row.body]) and not known:
                        bodies[count] = row.body
                        count += 1
    return count


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


@inner_kernel
def _gap_of(frame, normal, filled):
    """Gap between a facet and what fills a part of the tent, and the direction into it.

    Infinite before what is too little, or comes from the side. `filled` are the part, its gradient,
    the curvature's share and the weight of cut particles.
    """
    part, (gx, gy, gz), excess, cut = filled
    length, steep = 0.0, sqrt(gx * gx + gy * gy + gz * gz)
    for d in range(len(frame.cell)):
        length += (normal[d] * frame.inverse[d]) ** 2
    length = 1.0 / sqrt(length)
    along = normal[0] * gx + normal[1] * gy + normal[2] * gz
    if part < _LEAST or not along > _FACING * steep:
        return inf, (0.0, 0.0, 0.0)
    gap = flat_gap(part, min(along * length, 1.0)) * length
    if cut > 0.0:
        gap -= _MEAN * max(excess / cut, 0.0)
    return gap, (gx / steep, gy / steep, gz / steep)


@kernel
def find_material_gaps(frame, surface, some, material, groups, far, scratch, found) -> int:
    """Find the gaps between facets and material before them; returns how many there are.

    Parameters
    ----------
    some : (n,) int64
        The facets, by patch.
    material : ((m,) MATERIAL, (m,) int64, (cells + 1,) int64, float, Region)
        The particles, and by cells their order, the first of each in it, and how far they reach.
    groups : (bodies,) int64
        Groups of bonded bodies, whose parts add up; -1 of bodies that facets do not meet.
    far : float
        Greatest gap, in smallest sides of a cell.
    scratch : ((bodies, SUMS) float64, (bodies,) int64)
    found : ((room,) NEAR_FACET, (room, 3) float64)
        Filled as far as there is room: the body with most in each group, and as `place` the point
        of its surface before the facet; and directions into it.
    """
    D, count, volume, least, (every, into) = len(frame.cell), 0, 1.0, inf, found
    sums, bodies = scratch
    for d in range(D):
        volume *= frame.cell[d]
        least = min(least, frame.cell[d])
    for n in range(len(some)):
        f = some[n]
        there = _sum_around(frame, surface.now[f], material, scratch)
        normal = (surface.turned[f, 0], surface.turned[f, 1], surface.turned[f, 2])
        for m in range(there):
            b, most = bodies[m], True
            if groups[b] < 0 or not sums[b, 0] > 0.0:
                continue
            part, gx, gy, gz, excess, cut = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for other in range(there):
                c = bodies[other]
                if groups[c] != groups[b]:
                    continue
                part += sums[c, 0] / volume
                gx += sums[c, 1] / volume
                gy += sums[c, 2] / volume
                gz += sums[c, 3] / volume
                excess += sums[c, 4]
                cut += sums[c, 5]
                more = sums[c, 0] - sums[b, 0]
                most = most and not (more > 0.0 or (more == 0.0 and c < b))
            if not most:
                continue
            gap, way = _gap_of(frame, normal, (part, (gx, gy, gz), excess, cut))
            if gap > far * least:
                continue
            if count < len(every):
                near, up = every[count], max(gap, 0.0)
                near.facet, near.body, near.other = f, b, -1
                near.gap, near.facing, near.piece, near.pieces = gap, 1.0, 0, 0
                for d in range(3):
                    near.normal[d] = -normal[d]
                    near.edges[0, d] = near.edges[1, d] = near.offset[d] = 0.0
                    near.place[d] = surface.now[f, d] + up * normal[d]
                    into[count, d] = way[d]
            count += 1
    return count
