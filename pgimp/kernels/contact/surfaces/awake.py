"""Patches that may meet another body in a step: others rest until what was between them is used up.

When the facets next to a patch are found, so is the way by which patch and other body have to come
nearer until a gap can close. In the steps after, of both only the middle facets are looked at: how
they have moved relative to each other, and how the cells there have turned and strained. So bodies
that move together cost nothing, however fast they are.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, vector
from pgimp.kernels.contact.surfaces.data import turns
from pgimp.kernels.contact.surfaces.levels import law_of
from pgimp.kernels.contact.surfaces.motion import rigid_position

#: Cells by which a patch moves beside another body before the facets next to it are found anew.
WALK = 0.002

#: Ways of facets of a patch relative to the middle one over those of its cell's vertices, relative
#: to their mean: facets are up to a cell away, and what they meet turns as well.
_AROUND = 2.5

#: `side` of the first facet of patches at rest.
_RESTS = -2


@inlined
def _spin(rigid_bodies, surface, f, dt):
    """Angle by which a rigid facet turns in a step."""
    if not is_record(rigid_bodies):
        return 0.0
    v = rigid_bodies.motion[surface.body[f] - rigid_bodies.bodies].velocity_after
    return dt * sqrt(v[3] ** 2 + v[4] ** 2 + v[5] ** 2)


@inner_kernel
def _moved(D, rigid_bodies, surface, moved, f):
    """Mean position of a facet, and the greatest way of its cell's vertices relative to the mean.

    The latter is since the last search, and 0 of rigid facets.
    """
    (cells, u, before), c, most = moved, surface.cell[f], 0.0
    if c < 0:
        return rigid_position(rigid_bodies, surface, f), 0.0
    at, mean, whole = vector(0.0), vector(0.0), 1.0 / (1 << D)
    for corner in range(1 << D):
        v = cells.corners[c, corner]
        now = load_row(u, v, 0)
        at = surface.means[f, corner] * now + at
        mean = whole * (now - load_row(before, v, 0)) + mean
    for corner in range(1 << D):
        v = cells.corners[c, corner]
        way = (load_row(u, v, 0) - load_row(before, v, 0)) - mean
        square = lane(way, 0) ** 2 + lane(way, 1) ** 2 + lane(way, 2) ** 2
        most = max(most, square)
    x = surface.x[f]
    return (x[0] + lane(at, 0), x[1] + lane(at, 1), x[2] + lane(at, 2)), sqrt(most)


@inner_kernel
def _wakes(D, contact, surface, moved, every, first, last, step):
    """Whether a patch may have a pair, and whether the facets next to it are to be found anew."""
    (dt, cell, travels), begin = step, every[first]
    s, f = every[(first + last) // 2].facet, every[(first + last) // 2].other
    a, b = surface.body[s], begin.body
    x, loose = _moved(D, contact.rigid_bodies, surface, moved, s)
    spin = _spin(contact.rigid_bodies, surface, s, dt) if surface.cell[s] < 0 else 0.0
    way = x
    if f >= 0:
        y, more = _moved(D, contact.rigid_bodies, surface, moved, f)
        loose += more
        spin += _spin(contact.rigid_bodies, surface, f, dt) if surface.cell[f] < 0 else 0.0
        way = (x[0] - y[0], x[1] - y[1], x[2] - y[2])
    square = 0.0
    for d in range(3):
        off = way[d] - begin.way[d]
        square += (off - (turns(surface, off, d) if f >= 0 else 0.0)) ** 2
    begin.clear -= _AROUND * spin * cell
    loose *= _AROUND
    off, law = sqrt(square) + loose + begin.loose, law_of(contact.pairs, a, b, cell, travels)
    awake = law[0] > 0 and not begin.clear - off > law[2]
    walks = awake and off > WALK * cell
    if walks:
        begin.loose = loose
    return awake, walks


@kernel
def find_awake(frame, contact, surface, moved, step, every, patches, moving) -> tuple[int, int]:
    """Find the patches that may have a pair in a step, and the facets to be moved for them.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies, at their positions.
    moved : (SurfaceCells, (vertices, 4) float64, (vertices, 4) float64)
        The cells, and displacements of the surface vertices: now, and at the last search.
    step : (float, (bodies,) float64)
        Its length, and the ways of the fastest vertices in it, see `law_of`.
    every : (n,) NEAR_FACET
        Facets near others, by patch and body.
    patches : Patches
        Which are awake, and walk, is set here.
    moving : ((m,) int64, (patches,) uint8, (m,) int64, int)
        Facets that may be moved; scratch, of zeros; of these facets those of patches that are
        awake, and beside what they meet: set here. Before, as many as the last number says are
        those of the step before: their positions are no longer known.

    Returns
    -------
    tuple of 2 int
        Numbers of patches that are awake, and of facets to be moved.
    """
    D, (every_moving, marks, chosen, count), (dt, travels) = len(frame.cell), moving, step
    cell, awake, found = frame.cell[0], 0, 0
    for d in range(D):
        cell = min(cell, frame.cell[d])
    for n in range(count):
        for d in range(3):
            surface.now[chosen[n], d] = inf
    for g in range(len(patches.start) - 1):
        first, last = patches.start[g], patches.start[g + 1]
        wakes, walks = _wakes(D, contact, surface, moved, every, first, last, (dt, cell, travels))
        if not wakes:
            if every[first].side != _RESTS:
                for n in range(first, last):
                    every[n].gap, every[n].side = inf, -1
                every[first].side = _RESTS
            continue
        patches.awake[awake], patches.walks[awake] = g, 1 if walks else 0
        awake += 1
        marks[surface.patch[every[first].facet]] = 1
        for n in range(first, last):
            f = every[n].other
            if f >= 0:
                marks[surface.patch[f]] = 1
                for k in range(surface.start[f], surface.start[f + 1]):
                    marks[surface.patch[surface.beside[k]]] = 1
    for n in range(len(every_moving)):
        if marks[surface.patch[every_moving[n]]] != 0:
            chosen[found] = every_moving[n]
            found += 1
    marks[:] = 0
    return awake, found
