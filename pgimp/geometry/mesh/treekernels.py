"""Queries of a closed surface of triangles: distance, intersections with lines, inside or out.

The triangles, (n, 3, 3) float64, are in the order of a tree of boxes. Node 1 is the root, the
children of node i are 2 i and 2 i + 1. The last `leaves` nodes have `LEAF` triangles each. Every
point is computed separately.

Intersections of lines and triangles are decided edge by edge, each from its lower end. So the two
triangles at an edge always agree: no line passes between them, or meets both.
"""

import numpy as np

from pgimp.jit.kernel import allocating_kernel, exact, kernel

LEAF = 4
_DEEP = 64

#: Triangles listed as near to a point, before the list grows.
LISTED = 64


@exact
def _beside(u0, v0, u1, v1, u, v):
    """Side of a point with respect to the line from (u0, v0) to (u1, v1): always the same bits."""
    return (u1 - u0) * (v - v0) - (v1 - v0) * (u - u0)


@kernel
def turns(T, t, i, j, u, v):
    """Winding number of a triangle round the point (u, v) in the plane of axes i, j: -1, 0 or 1."""
    total = 0
    for a in range(3):
        b = (a + 1) % 3
        up = T[t, a, j] <= v < T[t, b, j]
        down = T[t, b, j] <= v < T[t, a, j]
        if not (up or down):
            continue
        low, high = (a, b) if up else (b, a)
        side = _beside(T[t, low, i], T[t, low, j], T[t, high, i], T[t, high, j], u, v)
        if side > 0.0:
            total += 1 if up else -1
    return total


@kernel
def height(T, t, i, j, k, u, v):
    """Coordinate k at which the line through (u, v) meets the plane of a triangle, within it."""
    ax, ay, az = T[t, 0, i], T[t, 0, j], T[t, 0, k]
    bx, by, bz = T[t, 1, i] - ax, T[t, 1, j] - ay, T[t, 1, k] - az
    cx, cy, cz = T[t, 2, i] - ax, T[t, 2, j] - ay, T[t, 2, k] - az
    area = bx * cy - by * cx
    at = az
    if area != 0.0:
        s = ((u - ax) * cy - (v - ay) * cx) / area
        r = (bx * (v - ay) - by * (u - ax)) / area
        at = az + s * bz + r * cz
    least = min(az, min(T[t, 1, k], T[t, 2, k]))
    most = max(az, max(T[t, 1, k], T[t, 2, k]))
    return min(max(at, least), most)


@allocating_kernel
def count_above(T, low, high, leaves, component, own, point):
    """Signed number of surfaces above a point, without the component `own`."""
    x, y, z = point
    stack = np.empty(_DEEP, np.int64)
    stack[0], top, total = 1, 1, 0
    while top:
        top -= 1
        node = stack[top]
        if not (low[node, 0] <= x <= high[node, 0] and low[node, 1] <= y <= high[node, 1]):
            continue
        if not high[node, 2] >= z:
            continue
        if node < leaves:
            stack[top] = 2 * node
            stack[top + 1] = 2 * node + 1
            top += 2
            continue
        first = (node - leaves) * LEAF
        for t in range(first, min(first + LEAF, len(T))):
            if own < 0 or component[t] != own:
                turn = turns(T, t, 0, 1, x, y)
                if turn != 0 and height(T, t, 0, 1, 2, x, y) > z:
                    total += turn
    return total


@allocating_kernel
def inside(T, low, high, leaves, component, own, points, out):
    """Set `out`, (n,) int64, to the signed numbers of surfaces above the points, (n, 3)."""
    for p in range(len(points)):
        point = points[p, 0], points[p, 1], points[p, 2]
        out[p] = count_above(T, low, high, leaves, component, own[p], point)


