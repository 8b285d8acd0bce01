"""Rigid bodies at the vertices: the filled part of a neighbourhood, and their surface's normal.

A vertex weighs its neighbourhood with tents of the sides of two cells. Each is the sum of three
tents of half the size, with a quarter, a half, a quarter of the weight. The part of each on the
inner side of a plane follows from the distance of its middle. So the filled part is exact for a
flat surface at any angle, and edges are rounded by an eighth of a cell only. For nearly flat
surfaces the vertex's own tent and the mean distance are enough.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.select import include
from pgimp.kernels.data.used_rows import next_rows, rows_with
from pgimp.kernels.rigid.bodies import find_distance, least_distance, position_of, turns_back
from pgimp.kernels.rigid.tents import cut

#: Difference between the mean distance and the distance at the vertex, as part of a cell along the
#: surface. From this on the surface does not count as flat.
FLAT = 0.02

#: Distance from which on no bound for a near body holds, over the sum of a cell's sides.
CERTAINLY = 1.0 + FLAT + 1e-3

#: Whether a vertex is near any rigid body.
FAR, NEAR = 1, 2

#: Component of a normal along a wall's normal that is rounding: the wall is then perpendicular.
SQUARE = 1e-9

#: Curvature's share of the mean gap over its share of the mean distance, which is k/16 in cells;
#: see `pgimp.scene.bodies.lattice_body`. From `SHARP` of a cell on it is an edge.
BEND, SHARP = (1.0 / 12.0 + 1.0 / 16.0) * 16.0, 0.5 / 16.0


@inner_kernel
def halves(rigid_bodies, frame, part):
    """Half sides of a tent, `part` of a cell, times the last normal; the greatest first."""
    a, b, c = 0.0, 0.0, 0.0
    for d in range(len(frame.cell)):
        half = abs(rigid_bodies.point[0].normal[d]) * part * frame.cell[d]
        a, half = max(a, half), min(a, half)
        b, c = max(b, half), max(c, min(b, half))
    return a, b, c


@inner_kernel
def tangent(frame, point):
    """Side of a cell along the surface with the last normal, over which it may be curved."""
    square, D = 0.0, len(frame.cell)
    for d in range(D):
        square += frame.cell[d] ** 2 * (1.0 - point.normal[d] ** 2)
    return sqrt(square / (D - 1)) if D > 1 else frame.cell[0]


@inner_kernel
def _far(frame):
    """Distance from which on no vertex is near: greater than all bounds in `_is_near`."""
    most = 0.0
    for d in range(len(frame.cell)):
        most += frame.cell[d]
    return CERTAINLY * most


@inner_kernel
def _clear_vertices(rigid_bodies, t, frame, number):
    """Number of vertices along a line from a vertex on that are certainly far; 0 if it may be near.

    From one point to the next the distance changes by no more than the way; twice that is allowed.
    """
    x, y, z = position_of(frame, number)
    most, D = 0.0, len(frame.cell)
    for d in range(D):
        most = max(most, frame.cell[d])
    spare = least_distance(rigid_bodies, t, D, x, y, z)
    if spare == 1e300:  # it may be outside of the lattice only here
        return 1
    if turns_back(rigid_bodies):
        return 1 if spare > _far(frame) else 0
    spare -= _far(frame)
    if not spare > 0.0:
        return 0
    way = 0.5 * spare - 2.0 * D * rigid_bodies.motion[t].spacing
    return 1 + int(max(way, 0.0) / most)


@inner_kernel
def _is_near(rigid_bodies, t, frame, number):
    """Set distance and normal at a vertex; returns whether the body may be near."""
    lattice, point, D = rigid_bodies.lattice[t], rigid_bodies.point[0], len(frame.cell)
    square, along = 0.0, 0.0
    for d in range(D):
        if number[d] < lattice.least[d] or number[d] > lattice.most[d]:
            return False
        square += frame.cell[d] ** 2
    x, y, z = position_of(frame, number)
    if least_distance(rigid_bodies, t, D, x, y, z) > _far(frame):
        return False
    find_distance(rigid_bodies, t, D, x, y, z)
    for d in range(D):
        along += abs(point.normal[d]) * frame.cell[d]
    if abs(point.mean_distance - point.distance) < FLAT * tangent(frame, point):
        return point.mean_distance < along
    return point.distance <= sqrt(square)


@inner_kernel
def fill(rigid_bodies, t, frame, number, sides):
    """Set the part of a vertex's neighbourhood filled by body `t`; returns whether it is near.

    Parameters
    ----------
    number : (int, int, int)
        The vertex.
    sides : (int, int, int)
        -1 or 1 on a wall at the low or the high end, by direction: the neighbourhood ends
        there.
    """
    if not _is_near(rigid_bodies, t, frame, number):
        return False
    point, D = rigid_bodies.point[0], len(frame.cell)
    reach, volume = 0.0, 1.0
    for d in range(D):
        reach += frame.cell[d] ** 2
        volume *= frame.cell[d] * (1.0 if sides[d] == 0 else 0.5)
    reach = sqrt(reach)
    bent = point.mean_distance - point.distance
    wide = tangent(frame, point)
    point.curvature_gap = BEND * bent if abs(bent) < SHARP * wide else 0.0
    x, y, z = position_of(frame, number)
    n0, n1, n2 = point.normal[0], point.normal[1], point.normal[2]
    if point.distance < -reach:  # deep inside
        point.filled, scale = 1.0, volume / reach
        point.surface[0], point.surface[1], point.surface[2] = scale * n0, scale * n1, scale * n2
        return True
    halved = True  # whole, or cut by walls perpendicular to the surface: planes of symmetry
    for d in range(D):
        halved = halved and (sides[d] == 0 or abs(point.normal[d]) < SQUARE)
    if halved and abs(bent) < FLAT * wide:
        a, b, c = halves(rigid_bodies, frame, 1.0)
        filled, slope = cut(a, b, c, -point.mean_distance)
        point.filled, scale = filled, volume * max(slope, 1e-3 / reach)
        point.surface[0], point.surface[1], point.surface[2] = scale * n0, scale * n1, scale * n2
        return filled > 0.0
    filled, s0, s1, s2 = 0.0, 0.0, 0.0, 0.0
    count = 1
    for _ in range(D):
        count *= 3
    for corner in range(count):
        weight, code = 1.0, corner
        px, py, pz = x, y, z
        for d in range(D):
            off = code % 3 - 1
            code //= 3
            if sides[d] == 0:
                weight *= 0.5 if off == 0 else 0.25
            else:  # half of the middle one, and the inner one
                weight *= 0.0 if off == sides[d] else 0.5
            move = 0.5 * off * frame.cell[d]
            px, py, pz = (
                px + move if d == 0 else px,
                py + move if d == 1 else py,
                pz + move if d == 2 else pz,
            )
        if weight == 0.0:
            continue
        find_distance(rigid_bodies, t, D, px, py, pz)
        if point.distance > reach:
            continue
        a, b, c = halves(rigid_bodies, frame, 0.5)
        if not a > 0.0:
            filled += weight if point.distance < 0.0 else 0.0
            continue
        part, slope = cut(a, b, c, -point.distance)
        filled += weight * part
        s0 += weight * slope * point.normal[0]
        s1 += weight * slope * point.normal[1]
        s2 += weight * slope * point.normal[2]
    point.filled = filled
    length = sqrt(s0 * s0 + s1 * s1 + s2 * s2)
    if length > 1e-3 / reach:
        point.surface[0], point.surface[1], point.surface[2] = volume * s0, volume * s1, volume * s2
    else:
        scale = volume / reach
        point.surface[0], point.surface[1], point.surface[2] = scale * n0, scale * n1, scale * n2
    return filled > 0.0


@kernel
def find_rigid_vertices(frame, field, rigid_bodies, near, marks, vertex_counts, vertex_ranges):
    """Count, in each of a rank's planes, the vertices with mass that are near a rigid body.

    Parameters
    ----------
    field : Field
        After the halo exchange.
    near : (planes, y, z) int8
        Set to `NEAR` at these vertices, to `FAR` at other ones that have mass, elsewhere to 0.
    marks : (planes, y, z) int64
        As `find_contact_vertices` has set them.
    vertex_counts, vertex_ranges
        As there; they grow by these vertices.
    """
    window, D = field.window, len(frame.cell)
    near[:] = 0
    for t in range(len(rigid_bodies.motion)):
        low, high = (0, 0, 0), (0, 0, 0)
        for d in range(D):
            a = max(0, rigid_bodies.lattice[t].least[d] - window.lower[d])
            b = min(window.extent[d] - 1, rigid_bodies.lattice[t].most[d] - window.lower[d])
            low = (a if d == 0 else low[0], a if d == 1 else low[1], a if d == 2 else low[2])
            high = (b if d == 0 else high[0], b if d == 1 else high[1], b if d == 2 else high[2])
        for i in range(low[0], min(high[0], len(vertex_counts) - 1) + 1):
            if field.active[i] == 0:
                continue
            left, clear = rows_with(field, i, 1), -1
            while left:
                begin, end, left = next_rows(field, left)
                for j in range(max(begin, low[1]), min(end, high[1] + 1)):
                    clear = -1 if D > 2 else clear
                    for k in range(low[2], high[2] + 1):
                        if marks[i, j, k] == 0:
                            continue
                        near[i, j, k] = max(near[i, j, k], FAR)
                        here = k if D > 2 else j
                        if here < clear:
                            continue
                        number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                        clear = here + _clear_vertices(rigid_bodies, t, frame, number)
                        if here >= clear and _is_near(rigid_bodies, t, frame, number):
                            near[i, j, k] = NEAR
                            vertex_counts[i] += 1
                            include(vertex_ranges[i], j, k)
