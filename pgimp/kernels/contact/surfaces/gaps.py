"""Gaps between facets of one body and the surface of another, in the current configuration.

The facet of the other body next to a point is the nearest in an array of flat discs. The point's
place Y in the other body solves x_B(Y) = x, in the cell of that facet. With the signed distance phi
of Y from the facet in the undeformed body, the gap is phi/|F^-T N|, and the normal is along F^-T N.

Where no facet of a patch can be near enough for a pair, none has a gap.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.simd import lane
from pgimp.kernels.contact.surfaces.data import CLEAR, turns
from pgimp.kernels.contact.surfaces.motion import cofactors, gradient, set_polynomial, turned_normal
from pgimp.kernels.contact.surfaces.nearest import (
    ALIKE,
    BESIDE_BEFORE,
    BESIDE_BEHIND,
    FACES,
    STEEP,
    WIDE,
    approach,
    pairs_with,
    until_facing,
)
from pgimp.kernels.contact.surfaces.patches.levels import law_of
from pgimp.kernels.contact.surfaces.patches.pressed import facing_part
from pgimp.kernels.contact.surfaces.spread import (
    add_offset,
    find_pieces,
    keep_pieces,
    mean_displacement,
)

#: Cells by which a point may lie beside a facet's part of a box; further by its distance before the
#: facet or behind it. What is deep beside an edge is not in the body.
_BESIDE = 1e-3

#: Depth in cells beyond which a point is not in a surface, but in what is behind, and cells within
#: which facets are next to each other.
DEEPEST, FARTHEST = 0.25, 0.5

#: Cells of gap below which a facet is all its area, and not its centroid alone.
_SPREADS = 0.05

#: Depth in cells beyond which a point has to be behind the facets round an edge as well.
_EDGE = 0.01

#: Tilt of wide facets beyond which these are to be parted.
_TILTED = 0.015

#: Facets of a face that are tried, at most, each beside the one before, for that below a point.
_ATTEMPTS = 8

#: Iterations for the place in a cell, at most, and the change in cells that ends them: the next one
#: is its square, times the change of the strain over a cell.
_NEWTON, _EXACT = 12, 3e-6


@inner_kernel
def _from(frame, x, low, place):
    """Vector to a point from a place in a cell that begins at `low`, in the initial state."""
    D = len(frame.cell)
    return (
        x[0] - low[0] - place[0] * frame.cell[0],
        x[1] - low[1] - (place[1] * frame.cell[1] if D > 1 else 0.0),
        x[2] - low[2] - (place[2] * frame.cell[2] if D > 2 else 0.0),
    )


@inner_kernel
def _solve_place(frame, low, x, P, place):
    """Set the place in a cell, or beyond, that is at a current position; starts from `place`.

    `low` is the cell's first vertex, with the displacement in `P`. Returns whether it is found, and
    the cofactors and the determinant of F at the place before the last.
    """
    D, turn = len(frame.cell), 0
    while True:
        F, way = gradient(frame, P, place)
        K, J = cofactors(F)
        r = _from(frame, (x[0] - way[0], x[1] - way[1], x[2] - way[2]), low, place)
        most, turn = 0.0, turn + 1
        for d in range(D):
            k = K[d]
            s = (k[0] * r[0] + k[1] * r[1] + k[2] * r[2]) * (frame.inverse[d] / J)
            place[d] += s
            most = max(most, abs(s))
        if not (most > _EXACT and turn < _NEWTON):
            return most <= _EXACT, K, J


@inlined
def _rigid_place(rigid_bodies, surface, x, near):
    """Set place and normal of a point at a rigid body: the place is in its initial coordinates."""
    if not is_record(rigid_bodies):
        return 1.0
    row = rigid_bodies.motion[near.body - rigid_bodies.bodies]
    for d in range(3):
        own, n = row.reference[d], 0.0
        for k in range(3):
            own += row.rotation[k, d] * (x[k] - row.centre[k])
            n += row.rotation[d, k] * surface.normal[near.other, k]
        near.place[d], near.normal[d] = own, n
    return 1.0


@inner_kernel
def _near(surface, s, f, d):
    """Coordinate of facet `s`, or of its image nearest to facet `f`."""
    x = surface.now[s, d]
    return x - turns(surface, x - surface.now[f, d], d)


@inner_kernel
def _find_gap(frame, rigid_bodies, surface, moved, scratch, near, used):
    """Set gap, place and normal of a facet's centroid at another body's surface.

    The displacement in the cell of the facet next to it is in `scratch`. `used` are the pieces kept
    so far; returns how many are.
    """
    D, s, f, P, (cells, u) = len(frame.cell), near.facet, near.other, scratch[0], moved
    x = (_near(surface, s, f, 0), _near(surface, s, f, 1), _near(surface, s, f, 2))
    least, phi, length, beside = frame.cell[0], 0.0, 1.0, inf
    for d in range(D):
        least = min(least, frame.cell[d])
    close, solved = True, -1
    for attempt in range(_ATTEMPTS):
        f, c, length, phi = near.other, surface.cell[near.other], 1.0, 0.0
        if c < 0:
            _rigid_place(rigid_bodies, surface, x, near)
        else:
            if c != solved:
                if attempt > 0:
                    set_polynomial(D, cells, c, u, P)
                for d in range(3):
                    near.place[d] = surface.place[f, d]
                close, K, J = _solve_place(frame, cells.low[c], x, P, near.place)
                solved = c
            n = turned_normal(K, surface.normal[f])
            length = sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
            for d in range(3):
                near.normal[d] = n[d] / length
            length /= J
        for d in range(D):
            phi += (_own(frame, cells, c, near, d) - surface.x[f, d]) * surface.normal[f, d]
        near.gap = phi / length
        most = _BESIDE * least + max(BESIDE_BEFORE * phi, -BESIDE_BEHIND * phi)
        beside = _beyond(D, frame, cells, surface, c, near, f) - most
        last = attempt + 1 == _ATTEMPTS
        if last or not (close and beside > 0.0 and abs(near.gap) < FARTHEST * least):
            break
        # Facets are no discs: the one that it is over may be beside the nearest one.
        least_beside = beside + most
        for k in range(surface.start[f], surface.start[f + 1]):
            m, alike = surface.beside[k], 0.0
            for d in range(D):
                alike += surface.normal[m, d] * surface.normal[f, d]
            if alike > ALIKE and pairs_with(surface, s, m, frame.cell[0]):
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
    same = 0.0
    for d in range(3):
        near.offset[d] = near.edges[0, d] = near.edges[1, d] = 0.0
        same += surface.turned[s, d] * near.normal[d]
    near.pieces, near.facing = 0, facing_part(same)
    second = near.body < surface.body[s]  # those of the first body look for its faces
    if same > FACES or (second and same < STEEP):
        near.gap = inf
    if c >= 0 and near.gap < _SPREADS * least:
        used = _spread(frame, surface, (cells, c, u), x, scratch, near, used)
        for d in range(D):
            near.gap += near.offset[d] * frame.cell[d] * surface.normal[f, d] / length
    return used


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
def _spread(frame, surface, there, x, scratch, near, used):
    """Set edges and offset of a facet in the other body.

    Of its pieces there the mean position is that of its place to first order. The offset leads from
    there to the facet's own mean position `x`, so that angular momentum is kept. Returns the number
    of pieces kept.
    """
    D, (P, pieces, kept), (cells, c, u) = len(frame.cell), scratch, there
    K, J = cofactors(gradient(frame, P, near.place)[0])
    for d in range(D):
        k = K[d]
        for i in range(3):
            part = k[i] * (frame.inverse[d] / J)
            near.edges[0, d] += part * surface.extent[near.facet, 0, i]
            near.edges[1, d] += part * surface.extent[near.facet, 1, i]
    count = find_pieces(D, cells, c, near, pieces)
    way = mean_displacement(D, cells, u, pieces, count)
    r = (x[0] - lane(way, 0), x[1] - lane(way, 1), x[2] - lane(way, 2))
    r = _from(frame, r, cells.low[c], near.place)
    for d in range(D):
        k = K[d]
        near.offset[d] = (k[0] * r[0] + k[1] * r[1] + k[2] * r[2]) * (frame.inverse[d] / J)
    count = add_offset(D, c, near, pieces, count)
    return keep_pieces(D, near, used, pieces, count, kept)


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


@inner_kernel
def _find_wall_gaps(frame, walls, surface, every, first, last, cell):
    """Set the gaps of the facets of a patch before a wall; returns the way until one may close."""
    plane, least = walls.planes[every[first].body - walls.first], inf
    axis, side = plane.axis, 1.0 * plane.side
    at = frame.origin[axis] + (plane.vertex - frame.ghost) * frame.cell[axis]
    for n in range(first, last):
        near, s = every[n], every[n].facet
        same, away = -side * surface.turned[s, axis], (at - surface.now[s, axis]) * side
        near.gap, near.facing = away if same <= FACES else inf, facing_part(same)
        least = min(least, max(away, until_facing(same, FACES, cell)))
        for d in range(3):
            near.normal[d] = -side if d == axis else 0.0
    return least


@inner_kernel
def _tilts(surface, near):
    """Whether a facet is a wide one that no longer lies on what it meets."""
    if not surface.tip[near.facet] & WIDE:
        return False
    return near.facing < facing_part(0.5 * _TILTED * _TILTED - 1.0)


@kernel
def find_gaps(frame, contact, walls, surface, moved, scratch, far, near) -> bool:
    """Find the gaps between facets and the other bodies next to them.

    Returns whether any wide facets that may have a gap have tilted too far to be one.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies, at their positions.
    walls : SeparatingWalls
        The unilateral walls.
    moved : (SurfaceCells, (vertices, 4) float64)
        The cells, and the displacements of the surface vertices.
    scratch
        As of `move_facets`.
    far : float
        Greatest distance: farther away the cell's displacements, extrapolated, may fold.
    near : ((n,) NEAR_FACET, Patches)
        The facets, by patch and body; `other` is where the search for the one next to them begins.
        Those of patches that rest stay as they are. Of ways below 0 every gap is looked for. Of
        patches that walk `CLEAR` is set.
    """
    D, (cells, u), (every, patches), tilted = len(frame.cell), moved, near, False
    cell, c, used = frame.cell[0], -1, 0
    for d in range(D):
        cell = min(cell, frame.cell[d])
    for k in range(len(patches.awake)):
        g, walks = patches.awake[k], patches.walks[k] != 0
        first, last, clear, least = patches.start[g], patches.start[g + 1], inf, inf
        body, s = every[first].body, every[first].facet
        law = law_of(contact.pairs, surface.body[s], body, cell, patches.ways[k])
        looks = law[2] if patches.ways[k] >= 0.0 else inf
        if body >= walls.first:
            clear = _find_wall_gaps(frame, walls, surface, every, first, last, cell)
            for n in range(first, last):
                tilted = tilted or _tilts(surface, every[n])
        for n in range(first, last if body < walls.first else first):
            every[n].gap, away = approach(D, surface, every[n], frame.cell[0], walks, far)
            least, clear = min(least, every[n].gap), min(clear, away)
        for n in range(first, last if body < walls.first else first):
            one = every[n]
            if not (law[0] > 0 and least < looks and one.gap < inf):
                one.gap = inf
                continue
            own = surface.cell[one.other]
            if own >= 0 and own != c:
                set_polynomial(D, cells, own, u, scratch[0])
            used = _find_gap(frame, contact.rigid_bodies, surface, moved, scratch, one, used)
            c = surface.cell[one.other] if own >= 0 else c
            tilted = tilted or _tilts(surface, one)
        if walks:
            patches.known[g, CLEAR] = clear
    return tilted
