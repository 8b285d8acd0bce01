"""The facet of one body next to a facet of another, in an array of flat discs."""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.surfaces.data import turns

#: Greatest cosine between normals of facets that meet; above `OPPOSED` they meet less readily than
#: others: at an edge a face meets the other face that it lies on, not the one beside it. Weight of
#: the square of what is above, over that of a distance of a cell.
MEETS, OPPOSED, ASKEW = 0.3, -0.5, 4.0

#: Greatest cosine between normals of facets with a gap: others are beside an edge. Cosine below
#: which facets of a second body leave it to the first one's to look for them.
FACES, STEEP = -0.03, -0.8

#: Cosine from which on facets have no gap before a plane, and by which others may be off in it.
ACROSS, TURNS = FACES + 0.02, 0.02

#: Cells by which facets of one body are apart in the initial state if they may meet.
APART = 2.0

#: Weight of the distance along a facet, so that one of several in a plane is next to a point.
_ALONG = 1e-6

#: Way by which a point may be beside a facet and have a gap, over that before it, or behind it.
BESIDE_BEFORE, BESIDE_BEHIND = 0.5, 0.15

#: Part of a disc's radius by which a gap may be less than the distance from its plane.
_OFF = 0.25

#: Cells by which facets have to come nearer before they are looked at again, at most: which is next
#: to another may change on the way.
CLEAR = 0.3

#: Beside a disc by more than its radius times the root of 2: least part of the square that is from
#: the rim on.
_BEYOND = 0.0857


#: Marks of facets: beside a sharp edge; in a plane with their neighbours; without neighbours that
#: are alike and not in their plane; of a wide one. Then the first bit of the number of its side.
TIP, FLAT, PLANE, WIDE, SIDE = 1, 2, 4, 8, 4

#: Radii from a flat facet's centroid within which the one that a point is over is this or one
#: beside it.
_OVER = 1.5

#: Least cosine between normals of facets of one face.
ALIKE = 0.9


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
def pairs_with(surface, s, f, cell):
    """Whether facet `s` may look for `f`: of another body, or `apart` in its own."""
    return surface.body[s] != surface.body[f] or apart(surface, s, f, cell)


@inner_kernel
def square_between(D, surface, s, cell, f, most):
    """Square of the distance of facet `s` from facet `f`, with the `reluctance` of both.

    It is inf where it is seen to be above `most` before roots are taken.
    """
    x, facing = surface.now[s], surface.turned[s]
    if not pairs_with(surface, s, f, cell):
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
    least = square_between(D, surface, s, cell, f, inf)
    while True:
        best = f
        for k in range(surface.start[f], surface.start[f + 1]):
            other = surface.beside[k]
            square = square_between(D, surface, s, cell, other, least)
            if square < least or (square == least < inf and other < best):
                least, best = square, other
        if best == f:
            return f
        f = best


@inner_kernel
def stays(surface, s, f):
    """Whether of facet `f` and those beside it the one next to facet `s` is in a plane with it."""
    square, along = 0.0, 0.0
    for d in range(3):
        way = surface.now[s, d] - surface.now[f, d]
        way -= turns(surface, way, d)
        square += way * way
        along += way * surface.turned[f, d]
    beside = square - along * along
    return surface.tip[f] & FLAT and beside < (_OVER * surface.radius[f]) ** 2


@inner_kernel
def until_facing(same, most, cell):
    """Way by which facets have to turn, as in `find_awake`, until their cosine is at `most`."""
    return CLEAR * cell * min(1.0, (same - most) / (MEETS - FACES))


@inner_kernel
def approach(D, surface, near, cell, walks, farthest):
    """Least gap that a facet may have before the one next to it; inf if these are far apart.

    Also the way by which both have to come nearer before a gap may close, at least; it may be below
    0, and is `CLEAR` at most.

    Parameters
    ----------
    near : NEAR_FACET
        The facet. With `walks` the one next to it is found, from `other` on.
    cell, farthest : float
        Side of a cell, and distance beyond which facets are far apart.
    """
    s = near.facet
    if walks and not stays(surface, s, near.other):
        near.other = next_facet(D, surface, s, cell, near.other)
    f, along, whole, same, over = near.other, 0.0, 0.0, 0.0, 0.0
    for d in range(3):
        way = surface.now[s, d] - surface.now[f, d]
        way -= turns(surface, way, d)
        along += way * surface.turned[f, d]
        whole += way * way
        same += surface.turned[s, d] * surface.turned[f, d]
    if same > MEETS:
        return inf, CLEAR * cell  # as `until_facing`
    beside = max(whole - along * along, 0.0)
    if D > 1:
        over = max(0.0, sqrt(beside) - surface.radius[f])
    gap = along - _OFF * surface.radius[f]
    square = along * along + _ALONG * beside + over * over
    clear = min(max(gap, sqrt(square) - farthest), CLEAR * cell)
    if D == 2:  # a facet ends where its disc does: what is beside it has a way to go
        aside = over - max(BESIDE_BEFORE * along, -BESIDE_BEHIND * along) - _OFF * surface.radius[f]
        clear = max(clear, min(aside / (1.0 + BESIDE_BEFORE), CLEAR * cell))
    second = near.body < surface.body[s]
    if surface.tip[f] & PLANE and (same > ACROSS or (second and same < STEEP - TURNS)):
        return inf, max(clear, until_facing(same, ACROSS, cell))
    if square > farthest * farthest:
        return inf, clear
    if not pairs_with(surface, s, f, cell):
        return inf, clear
    return gap, clear
