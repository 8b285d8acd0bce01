"""Bounds on the filled parts of vertices until the next selection, and the vertices that count.

Contact needs a least filled part of both bodies, see `pgimp.kernels.contact.gap`. Where one cannot
reach it within the slack, the sums of all particles there would be for nothing.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.fill import FLAT, halves, tangent
from pgimp.kernels.contact.gap import LEAST_FILLED, LEAST_HELD
from pgimp.kernels.contact.lagrangian.candidates import inside, reached_range
from pgimp.kernels.contact.lagrangian.vertices import number_of
from pgimp.kernels.grid.faces import on_walls
from pgimp.kernels.rigid.bodies import find_distance, position_of
from pgimp.kernels.rigid.tents import cut

#: How two groups, or a group and a rigid body, act on each other: not at all, only with filled
#: parts, or wherever they have a common vertex.
NEVER, WHERE_FILLED, ANYWHERE = 0, 1, 2

#: Distance from a rigid body, in cells, by which a bound is on the safe side: normals turn.
_SAFE = 0.03


@inner_kernel
def _greatest_weight(away, half, cut):
    """Greatest weight along a direction of a box whose middle is at least `away` from a vertex."""
    if cut != 0 or half > 0.5:
        return min(max(1.0 + half - away, 0.0), 1.0)
    if away > 1.0 - half:
        return max(1.0 + half - away, 0.0) ** 2 / (4.0 * half)
    return 1.0 - away if away > half else 1.0


@inner_kernel
def _weight(frame, row, motion, slack, number, d):
    """Greatest weight of a particle along `d` at a vertex until the next selection."""
    if d >= len(frame.cell):
        return 1.0
    x = (motion.position[d] - frame.origin[d]) * frame.inverse[d]
    away = abs(x - (number - frame.ghost))
    return _greatest_weight(max(away - slack, 0.0), row.half_width[d], row.cut)


@inner_kernel
def _greatest_growth(frame, motion, slack):
    """Greatest ratio by which a particle's volume may grow until the next selection.

    Gradients of weights add up to at most 2 over the cell, so F changes by dF, |dF_ij| <= 2 slack
    cell_i / cell_j. A determinant is at most the product of its rows' lengths (Hadamard), here of
    det(1 + dF F^-1): a particle that is compressed may grow by more.
    """
    growth, D = 1.0, len(frame.cell)
    for i in range(D):
        square = 0.0
        for k in range(D):
            most = 1.0 if k == i else 0.0
            for j in range(D):
                change = 2.0 * slack * frame.cell[i] * frame.inverse[j]
                most += change * abs(motion.inverse_F[j, k])
            square += most * most
        growth *= sqrt(square)
    return growth


@kernel
def bound_filled(frame, table, motion, slack, vertices, patches, most):
    """Find the greatest volume of each entry of patches until the next selection.

    Parameters
    ----------
    table, motion, slack, vertices
        See `find_reach`; the particles are boxes.
    most : (entries,) float64
        Set here.
    """
    entry, begin, extent = patches.entry, patches.begin, patches.extent
    most[:] = 0.0
    for i in range(len(table)):
        p = patches.patch[i]
        if not patches.some[p]:
            continue
        row, at = table[i], motion[i]
        x0, x1 = reached_range(frame, row, at, slack, vertices, 0)
        y0, y1 = reached_range(frame, row, at, slack, vertices, 1)
        z0, z1 = reached_range(frame, row, at, slack, vertices, 2)
        greatest = at.volume * _greatest_growth(frame, at, slack)
        for x in range(x0, x1 + 1):
            wx = greatest * _weight(frame, row, at, slack, x, 0)
            for y in range(y0, y1 + 1):
                wy = wx * _weight(frame, row, at, slack, y, 1)
                o = ((x - begin[p, 0]) * extent[p, 1] + y - begin[p, 1]) * extent[p, 2]
                for z in range(z0, z1 + 1):
                    e = entry[p, o + z - begin[p, 2]]
                    if e >= 0:
                        most[e] += wy * _weight(frame, row, at, slack, z, 2)


@inner_kernel
def _greatest_filled(rigid_bodies, t, frame, number, slack):
    """Greatest filled part of a vertex's whole neighbourhood by a body that moves by `slack`."""
    point, D, least, longest = rigid_bodies.point[0], len(frame.cell), inf, 0.0
    for d in range(D):
        least, longest = min(least, frame.cell[d]), max(longest, frame.cell[d])
    if longest > 1.5 * least:  # the lattice of distances may end within reach
        return 1.0
    x, y, z = position_of(frame, number)
    find_distance(rigid_bodies, t, D, x, y, z)
    away, wide = (slack + _SAFE) * least, tangent(frame, point)
    if point.distance < 0.0:
        return 1.0
    if abs(point.mean_distance - point.distance) < FLAT * wide:
        a, b, c = halves(rigid_bodies, frame, 1.0)
        return cut(a, b, c, away - min(point.mean_distance, point.distance))[0]
    filled, count = 0.0, 1
    for _ in range(D):
        count *= 3
    for corner in range(count):
        weight, code, px, py, pz = 1.0, corner, x, y, z
        for d in range(D):
            off = code % 3 - 1
            code //= 3
            weight *= 0.5 if off == 0 else 0.25
            move = 0.5 * off * frame.cell[d]
            px, py, pz = (
                px + move if d == 0 else px,
                py + move if d == 1 else py,
                pz + move if d == 2 else pz,
            )
        find_distance(rigid_bodies, t, D, px, py, pz)
        a, b, c = halves(rigid_bodies, frame, 0.5)
        filled += weight * (cut(a, b, c, away - point.distance)[0] if a > 0.0 else 1.0)
    return filled


