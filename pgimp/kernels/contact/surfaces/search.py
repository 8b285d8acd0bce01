"""Search for facets near each other: neighbours on a body, and the facets of other bodies."""

from math import inf, sqrt

from numpy import uint64  # of offsets: numbers below 0 would be looked for

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.surfaces.data import turns
from pgimp.kernels.contact.surfaces.nearest import (
    ACROSS,
    ALIKE,
    FLAT,
    PLANE,
    SIDE,
    STEEP,
    TIP,
    apart,
    reluctance,
)
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.once.neighbours import first_not_below

#: How far neighbours in a plane may be off: cosines of normals, and radii behind it.
_IN_PLANE = 1e-6

#: Difference of a normal's components beyond which one is greater: at 45 degrees all facets of a
#: face are on one side, and a pair remains the same from step to step.
_ROUNDING = 1e-6


@kernel
def find_beside(x, body, key_of, bins, strides, radius, start, beside):
    """Find the neighbours of facets on their body; returns their number.

    Parameters
    ----------
    x, body : (n, 3) float64, (n,) int64
        Centroids and bodies.
    key_of : (n,) int64
        Keys of the bins, with sides `radius`, that they are in.
    bins : ((n,) int64, (n,) int64)
        These keys, ascending, and the facets in that order.
    strides : (3,) int64
        Differences of keys between neighbours by direction; 0 along a missing one of the first two.
    radius : float
        Greatest distance of neighbours.
    start, beside : (n + 1,) and (k,) int64
        See `Surface`; filled as far as there is room.
    """
    found, (keys, order) = 0, bins
    start[0] = 0
    for n in range(len(x)):
        for way in range(9):
            i, j = way // 3 - 1, way % 3 - 1
            if (i != 0 and strides[0] == 0) or (j != 0 and strides[1] == 0):
                continue
            key = key_of[n] + i * strides[0] + j * strides[1]
            at = first_not_below(keys, key - 1)
            while at < len(keys) and keys[at] <= key + 1:
                m, square = order[at], 0.0
                at += 1
                if m == n or body[m] != body[n]:
                    continue
                for d in range(3):
                    square += (x[m, d] - x[n, d]) ** 2
                if square <= radius * radius:
                    if found < len(beside):
                        beside[found] = m
                    found += 1
        start[n + 1] = found
    return found


@inner_kernel
def _side_of(normal):
    """Number of the side of a facet, by its normal in the initial state."""
    axis = 0
    for d in range(1, 3):
        if abs(normal[d]) > abs(normal[axis]) + _ROUNDING:
            axis = d
    return 2 * axis + (1 if normal[axis] > 0.0 else 0)


@kernel
def find_tips(surface, sharp, near, inside, towards):
    """Mark the facets beside a sharp edge: a neighbour's normal is nearly the opposite one.

    Those in a plane with all of their neighbours, none of them across a seam, are `FLAT`; those
    with none that are alike but not in it are of a `PLANE`. Marks have sides, too. `sharp` is the
    greatest cosine between normals at an edge. Sets in `inside`, (n,) bool, whether facets are in a
    plane with all neighbours within a length `near`. If that has one convex edge, `towards`, (n, 3)
    float64, is the unit vector across it, in the plane; else 0.
    """
    for f in range(len(surface.x)):
        tip, inside[f], edges, way = FLAT | PLANE, True, 0, towards[f]
        for k in range(surface.start[f], surface.start[f + 1]):
            m, alike, behind, square, across = surface.beside[k], 0.0, 0.0, 0.0, False
            for d in range(3):
                off_by = surface.x[m, d] - surface.x[f, d]
                image = turns(surface, off_by, d)
                square += (off_by - image) * (off_by - image)
                across = across or image != 0.0
                alike += surface.normal[f, d] * surface.normal[m, d]
                behind += (off_by - image) * surface.normal[f, d]
            off = abs(behind) > _IN_PLANE * surface.radius[f] or not alike > 1.0 - _IN_PLANE
            if across or (off and square < near * near):
                inside[f] = False
                convex = behind < 0.0 and not across
                edges = _add_edge(surface, f, m, alike, edges, way) if convex else edges + 2
            if across or off:
                tip &= ~FLAT
            if across or (off and alike > ALIKE):
                tip &= ~PLANE
            if alike < sharp and behind < 0.0:
                tip |= TIP
        surface.tip[f] = tip | _side_of(surface.normal[f]) << SIDE
        if edges != 1 or not tip & PLANE:
            way[0] = way[1] = way[2] = 0.0


