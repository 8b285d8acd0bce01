"""Gaps between facets of one body and the surface of another, in the current configuration.

The facet of the other body next to a point is the nearest in an array of flat discs. The point's
place Y in the other body solves x_B(Y) = x, in the cell of that facet. With the signed distance phi
of Y from the facet in the undeformed body, the gap is phi/|F^-T N|, and the normal is along F^-T N.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.surfaces.data import turns
from pgimp.kernels.contact.surfaces.motion import deform, set_polynomial, turned_normal
from pgimp.kernels.contact.surfaces.spread import mean_position, spread_weights

#: Greatest cosine between normals of facets that meet; above `OPPOSED` they meet less readily than
#: others: at an edge a face meets the other face that it lies on, not the one beside it. Weight of
#: the square of what is above, over that of a distance of a cell.
MEETS, OPPOSED, ASKEW = 0.3, -0.5, 4.0

#: Cells by which facets of one body are apart in the initial state if they may meet.
APART = 2.0

#: Greatest cosine between normals of facets with a gap: others are beside an edge.
FACES = -0.03

#: Cosine below which facets that others look for leave it to these, and least one of facets of one
#: face.
STEEP, _ALIKE = -0.8, 0.9

#: Weight of the distance along a facet, so that one of several in a plane is next to a point.
_ALONG = 1e-6

#: Beside a disc by more than its radius times the root of 2: least part of the square that is from
#: the rim on.
_BEYOND = 0.0857

#: Cells by which a point may lie beside a facet's part of a box, and the same over its distance, of
#: points before the facet and behind it: what is deep beside an edge is not in the body.
_BESIDE, _BESIDE_BEFORE, _BESIDE_BEHIND = 1e-3, 0.5, 0.15

#: Depth in cells beyond which a point is not in a surface, but in what is behind, and cells within
#: which facets are next to each other.
DEEPEST, FARTHEST = 0.25, 0.5

#: Cells of gap below which a facet is all its area, and not its centroid alone.
_SPREADS = 0.05

#: Depth in cells beyond which a point has to be behind the facets round an edge as well.
_EDGE = 0.01

#: Facets of a face that are tried, at most, each beside the one before, for that below a point.
_ATTEMPTS = 8

#: Iterations for the place in a cell, at most, and the change in cells that ends them: the next one
#: is its square.
_NEWTON, _EXACT = 12, 1e-7


@inner_kernel
def reluctance(same, cell):
    """Square of a length by which facets are farther from each other, by the cosine of normals."""
    return inf if same > MEETS else ASKEW * (max(0.0, same - OPPOSED) * cell) ** 2


@inner_kernel
def apart(surface, s, f, cell):
    """Whether two facets of one body are so far apart in the initial state that they may meet.

    Of both patches the one with the smaller number looks for the other.
    """
    square = 0.0
    for d in range(3):
        way = surface.x[s, d] - surface.x[f, d]
        square += (way - turns(surface, way, d)) ** 2
    return surface.patch[s] < surface.patch[f] and square > (APART * cell) ** 2


@inner_kernel
def _square(D, surface, s, cell, f, most):
    """Square of the distance of facet `s` from facet `f`, with the `reluctance` of both.

    It is inf where it is seen to be above `most` before roots are taken.
    """
    x, facing = surface.now[s], surface.turned[s]
    if surface.body[s] == surface.body[f] and not apart(surface, s, f, cell):
        return inf
    along, whole, same = 0.0, 0.0, 0.0
    for d in range(3):
        way, n = x[d] - surface.now[f, d], surface.turned[f, d]
        way -= turns(surface, way, d)
        along += way * n
        whole += way * way
        same += facing[d] * n
    beside = max(whole - along * along, 0.0)
    square, over = along * along + _ALONG * beside, 0.0
    reach = surface.radius[f] * surface.radius[f]
    if D > 1 and beside > reach:
        if square > most or (beside > 2.0 * reach and square + _BEYOND * beside > most):
            return inf
        over = sqrt(beside) - sqrt(reach)
    return square + over * over + reluctance(same, cell)


@inner_kernel
def next_facet(D, surface, s, cell, f):
    """Facet next to facet `s`, from facet `f` on along neighbours."""
    least = _square(D, surface, s, cell, f, inf)
    while True:
        best = f
        for k in range(surface.start[f], surface.start[f + 1]):
            other = surface.beside[k]
            square = _square(D, surface, s, cell, other, least)
            if square < least or (square == least and other < best):
                least, best = square, other
        if best == f:
            return f
        f = best


@inner_kernel
def _solve_place(frame, low, x, scratch, place):
    """Set the place in a cell, or beyond, that is at a current position; starts from `place`.

    `low` is the cell's first vertex, with the displacement in `scratch`. Returns whether it is
    found.
    """
    D, (F, P, y, _), most = len(frame.cell), scratch, inf
    for _ in range(_NEWTON):
        for d in range(3):
            y[d] = low[d]
        for d in range(D):
            y[d] += place[d] * frame.cell[d]
        deform(frame, P, place, y, F)
        r = (x[0] - y[0], x[1] - y[1], x[2] - y[2])
        J = 0.0
        for j in range(3):
            J += F[0, j] * _cofactor(F, 0, j)
        most = 0.0
        for j in range(D):  # inverse of F, the transposed cofactors over J
            s = 0.0
            for i in range(3):
                s += _cofactor(F, i, j) * r[i]
            s *= frame.inverse[j] / J
            place[j] += s
            most = max(most, abs(s))
        if not most > _EXACT:
            break
    return most <= _EXACT


@inner_kernel
def _cofactor(F, i, j):
    """Cofactor of an entry of F."""
    a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
    return F[a, c] * F[b, d] - F[a, d] * F[b, c]


@inlined
def _rigid_place(rigid_bodies, surface, x, near):
    """Set place and normal of a point at a rigid body: the place is in its initial coordinates."""
    if not is_record(rigid_bodies):
        return 1.0
    row = rigid_bodies.motion[near.body - rigid_bodies.bodies]
    for d in range(3):
        own = row.reference[d]
        for k in range(3):
            own += row.rotation[k, d] * (x[k] - row.centre[k])
        near.place[d], near.normal[d] = own, surface.turned[near.other, d]
    return 1.0


@inner_kernel
def _near(surface, s, f, d):
    """Coordinate of facet `s`, or of its image nearest to facet `f`."""
    x = surface.now[s, d]
    return x - turns(surface, x - surface.now[f, d], d)


@inner_kernel
def _find_gap(frame, rigid_bodies, surface, moved, scratch, near):
    """Set gap, place and normal of a facet's centroid at another body's surface."""
    D, s, f, F, (cells, u) = len(frame.cell), near.facet, near.other, scratch[0], moved
    x = (_near(surface, s, f, 0), _near(surface, s, f, 1), _near(surface, s, f, 2))
    least, phi, length, beside = frame.cell[0], 0.0, 1.0, inf
    for d in range(D):
        least = min(least, frame.cell[d])
    for attempt in range(_ATTEMPTS):
        f, c, close = near.other, surface.cell[near.other], True
        length, phi = 1.0, 0.0
        if c < 0:
            _rigid_place(rigid_bodies, surface, x, near)
        else:
            if attempt > 0:
                set_polynomial(D, cells, c, u, scratch[1])
            for d in range(3):
                near.place[d] = surface.place[f, d]
            close = _solve_place(frame, cells.low[c], x, scratch, near.place)
            n, J = turned_normal(F, surface.normal[f]), 0.0
            for j in range(3):
                J += F[0, j] * _cofactor(F, 0, j)
            length = sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
            for d in range(3):
                near.normal[d] = n[d] / length
            length /= J
        for d in range(D):
            phi += (_own(frame, cells, c, near, d) - surface.x[f, d]) * surface.normal[f, d]
        near.gap = phi / length
        most = _BESIDE * least + max(_BESIDE_BEFORE * phi, -_BESIDE_BEHIND * phi)
        beside = _beyond(D, frame, cells, surface, c, near, f) - most
        if not (close and beside > 0.0 and abs(near.gap) < FARTHEST * least):
            break
        # Facets are no discs: the one that it is over may be beside the nearest one.
        least_beside = beside + most
        for k in range(surface.start[f], surface.start[f + 1]):
            m, alike = surface.beside[k], 0.0
            for d in range(D):
                alike += surface.normal[m, d] * surface.normal[f, d]
            if alike > _ALIKE:
                away = _beyond(D, frame, cells, surface, c, near, m)
                if away < least_beside:
                    least_beside, near.other = away, m
        if near.other == f:
            break
    f, c = near.other, surface.cell[near.other]
    if not (close and beside <= 0.0 and -DEEPEST * least <= near.gap < inf):
        near.gap = inf
    elif near.gap < -_EDGE * least and _before_another(D, frame, cells, surface, c, near):
        near.gap = inf
    for d in range(3):
        near.offset[d] = near.edges[0, d] = near.edges[1, d] = 0.0
    if c >= 0 and near.gap < _SPREADS * least:
        _spread(frame, surface, (cells, c, u), x, scratch, near)
        for d in range(D):
            near.gap += near.offset[d] * frame.cell[d] * surface.normal[f, d] / length


@inner_kernel
def _beyond(D, frame, cells, surface, c, near, f):
    """Greatest length by which a place is beside the part of a box that facet `f` is in."""
    phi, beside = 0.0, -inf
    for d in range(D):
        phi += (_own(frame, cells, c, near, d) - surface.x[f, d]) * surface.normal[f, d]
    for d in range(D):
        y = _own(frame, cells, c, near, d) - phi * surface.normal[f, d]
        beside = max(beside, abs(y - surface.middle[f, d]) - surface.half[f, d])
    return beside


@inner_kernel
def _spread(frame, surface, there, x, scratch, near):
    """Set edges and offset of a facet in the other body.

    Of its pieces there the mean position is that of its place to first order. The offset leads from
    there to the facet's own mean position `x`, so that angular momentum is kept.
    """
    D, (F, P, y, pieces), (cells, c, u) = len(frame.cell), scratch, there
    deform(frame, P, near.place, y, F)
    J = 0.0
    for j in range(3):
        J += F[0, j] * _cofactor(F, 0, j)
    for d in range(D):
        for i in range(3):
            part = _cofactor(F, i, d) * frame.inverse[d] / J
            near.edges[0, d] += part * surface.extent[near.facet, 0, i]
            near.edges[1, d] += part * surface.extent[near.facet, 1, i]
    count = spread_weights(D, cells, c, near, pieces)
    mean_position(frame, cells, u, pieces, count, y)
    for d in range(D):
        for i in range(3):
            near.offset[d] += _cofactor(F, i, d) * frame.inverse[d] / J * (x[i] - y[i])


@inner_kernel
def _before_another(D, frame, cells, surface, c, near):
    """Whether a place behind a facet is before another one beside it, round a convex edge."""
    f = near.other
    for k in range(surface.start[f], surface.start[f + 1]):
        m = surface.beside[k]
        alike, away, convex = 0.0, 0.0, 0.0
        for d in range(D):
            n = surface.normal[m, d]
            alike += n * surface.normal[f, d]
            way = surface.x[f, d] - surface.x[m, d]
            image = turns(surface, way, d)
            away += (_own(frame, cells, c, near, d) - surface.x[m, d] - image) * n
            convex += (way - image) * n
        if alike < 0.5 and convex < 0.0 and away > 0.0:
            return True
    return False


@inner_kernel
def _own(frame, cells, c, near, d):
    """Initial coordinate of a place in a cell, or at a rigid body."""
    return near.place[d] if c < 0 else cells.low[c, d] + near.place[d] * frame.cell[d]


@kernel
def find_gaps(frame, rigid_bodies, walls, surface, moved, scratch, far, every):
    """Find the gaps between facets and the other bodies next to them.

    Parameters
    ----------
    rigid_bodies : RigidBodies or ()
        The rigid bodies at their positions.
    walls : SeparatingWalls
        The unilateral walls.
    moved : (SurfaceCells, (vertices, 3) float64)
        The cells, and the displacements of the surface vertices.
    scratch
        As of `move_facets`.
    far : (float, bool)
        Greatest distance: farther away the cell's displacements, extrapolated, may fold. Whether
        the facets next to others may have changed since they were found.
    every : (n,) NEAR_FACET
        The facets; `other` is where the search for the one next to them begins.
    """
    D, last, (cells, u), (farthest, walks) = len(frame.cell), -1, moved, far
    for n in range(len(every)):
        near = every[n]
        s = near.facet
        wall = near.body - walls.first
        if wall >= 0:
            axis, side = walls.planes[wall].axis, walls.planes[wall].side
            at = frame.origin[axis] + (walls.planes[wall].vertex - frame.ghost) * frame.cell[axis]
            near.gap = (at - surface.now[s, axis]) * side
            for d in range(3):
                near.normal[d] = -1.0 * side if d == axis else 0.0
        else:
            if walks:
                near.other = next_facet(D, surface, s, frame.cell[0], near.other)
            same = 0.0
            for d in range(3):
                same += surface.turned[s, d] * surface.turned[near.other, d]
            most = farthest * farthest + reluctance(same, frame.cell[0])
            if _square(D, surface, s, frame.cell[0], near.other, inf) > most:
                near.gap = inf
                continue
            c = surface.cell[near.other]
            if c >= 0 and c != last:
                set_polynomial(D, cells, c, u, scratch[1])
                last = c
            own = near.other
            _find_gap(frame, rigid_bodies, surface, moved, scratch, near)
            last = last if near.other == own else -1
        same = 0.0
        for d in range(3):
            same += surface.turned[s, d] * near.normal[d]
        if same > FACES:
            near.gap = inf
