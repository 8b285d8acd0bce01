"""Patches that may meet another body in a step: others rest until what was between them is used up.

When the facets next to a patch are found, so is the way by which patch and other body have to come
nearer until a gap can close. In the steps after, of both only the middle facets are looked at: how
they have moved relative to each other, and how the cells there have turned and strained. So bodies
that move together cost little, however fast they are. They are looked at in every step: what is at
rest may be pushed in the next. Of patches that touch and move it is not asked how far.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, pack, vector
from pgimp.kernels.contact.surfaces.data import CLEAR, FAR, KNOWN, PLACE, Patches, least_side, turns
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import (
    cross,
    gradient,
    move_facets,
    rigid_position,
    set_polynomial,
    set_triple,
)
from pgimp.kernels.contact.surfaces.nearest import stays
from pgimp.kernels.contact.surfaces.patches.levels import law_of
from pgimp.kernels.rigid.bodies import arm_of

#: Cells by which a patch moves beside another body before the facets next to it are found anew.
WALK = 1e-4

#: Cells from the middle facet of a patch to what is around it, and meets it; and over the greatest
#: distance between vertices of a cell and its middle.
_AROUND, _BEYOND = 1.0, 2.0

#: `side` of the middle facet of a patch that rests.
RESTS = -2

#: Facets of a patch before a wall up to which these are moved without a look at its middle one.
_FEW = 4


@inlined
def _rigid_velocity(rigid_bodies, surface, f, cell):
    """See `_velocity`."""
    if not is_record(rigid_bodies):
        return vector(0.0), 0.0
    x, t = rigid_position(rigid_bodies, surface, f), surface.body[f] - rigid_bodies.bodies
    v = rigid_bodies.motion[t].velocity_after
    w = cross(pack(v[3], v[4], v[5], 0.0), in_lanes(arm_of(rigid_bodies, t, x)))
    return (
        pack(v[0] + w[0], v[1] + w[1], v[2] + w[2], 0.0),
        cell * sqrt(v[3] ** 2 + v[4] ** 2 + v[5] ** 2),
    )


@inlined
def _rigid_place(rigid_bodies, surface, f):
    """See `_place`."""
    zero = vector(0.0)
    if not is_record(rigid_bodies):
        return zero, (zero, zero, zero)
    x, t = rigid_position(rigid_bodies, surface, f), surface.body[f] - rigid_bodies.bodies
    R = rigid_bodies.motion[t].rotation
    return in_lanes(x), (in_lanes(R[:, 0]), in_lanes(R[:, 1]), in_lanes(R[:, 2]))


@inner_kernel
def in_lanes(v):
    """Three components in lanes."""
    return pack(v[0], v[1], v[2], 0.0)


@inner_kernel
def dot(a, b):
    """Product of vectors in lanes."""
    return lane(a, 0) * lane(b, 0) + lane(a, 1) * lane(b, 1) + lane(a, 2) * lane(b, 2)


@inner_kernel
def _velocity(D, rigid_bodies, surface, moved, f, cell):
    """Velocity of a facet, in lanes, and the greatest one about it of its cell's vertices."""
    (cells, _, values), c = moved, surface.cell[f]
    if c < 0:
        return _rigid_velocity(rigid_bodies, surface, f, cell)
    v, mean, part, most = vector(0.0), vector(0.0), 1.0 / (1 << D), 0.0
    for corner in range(1 << D):
        own = load_row(values, cells.corners[c, corner], 0)
        v, mean = surface.means[f, corner] * own + v, part * own + mean
    for corner in range(1 << D):
        w = load_row(values, cells.corners[c, corner], 0) - mean
        most = max(most, dot(w, w))
    return v, sqrt(most)


@inner_kernel
def _approach(D, rigid_bodies, surface, moved, both, cell):
    """Velocity at which a patch and another body may come nearer, about two facets.

    The second facet is below 0 at a wall.
    """
    s, f = both
    v, most = _velocity(D, rigid_bodies, surface, moved, s, cell)
    if f >= 0:
        w, more = _velocity(D, rigid_bodies, surface, moved, f, cell)
        v, most = v - w, most + more
    return sqrt(dot(v, v)) + _BEYOND * most