@allocating_kernel
def lines(T, low, high, leaves, axis, points, heights, signs):
    """Intersections of lines along an axis with the surface, and their greatest number.

    For each line the first columns of `heights` and `signs`, (n, k), are set, as far as there is
    room. A sign of 1 means that the line, along the axis, leaves the body.
    """
    i, j = (axis + 1) % 3, (axis + 2) % 3
    stack = np.empty(_DEEP, np.int64)
    most = 0
    for p in range(len(points)):
        u, v = points[p, i], points[p, j]
        stack[0], top, n = 1, 1, 0
        while top:
            top -= 1
            node = stack[top]
            if not (low[node, i] <= u <= high[node, i] and low[node, j] <= v <= high[node, j]):
                continue
            if node < leaves:
                stack[top] = 2 * node
                stack[top + 1] = 2 * node + 1
                top += 2
                continue
            first = (node - leaves) * LEAF
            for t in range(first, min(first + LEAF, len(T))):
                turn = turns(T, t, i, j, u, v)
                if turn != 0:
                    if n < heights.shape[1]:
                        heights[p, n] = height(T, t, i, j, axis, u, v)
                        signs[p, n] = turn
                    n += 1
        most = max(most, n)
    return most


@kernel
def _to_box(low, high, node, x, y, z):
    dx = max(0.0, max(low[node, 0] - x, x - high[node, 0]))
    dy = max(0.0, max(low[node, 1] - y, y - high[node, 1]))
    dz = max(0.0, max(low[node, 2] - z, z - high[node, 2]))
    return dx * dx + dy * dy + dz * dz