@inner_kernel
def _add_edge(surface, f, m, alike, edges, way):
    """Number of edges with that between two faces; sets the vector towards the first one."""
    part, same = sqrt(max(1.0 - alike * alike, _IN_PLANE)), 0.0
    for d in range(3):
        own = (surface.normal[m, d] - alike * surface.normal[f, d]) / part
        way[d] = own if edges == 0 else way[d]
        same += own * way[d]
    return edges if edges > 0 and same > 1.0 - _IN_PLANE else edges + 1


@kernel
def bound_clusters(frame, numbers, records, motion, clusters, ends):
    """Set the least coordinates of clusters, and the least of the reversed ones, of own vertices.

    Parameters
    ----------
    numbers : (v, 4) int64
        Numbers of the surface vertices along x, y, z, and their fields.
    records : (v,) int64
        Numbers of their records; -1 of other ranks' ones.
    motion : VertexMotion
        With their displacements.
    clusters : ((k,) int64, (k,) int64)
        Clusters, and the vertices of their cells.
    ends : (2, clusters, D) float64
        inf before.
    """
    owner, corner = clusters
    for k in range(len(owner)):
        v, c = corner[k], owner[k]
        r = records[v]
        if r < 0:
            continue
        for d in range(len(frame.cell)):
            x = frame.origin[d] + (numbers[v, d] - frame.ghost) * frame.cell[d]
            x += motion.values[r * RECORD + DISPLACEMENT + d]
            ends[0, c, d] = min(ends[0, c, d], x)
            ends[1, c, d] = min(ends[1, c, d], -x)


@kernel
def greatest_way(frame, records, motion, dt):
    """Most cells along a direction that vertices move in a time, by their velocities.

    `records` and `motion` are as of `bound_clusters`, `dt` is the time.
    """
    most = 0.0
    for v in range(len(records)):
        r = records[v] * RECORD
        for d in range(len(frame.cell) if r >= 0 else 0):
            most = max(most, abs(motion.values[r + KEPT_VELOCITY + d]) * (dt * frame.inverse[d]))
    return most


@kernel
def find_close(order, low, high, reach, body, acts, pairs):
    """Find the pairs of boxes within reach of each other, of bodies of which one acts on the other.

    Parameters
    ----------
    order : (n,) int64
        The boxes by their low ends along the first direction.
    low, high, reach : (n, D), (n, D), (D,) float64
        Their corners; distances by direction.
    body, acts : (n,) int64, (bodies, bodies) uint8
        Their bodies, and which of these act on each other.
    pairs : (k, 2) int64
        Filled as far as there is room.

    Returns
    -------
    int
        How many there are.
    """
    found = 0
    for n in range(len(order)):
        a, m = order[n], n + 1
        while m < len(order) and low[order[m], 0] <= high[a, 0] + reach[0]:
            b, close = order[m], True
            m += 1
            if acts[body[a], body[b]] == 0 and acts[body[b], body[a]] == 0:
                continue
            for d in range(1, low.shape[1]):
                close = close and low[a, d] <= high[b, d] + reach[d]
                close = close and low[b, d] <= high[a, d] + reach[d]
            if close:
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = min(a, b), max(a, b)
                found += 1
    return found


@kernel
def mark_between(surface, clusters, meeting, reach, marks):
    """Mark the facets of clusters that are within reach of the box of one that they meet.

    Parameters
    ----------
    clusters : ((m + 1,) int64, (n,) int64)
        First entry of each cluster, and the facets of each.
    meeting : ((k, 2) int64, (m, D) float64, (m, D) float64)
        Pairs of clusters; least and greatest coordinates of all.
    marks : (facets,) uint8
        Set to 1.
    """
    (first, members), (pairs, low, high) = clusters, meeting
    for k in range(len(pairs)):
        for side in range(2):
            own, other = pairs[k, side], pairs[k, 1 - side]
            for n in range(first[own], first[own + 1]):
                f, inside = members[n], True
                for d in range(low.shape[1]):
                    x = surface.now[f, d]
                    inside = inside and low[other, d] - reach <= x <= high[other, d] + reach
                if inside:
                    marks[f] = 1


@inner_kernel
def _looks(surface, acts, cell, s, f):
    """Whether facet `s` looks for facet `f`: of another body, or far from it on its own.

    Of two bodies the second one's facets do so at its tips, which the first one's may not see.
    """
    a, b = surface.body[s], surface.body[f]
    if acts[a, b] == 0 and (acts[b, a] == 0 or not surface.tip[s] & TIP):
        return False
    return a != b or apart(surface, s, f, cell)


@inner_kernel
def _find_ranges(keys, key_of, strides, ranges):
    """Set the ranges of ascending keys in a bin and those beside it; returns how many."""
    found = 0
    for way in range(9):
        i, j = way // 3 - 1, way % 3 - 1
        if (i != 0 and strides[0] == 0) or (j != 0 and strides[1] == 0):
            continue
        key = key_of + i * strides[0] + j * strides[1]
        ranges[found, 0] = ranges[found, 1] = first_not_below(keys, key - 1)
        while ranges[found, 1] < len(keys) and keys[ranges[found, 1]] <= key + 1:
            ranges[found, 1] += 1
        found += 1
    return found


