"""Exact parts of a lattice's boxes inside a closed surface of triangles.

The volume below the surface is summed triangle by triangle. A triangle's piece in a box adds the
prism between it and the box's floor, with the sign of its upward direction. It also adds the area
of its shadow to all boxes below it. Contributions above the body cancel between its upper and its
lower surface.
"""

import numpy as np

from pgimp.jit.kernel import allocating_kernel, kernel

#: Corners of a triangle after cuts by six planes, some of them doubled where they lie on one.
_CORNERS = 16
#: Sums of a box: volume, moments (x, y, z), area of the pieces' shadows, its moments (x, y).
SUMS = 7
#: Further sums, if products are asked for: of yz, xz, xy, xyz, and of xy over the shadows.
PRODUCTS = 5


@kernel
def _split(source, n, axis, at, below, above):
    """Split a convex polygon of n corners at a plane; the numbers of corners on both sides."""
    low, high = 0, 0
    for a in range(n):
        b = a + 1 if a + 1 < n else 0
        p, q = source[a, axis], source[b, axis]
        if p <= at:
            for d in range(3):
                below[low, d] = source[a, d]
            low += 1
        if p > at:
            for d in range(3):
                above[high, d] = source[a, d]
            high += 1
        if (p <= at) != (q <= at):
            # From the lower end, so that the triangle beyond an edge gets the same point.
            i, j = (a, b) if p < q else (b, a)
            part = (at - source[i, axis]) / (source[j, axis] - source[i, axis])
            for d in range(3):
                x = source[i, d] + part * (source[j, d] - source[i, d])
                if d == axis:
                    x = at
                below[low, d] = x
                above[high, d] = x
            low += 1
            high += 1
    return low, high


@kernel
def _add(polygon, n, corner, centre, sums):
    """Add a piece in a box with its low corner, and its centre relative to that."""
    (x0, y0, z0), (xc, yc, zc) = corner, centre
    ax, ay, az = polygon[0, 0] - x0, polygon[0, 1] - y0, polygon[0, 2] - z0
    for k in range(1, n - 1):
        bx, by, bz = polygon[k, 0] - x0, polygon[k, 1] - y0, polygon[k, 2] - z0
        cx, cy, cz = polygon[k + 1, 0] - x0, polygon[k + 1, 1] - y0, polygon[k + 1, 2] - z0
        area = 0.5 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
        x, y, z = ax + bx + cx, ay + by + cy, az + bz + cz
        xz = x * z + ax * az + bx * bz + cx * cz
        yz = y * z + ay * az + by * bz + cy * cz
        zz = z * z + az * az + bz * bz + cz * cz
        volume = area * z / 3.0
        sums[0] += volume
        sums[1] += area * xz / 12.0 - xc * volume
        sums[2] += area * yz / 12.0 - yc * volume
        sums[3] += area * zz / 24.0 - zc * volume
        sums[4] += area
        sums[5] += area * (x / 3.0 - xc)
        sums[6] += area * (y / 3.0 - yc)
        if len(sums) > SUMS:
            a, b, c = (ax - xc, ay - yc, az), (bx - xc, by - yc, bz), (cx - xc, cy - yc, cz)
            _add_products(a, b, c, area, zc, sums)