@inner_kernel
def _place(frame, rigid_bodies, surface, moved, P, f):
    """Position of a facet, in lanes, and its deformation gradient, a triple of columns.

    `P` is scratch.
    """
    (cells, u, _), c, x = moved, surface.cell[f], surface.x[f]
    if c < 0:
        return _rigid_place(rigid_bodies, surface, f)
    set_polynomial(len(frame.cell), cells, c, u, P)
    F, p = gradient(frame, P, surface.place[f])
    return pack(x[0] + p[0], x[1] + p[1], x[2] + p[2], 0.0), F


@inner_kernel
def _set_place(frame, rigid_bodies, surface, moved, P, both, row):
    """Set the place of one facet relative to another, and deformations there, see `KNOWN`."""
    s, f = both
    r, F = _place(frame, rigid_bodies, surface, moved, P, s)
    for k in range(PLACE + 12, KNOWN):
        row[k] = 0.0
    if f >= 0:
        y, G = _place(frame, rigid_bodies, surface, moved, P, f)
        r = r - y
        r = pack(
            lane(r, 0) - turns(surface, lane(r, 0), 0), lane(r, 1) - turns(surface, lane(r, 1), 1),
            lane(r, 2) - turns(surface, lane(r, 2), 2), 0.0,
        )  # fmt: skip
        for k in range(3):
            set_triple(row[PLACE + 12 + 3 * k : PLACE + 15 + 3 * k], G[k])
    set_triple(row[PLACE : PLACE + 3], r)
    for k in range(3):
        set_triple(row[PLACE + 3 + 3 * k : PLACE + 6 + 3 * k], F[k])


@inner_kernel
def _way_off(known, now, cell):
    """Way by which a patch has moved relative to another body since its facets were found.

    `known` and `now` are rows, see `KNOWN`.
    """
    square, turned = 0.0, 0.0
    for k in range(3):
        square += (now[PLACE + k] - known[PLACE + k]) ** 2
    for k in range(PLACE + 3, KNOWN):
        turned += (now[k] - known[k]) ** 2
    return sqrt(square) + _AROUND * cell * sqrt(turned)


@inner_kernel
def _touches(known, law, way, cell):
    """Whether a patch is awake and walks, however far it has moved.

    `law` is as of `law_of`, `way` is by how much it may come nearer in the step.
    """
    return way > WALK * cell and not known[CLEAR] - law[2] > 0.0


@inner_kernel
def _choose(surface, f, at):
    """Choose a facet to be moved, unless it is chosen; see `find_awake` for both of `at`."""
    chosen, count = at
    if surface.now[f, 0] == inf:
        surface.now[f, 0], chosen[count[0]] = 0.0, f
        count[0] += 1