@inner_kernel
def _find_runs(acts, runs, k, some, reach):
    """Find the runs of facets that run `k` in the order of bins may meet; returns how many.

    `some` is the number of ranges that they are in.
    """
    _, body, boxes, (_, order, _, ranges), close = runs
    found, own, count = 0, body[order[k]], 0
    x, y, z = boxes[k, 0] - reach, boxes[k, 1] - reach, boxes[k, 2] - reach
    u, v, w = boxes[k, 3] + reach, boxes[k, 4] + reach, boxes[k, 5] + reach
    for way in range(some):
        for at in range(ranges[way, 0], ranges[way, 1]):
            n = uint64(at)
            inside = (boxes[n, 0] <= u) & (boxes[n, 3] >= x) & (boxes[n, 1] <= v)
            inside &= (boxes[n, 4] >= y) & (boxes[n, 2] <= w) & (boxes[n, 5] >= z)
            close[uint64(found)] = order[n]  # without a branch, which nothing would foretell
            found += 1 if inside else 0
    for m in range(found):
        q = close[m]
        close[count] = q
        count += 1 if acts[own, body[q]] != 0 or acts[body[q], own] != 0 else 0
    return count


@kernel
def find_meeting(surface, acts, some, runs, reach, marks, best, every):
    """Find the facets that may soon meet another body, and the nearest facet there.

    Parameters
    ----------
    surface : Surface
        The facets, moved.
    acts : (bodies, bodies) uint8
        Whether facets of the first body look for those of the second.
    some : (n,) int64
        The facets to look at, by patch.
    runs : tuple
        Runs of them that are near each other, see
        `pgimp.solver.contact.surfaces.candidates.runs_of`.
    reach : (float, float, float, int, int)
        Greatest distance, and the side of a cell; by how much more than `TURNS` cosines between
        normals may change until the next search; the first and the end of the runs that look for
        others.
    marks : (facets,) uint8
        Set to 1 for these facets within reach of others, and those there.
    best : ((bodies,) float64, (bodies,) int64, (bodies,) int64)
        Scratch; the first is inf before and after.
    every : (room, 3) int64
        Filled as far as there is room: facets, bodies, the nearest facet there.

    Returns
    -------
    int
        How many there are.
    """
    found, start, close, (least, nearest, met) = 0, runs[0], runs[4], best
    (keys, order, strides, ranges), ways, last = runs[3], 0, -1
    for r in range(reach[3], reach[4]):
        if keys[r] != last:
            ways, last = _find_ranges(keys, keys[r], strides, ranges), keys[r]
        p, count = order[r], _find_runs(acts, runs, r, ways, reach[0])
        for n in range(start[p], start[p + 1] if count > 0 else start[p]):
            s, bodies = some[n], 0
            for m in range(count):
                for k in range(start[close[m]], start[close[m] + 1]):
                    square, same, f = 0.0, 0.0, some[k]
                    for d in range(3):
                        square += (surface.now[s, d] - surface.now[f, d]) ** 2
                    if square > reach[0] * reach[0] or not _looks(surface, acts, reach[1], s, f):
                        continue
                    for d in range(3):
                        same += surface.turned[s, d] * surface.turned[f, d]
                    marks[f] = marks[s] = 1
                    square, b = square + reluctance(same, reach[1]), surface.body[f]
                    if same < STEEP - reach[2] and acts[surface.body[s], b] == 0:
                        continue
                    if not square < inf or (same > ACROSS + reach[2] and surface.tip[f] & PLANE):
                        continue
                    if least[b] == inf:
                        met[bodies] = b
                        bodies += 1
                    if square < least[b] or (square == least[b] and f < nearest[b]):
                        least[b], nearest[b] = square, f
            for m in range(bodies):
                b = met[m]
                if found < len(every):
                    every[found, 0], every[found, 1], every[found, 2] = s, b, nearest[b]
                found += 1
                least[b] = inf
    return found


@kernel
def keys_of_vertices(bits, numbers, keys):
    """Set the keys of vertices, given numbers along x, y, z and field, (n, 4) int64.

    `bits` are of a key, see `pgimp.kernels.contact.impulses.reference_grid.key_bits`.
    """
    for n in range(len(keys)):
        key = (numbers[n, 0] << bits[0]) + numbers[n, 1]
        keys[n] = (((key << bits[1]) + numbers[n, 2]) << bits[2]) + numbers[n, 3]