@kernel
def _add_products(a, b, c, area, zc, sums):
    """Add products of inertia of the prism below a triangle, given about the middle axis.

    Integrals of products of linear functions over a triangle are sums over its corners.
    """
    x, y, z = a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]
    xy = a[0] * a[1] + b[0] * b[1] + c[0] * c[1]
    xz = a[0] * a[2] + b[0] * b[2] + c[0] * c[2]
    yz = a[1] * a[2] + b[1] * b[2] + c[1] * c[2]
    zz = a[2] * a[2] + b[2] * b[2] + c[2] * c[2]
    xyz = a[0] * a[1] * a[2] + b[0] * b[1] * b[2] + c[0] * c[1] * c[2]
    xzz = a[0] * a[2] * a[2] + b[0] * b[2] * b[2] + c[0] * c[2] * c[2]
    yzz = a[1] * a[2] * a[2] + b[1] * b[2] * b[2] + c[1] * c[2] * c[2]
    xyzz = a[0] * a[1] * a[2] ** 2 + b[0] * b[1] * b[2] ** 2 + c[0] * c[1] * c[2] ** 2
    flat = area * (x * y + xy) / 12.0
    tall = area * (x * y * z + x * yz + y * xz + z * xy + 2.0 * xyz) / 60.0
    high = x * y * z * z + x * y * zz + 2.0 * z * (x * yz + y * xz) + z * z * xy
    high += xy * zz + 2.0 * xz * yz + 2.0 * (x * yzz + y * xzz + 2.0 * z * xyz) + 6.0 * xyzz
    of_y = area * (y * z * z + y * zz + 2.0 * z * yz + 2.0 * yzz) / 60.0
    of_x = area * (x * z * z + x * zz + 2.0 * z * xz + 2.0 * xzz) / 60.0
    sums[7] += 0.5 * of_y - zc * area * (y * z + yz) / 12.0
    sums[8] += 0.5 * of_x - zc * area * (x * z + xz) / 12.0
    sums[9] += tall
    sums[10] += area * high / 720.0 - zc * tall
    sums[11] += flat


@kernel
def _take(target, source, n):
    """Copy the n corners of a polygon."""
    for a in range(n):
        for d in range(3):
            target[a, d] = source[a, d]