@kernel
def find_awake(frame, contact, surface, moved, dt, near, moving, scratch) -> tuple[int, int]:
    """Find the patches that may have a pair in a step, and the facets to be moved for them.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies, at their positions.
    moved : (SurfaceCells, (vertices, 4) float64, (vertices, NUMBERS) float64)
        The cells, and of the surface vertices displacements, and records.
    dt : float
        The step.
    near : ((n,) NEAR_FACET, Patches)
        Facets near others, by patch and body. Which patches are awake, and walk, is set here.
    moving : tuple
        Facets that may be moved, (m,) int64, and the first of each patch, (patches + 1,); patches
        beside each; (patches,) bool, False. Then int64 with room for all: the facets moved in the
        step before, set to those to be moved, candidates of patches that are awake and the facets
        next to them; (1,) int64, their number. Of patches that walk all facets of what they meet
        and what is beside are moved. Where others are is no longer known. Last whether all facets
        of patches that are awake and of what they meet are wanted.
    scratch : ((2^(D+1), 4) float64, (KNOWN,) float64)
        Scratch.

    Returns
    -------
    tuple of 2 int
        Numbers of patches that are awake, and of facets to be moved.
    """
    (every, patches), (_, _, _, _, chosen, moved_before, _) = near, moving
    D, rigid_bodies, cell = len(frame.cell), contact.rigid_bodies, least_side(frame)
    awake, at, now = 0, (chosen, moved_before), scratch[1]
    for n in range(moved_before[0]):
        for d in range(3):
            surface.now[chosen[n], d] = inf
    moved_before[0] = 0
    for g in range(len(patches.start) - 1):
        first, last = patches.start[g], patches.start[g + 1]
        known, middle = patches.known[g], every[(first + last) // 2]
        s, both = middle.facet, (middle.facet, middle.other)
        way = dt * _approach(D, rigid_bodies, surface, moved, both, cell)
        law = law_of(contact.pairs, surface.body[s], middle.body, cell, way)
        wakes, walks = law[0] > 0, True
        if middle.other < 0 and last - first <= _FEW and surface.cell[s] >= 0:
            walks = False
        elif wakes and not _touches(known, law, way, cell):
            off = inf
            if known[PLACE] != FAR:
                _set_place(frame, rigid_bodies, surface, moved, scratch[0], both, now)
                off = _way_off(known, now, cell)
            wakes, walks = not known[CLEAR] - off - law[2] > 0.0, off > WALK * cell
        if not wakes:
            if middle.side != RESTS:
                for n in range(first, last):
                    every[n].gap, every[n].side = inf, -1
                middle.side = RESTS
            continue
        patches.awake[awake], patches.ways[awake] = g, way
        patches.walks[awake] = 1 if walks else 0
        awake += 1
        for n in range(first, last):
            _choose(surface, every[n].facet, at)
        for n in range(first, last):
            if every[n].other >= 0:
                _choose(surface, every[n].other, at)
    return awake, moved_before[0]


@kernel
def find_around(surface, near, moving) -> int:
    """Find further facets to be moved: around those that may not be next to a facet any more.

    Returns how many are to be moved in all; see `find_awake`, after which facets have moved.
    """
    (every, patches), (mobile, begin, around, marks, chosen, count, whole) = near, moving
    some, at = False, (chosen, count)
    for k in range(len(patches.awake)):
        first, last = patches.start[patches.awake[k]], patches.start[patches.awake[k] + 1]
        walks, q = patches.walks[k] != 0, -1
        if whole:
            some, marks[surface.patch[every[first].facet]] = True, True
        for n in range(first, last if walks or whole else first):
            one = every[n]
            if one.other < 0 or not (whole or not stays(surface, one.facet, one.other)):
                continue
            p = surface.patch[one.other]
            if p == q:
                continue
            some, marks[p], q = True, True, p
            for m in range(around[0][p], around[0][p + 1] if walks else around[0][p]):
                marks[around[1][m]] = True
    for p in range(len(marks) if some else 0):
        for n in range(begin[p], begin[p + 1] if marks[p] else begin[p]):
            _choose(surface, mobile[n], at)
        marks[p] = False
    return count[0]


@kernel
def find_near_gaps(frame, contact, walls, surface, moved, lengths, near, room) -> tuple[int, bool]:
    """Find the gaps of the patches that may have a pair in a step; returns how many patches.

    Also what `find_gaps` returns, see there. See `find_awake` for what patches these are. `lengths`
    are the step and the greatest distance; `room` is `moving` and scratch of both.
    """
    (cells, u, _), (every, patches), (dt, far), (moving, scratch, row) = moved, near, lengths, room
    chosen, cell, rigid_bodies = moving[4], least_side(frame), contact.rigid_bodies
    own = scratch[0], row
    awake, moves = find_awake(frame, contact, surface, moved, dt, near, moving, own)
    move_facets(frame, rigid_bodies, surface, cells, u, chosen[:moves], scratch)
    patches = Patches(
        patches.start, patches.awake[:awake], patches.walks[:awake], patches.ways[:awake],
        patches.known,
    )  # fmt: skip
    every_move = find_around(surface, (every, patches), moving)
    more = chosen[moves:every_move]
    move_facets(frame, rigid_bodies, surface, cells, u, more, scratch)
    own = every, patches
    tilted = find_gaps(frame, contact, walls, surface, (cells, u), scratch, far, own)
    for k in range(awake):
        if patches.walks[k] == 0:
            continue
        g = patches.awake[k]
        known, middle = patches.known[g], every[(patches.start[g] + patches.start[g + 1]) // 2]
        bodies, way = (surface.body[middle.facet], middle.body), patches.ways[k]
        law = law_of(contact.pairs, bodies[0], bodies[1], cell, way)
        known[PLACE] = FAR
        if not _touches(known, law, way, cell):
            both = middle.facet, middle.other
            _set_place(frame, rigid_bodies, surface, moved, scratch[0], both, known)
    return awake, tilted