@inlined
def _meet_rigid(rigid_bodies, frame, number, slack, acts, most, groups, walls):
    """Whether a group at a vertex may meet a rigid body."""
    if not is_record(rigid_bodies):
        return False
    for t in range(len(rigid_bodies.motion)):
        filled = -1.0
        for k in range(len(groups)):
            way = acts[groups[k], len(acts) + t]
            if way == ANYWHERE:
                return True
            if way == NEVER or most[k] < LEAST_HELD:
                continue
            if filled < 0.0:
                filled = _greatest_filled(rigid_bodies, t, frame, number, slack)
                filled *= 2.0**walls
            if filled >= LEAST_FILLED:
                return True
    return False


@kernel
def keep_possible(frame, obstacles, slack, acts, entries, contact_vertices, kept):
    """Mark the entries of vertices where there may be contact until the next selection.

    Parameters
    ----------
    obstacles : (Faces or (), (m, 2, 3) int64, RigidBodies or ())
        All walls at rest; boxes and rigid bodies as in `find_candidates`.
    slack : float
        Cells by which rigid bodies may move.
    acts : (groups, groups + rigid bodies) int8
        How groups act on each other and on rigid bodies: `NEVER`, `WHERE_FILLED`, `ANYWHERE`.
    entries : ((m,) float64, (m,) int64)
        Greatest volume of each entry, changed to the filled part, and its group.
    contact_vertices : ContactVertices
        With the entries' keys, ascending.
    kept : (m,) bool
        Set here.
    """
    keys, first, whole = contact_vertices.keys, 0, 1.0
    (faces, boxes, rigid_bodies), (most, groups) = obstacles, entries
    for d in range(len(frame.cell)):
        whole *= frame.cell[d]
    while first < len(keys):
        vertex, last = keys[first] // contact_vertices.groups, first
        number = number_of(contact_vertices, vertex)
        walls = on_walls(faces, frame, number)
        while last < len(keys) and keys[last] // contact_vertices.groups == vertex:
            most[last] /= whole * 0.5**walls
            last += 1
        possible = inside(boxes, number) or _meet_rigid(
            rigid_bodies, frame, number, slack, acts, most[first:last], groups[first:last], walls
        )
        for a in range(first, last):
            for b in range(a + 1, last):
                way = acts[groups[a], groups[b]]
                if way == ANYWHERE:
                    possible = True
                if way == WHERE_FILLED and min(most[a], most[b]) >= LEAST_FILLED:
                    possible = True
        for a in range(first, last):
            kept[a] = possible
        first = last