@kernel
def _first(edges, x):
    """Number of the box that contains x, its low end included."""
    low, high = 0, len(edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if edges[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@allocating_kernel
def clip_plane(T, chosen, x0, x1, ey, ez, sums, touched):
    """Sum the parts of the body in the boxes of one plane of a lattice.

    Parameters
    ----------
    T : (n, 3, 3) float64
        All triangles.
    chosen : (m,) int64
        Triangles that may reach the plane.
    x0, x1 : float
        Both ends of the plane.
    ey, ez : (ny + 1,), (nz + 2,) float64
        Edges of its boxes; the last of `ez` is infinite, as triangles above cast shadows too.
    sums : (ny, nz + 1, SUMS or SUMS + PRODUCTS) float64
        Sums of each box, initially zero.
    touched : (ny, nz + 1) bool
        Boxes that contain a piece of the surface, initially False.
    """
    whole = np.empty((_CORNERS, 3))
    column = np.empty((_CORNERS, 3))
    box = np.empty((_CORNERS, 3))
    spare = np.empty((_CORNERS, 3))
    rest = np.empty((_CORNERS, 3))
    xc = 0.5 * (x1 - x0)
    ny = len(ey) - 1
    for t in chosen:
        n = 3
        for a in range(3):
            for d in range(3):
                spare[a, d] = T[t, a, d]
        least = min(T[t, 0, 0], min(T[t, 1, 0], T[t, 2, 0]))
        most = max(T[t, 0, 0], max(T[t, 1, 0], T[t, 2, 0]))
        # A triangle in an edge belongs to the box above it; its shadow is a line, so no matter.
        if least >= x1 or most < x0 or (most == x0 and least < x0):
            continue
        if least < x0:
            _, n = _split(spare, n, 0, x0, rest, whole)
            _take(spare, whole, n)
        if most > x1:
            n, _ = _split(spare, n, 0, x1, whole, rest)
        else:
            _take(whole, spare, n)
        if n < 3:
            continue
        near = 1e-15 * max(abs(T[t, 0, 2]), max(abs(T[t, 1, 2]), abs(T[t, 2, 2])))
        low, high = whole[0, 1], whole[0, 1]
        for a in range(1, n):
            low, high = min(low, whole[a, 1]), max(high, whole[a, 1])
        if low >= ey[ny] or high <= ey[0]:  # or flat there, with a line for a shadow
            continue
        if low < ey[0]:
            _, n = _split(whole, n, 1, ey[0], rest, spare)
            _take(whole, spare, n)
        j = _first(ey, low)
        while j < ny and n >= 3:
            if high > ey[j + 1]:
                m, n = _split(whole, n, 1, ey[j + 1], column, spare)
                _take(whole, spare, n)
            else:
                _take(column, whole, n)
                m, n = n, 0
            if m >= 3:
                place = (x0, ey[j]), (xc, 0.5 * (ey[j + 1] - ey[j]))
                _column(column, m, place, ez, near, (box, rest), sums[j], touched[j])
            j += 1


@kernel
def _column(column, m, place, ez, near, buffers, sums, touched):
    """Distribute a triangle's part in a column of boxes.

    `place` has their low corner, and their centre relative to it; `buffers` two further polygons.
    """
    (x0, y0), (xc, yc) = place
    box, rest = buffers
    nz = len(ez) - 1
    # Rounding must not carry a piece along a plane across it and back: its parts would overlap.
    for a in range(m):
        k = _first(ez, column[a, 2])
        for at in (ez[k], ez[k + 1]):
            if abs(column[a, 2] - at) <= near:
                column[a, 2] = at
    low, high = column[0, 2], column[0, 2]
    for a in range(1, m):
        low, high = min(low, column[a, 2]), max(high, column[a, 2])
    if high < ez[0]:
        return
    if low < ez[0]:
        _, m = _split(column, m, 2, ez[0], box, rest)
        _take(column, rest, m)
    k = _first(ez, low)
    while k < nz and m >= 3:
        if high > ez[k + 1]:
            n, m = _split(column, m, 2, ez[k + 1], box, rest)
            _take(column, rest, m)
        else:
            _take(box, column, m)
            n, m = m, 0
        if n >= 3:
            zc = 0.5 * (ez[k + 1] - ez[k]) if k + 1 < nz else 0.0
            _add(box, n, (x0, y0, ez[k]), (xc, yc, zc), sums[k])
            touched[k] = True
        k += 1


@kernel
def settle_plane(sums, touched, dx, ey, ez, slack, inside, parts):
    """Convert sums to each box's part: `inside` for whole boxes, `parts` for cut boxes.

    Parameters
    ----------
    sums, touched
        As `clip_plane` leaves them.
    dx : float
        Size of the boxes along x.
    slack : float
        Tolerance for rounding, as a part of a box.
    inside : (ny, nz) bool
        Boxes that lie inside and that no surface reaches.
    parts : (ny, nz, 4 or 8) float64
        Volume and moments of the other boxes, and products of inertia: yz, xz, xy, xyz.

    Returns
    -------
    int
        A faulty box as j nz + k, else -1. A box is faulty if its part is negative, exceeds the
        box, or exists without a surface.
    """
    ny, nz, more = parts.shape[0], parts.shape[1], parts.shape[2] - 4
    wrong = -1
    for j in range(ny):
        area = dx * (ey[j + 1] - ey[j])
        shadow, mx, my = sums[j, nz, 4], sums[j, nz, 5], sums[j, nz, 6]
        mxy = sums[j, nz, 11] if more > 0 else 0.0
        for k in range(nz - 1, -1, -1):
            tall = ez[k + 1] - ez[k]
            volume = sums[j, k, 0] + tall * shadow
            part = volume / (area * tall)
            if touched[j, k]:
                parts[j, k, 0] = volume
                parts[j, k, 1] = sums[j, k, 1] + tall * mx
                parts[j, k, 2] = sums[j, k, 2] + tall * my
                parts[j, k, 3] = sums[j, k, 3]
                for n in range(more):
                    parts[j, k, 4 + n] = sums[j, k, 7 + n] + (tall * mxy if n == 2 else 0.0)
                bad = part < -slack or part > 1.0 + slack
            else:
                inside[j, k] = part > 0.5
                bad = abs(part - (1.0 if inside[j, k] else 0.0)) > slack
            if bad and wrong < 0:
                wrong = j * nz + k
            shadow += sums[j, k, 4]
            mx += sums[j, k, 5]
            my += sums[j, k, 6]
            mxy += sums[j, k, 11] if more > 0 else 0.0
    return wrong