@kernel
def _to_triangle(T, t, x, y, z):
    """Squared distance of a point to a triangle, which may be a line or a point."""
    ax, ay, az = T[t, 0, 0], T[t, 0, 1], T[t, 0, 2]
    bx, by, bz = T[t, 1, 0] - ax, T[t, 1, 1] - ay, T[t, 1, 2] - az
    cx, cy, cz = T[t, 2, 0] - ax, T[t, 2, 1] - ay, T[t, 2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    square = nx * nx + ny * ny + nz * nz
    if square > 0.0:
        s = nx * (py * cz - pz * cy) + ny * (pz * cx - px * cz) + nz * (px * cy - py * cx)
        r = nx * (by * pz - bz * py) + ny * (bz * px - bx * pz) + nz * (bx * py - by * px)
        if s >= 0.0 and r >= 0.0 and s + r <= square:
            away = px * nx + py * ny + pz * nz
            return away * away / square
    best = np.inf
    for a in range(3):
        b = (a + 1) % 3
        ex, ey, ez = T[t, b, 0] - T[t, a, 0], T[t, b, 1] - T[t, a, 1], T[t, b, 2] - T[t, a, 2]
        qx, qy, qz = x - T[t, a, 0], y - T[t, a, 1], z - T[t, a, 2]
        length = ex * ex + ey * ey + ez * ez
        along = 0.0
        if length > 0.0:
            along = min(1.0, max(0.0, (qx * ex + qy * ey + qz * ez) / length))
        qx, qy, qz = qx - along * ex, qy - along * ey, qz - along * ez
        best = min(best, qx * qx + qy * qy + qz * qz)
    return best


@allocating_kernel
def distances(tree, points, beside, begin, near_ones, out) -> int:
    """Distances to the nearest triangle, of points and of places beside each of them.

    A triangle that is nearest to a place is hardly farther from the point than the nearest one.
    So a point and its places take one search.

    Parameters
    ----------
    tree
        T, low, high, leaves.
    points : (n, 3) float64
    beside : (k, 3) float64
        The places, from the point.
    begin : int
        The first point to look at.
    near_ones : (int64, float64), each (m,)
        Space for the triangles that may be nearest to a place, and for their distances.
    out : (n, 1 + k) float64
        Set to the distances of the point and of its places.

    Returns
    -------
    int
        The first point that has not been done: the space is too small for it; n at the end.
    """
    (T, low, high, leaves), (listed, squares) = tree, near_ones
    stack, near = np.empty(_DEEP, np.int64), np.empty(_DEEP)
    places, far = len(beside), 0.0
    for k in range(places):
        far = max(far, beside[k, 0] ** 2 + beside[k, 1] ** 2 + beside[k, 2] ** 2)
    far = 2.0 * np.sqrt(far)
    last = 0
    for p in range(begin, len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        # Points come in lines, and the nearest triangle to the last one is not far.
        best = _to_triangle(T, last, x, y, z) if len(T) else np.inf
        limit, number = _beyond(best, far), 0
        stack[0], near[0], top = 1, _to_box(low, high, 1, x, y, z), 1
        while top:
            top -= 1
            node = stack[top]
            if near[top] > limit:
                continue
            if node < leaves:
                one, two = 2 * node, 2 * node + 1
                a, b = _to_box(low, high, one, x, y, z), _to_box(low, high, two, x, y, z)
                if a < b:  # the nearer one first
                    one, two, a, b = two, one, b, a
                if a <= limit:
                    stack[top], near[top] = one, a
                    top += 1
                if b <= limit:
                    stack[top], near[top] = two, b
                    top += 1
                continue
            first = (node - leaves) * LEAF
            for t in range(first, min(first + LEAF, len(T))):
                square = _to_triangle(T, t, x, y, z)
                if square < best:
                    best, last = square, t
                    limit = _beyond(best, far)
                if places and square <= limit:
                    if number == len(listed):
                        number = _shorten(listed, squares, number, limit)
                        if 2 * number > len(listed):
                            return p
                    listed[number], squares[number] = t, square
                    number += 1
        out[p, 0] = np.sqrt(best)
        number = _shorten(listed, squares, number, limit)
        for k in range(places):
            u, v, w = x + beside[k, 0], y + beside[k, 1], z + beside[k, 2]
            best = np.inf
            for n in range(number):
                best = min(best, _to_triangle(T, listed[n], u, v, w))
            out[p, 1 + k] = np.sqrt(best)
    return len(points)


@kernel
def _beyond(square, far):
    """Square of a distance that is longer by `far`, and by what rounding may hide."""
    return square if far == 0.0 else (np.sqrt(square) + far) ** 2 * (1.0 + 1e-12)


@kernel
def _shorten(listed, squares, number, limit):
    """Keep the listed triangles within a distance, squared; return their number."""
    kept = 0
    for n in range(number):
        if squares[n] <= limit:
            listed[kept], squares[kept] = listed[n], squares[n]
            kept += 1
    return kept


@allocating_kernel
def unite(pairs, turned, parent, parity):
    """Join triangles at common edges into components, of one orientation each.

    Parameters
    ----------
    pairs : (n, 2) int64
        Triangles that share an edge.
    turned : (n,) bool
        Whether both run along the edge in the same direction, so that one must be reversed.
    parent, parity : (triangles,) int64
        Set to the first triangle of each triangle's component, and to 1 if the triangle must be
        reversed to have its orientation.

    Returns
    -------
    int
        The first pair that cannot be oriented; -1 if all can.
    """
    root, flip = np.empty(2, np.int64), np.empty(2, np.int64)
    for k in range(len(pairs)):
        for s in range(2):
            t = pairs[k, s]
            p = 0
            while parent[t] != t:
                # Halve the path: skip a generation.
                up = parent[t]
                parity[t] ^= parity[up]
                parent[t] = parent[up]
                p ^= parity[t]
                t = parent[t]
            root[s], flip[s] = t, p
        differs = flip[0] ^ flip[1] ^ int(turned[k])
        if root[0] == root[1]:
            if differs:
                return k
            continue
        first, last = min(root[0], root[1]), max(root[0], root[1])
        parent[last], parity[last] = first, differs
    for t in range(len(parent)):
        if parent[t] != t:  # smaller numbers are settled already
            up = parent[t]
            parity[t] ^= parity[up]
            parent[t] = parent[up]
    return -1
