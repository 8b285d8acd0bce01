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
from pgimp.kernels.contact.surfaces.levels import SOON, law_of
from pgimp.kernels.contact.surfaces.motion import rigid_position
from pgimp.kernels.rigid.bodies import arm_of

#: Cells by which a patch moves beside another body before the facets next to it are found anew.
WALK = 0.002

#: Ways of facets of a patch relative to the middle one over those of its cell's vertices, relative
#: to their mean: facets are up to a cell away, and what they meet turns as well.
_AROUND = 2.5

#: Steps for which a patch rests without being looked at, at most.
LONGEST = 16


@inlined
def _rigid(rigid_bodies, surface, f, cell):
    """Position and velocity of a rigid facet, and the greatest velocities about it, of turning."""
    if not is_record(rigid_bodies):
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    x, t = rigid_position(rigid_bodies, surface, f), surface.body[f] - rigid_bodies.bodies
    r, v = arm_of(rigid_bodies, t, x), rigid_bodies.motion[t].velocity_after
    w = (
        v[0] + v[4] * r[2] - v[5] * r[1], v[1] + v[5] * r[0] - v[3] * r[2],
        v[2] + v[3] * r[1] - v[4] * r[0],
    )  # fmt: skip
    return x, w, cell * sqrt(v[3] ** 2 + v[4] ** 2 + v[5] ** 2)


@inner_kernel
def _greatest(D, cells, c, values, mean):
    """Greatest distance of the vertices' values in a cell from their mean."""
    most = 0.0
    for corner in range(1 << D):
        v = load_row(values, cells.corners[c, corner], 0) - mean
        most = max(most, lane(v, 0) ** 2 + lane(v, 1) ** 2 + lane(v, 2) ** 2)
    return sqrt(most)


@inner_kernel
def _moves(D, rigid_bodies, surface, moved, f, cell):
    """Mean position and velocity of a facet, and how its cell's vertices move relative to it.

    The latter are the greatest way since the last search, 0 of rigid facets, the greatest velocity,
    and that of a rigid body's turning.
    """
    (cells, u, ways, values), c = moved, surface.cell[f]
    if c < 0:
        x, w, turning = _rigid(rigid_bodies, surface, f, cell)
        return x, w, 0.0, turning, turning
    at, v, mean, way = vector(0.0), vector(0.0), vector(0.0), vector(0.0)
    for corner in range(1 << D):
        n, part = cells.corners[c, corner], 1.0 / (1 << D)
        own = load_row(values, n, 0)
        at = surface.means[f, corner] * load_row(u, n, 0) + at
        v = surface.means[f, corner] * own + v
        mean, way = part * own + mean, part * load_row(ways, n, 0) + way
    x = surface.x[f]
    return (
        (x[0] + lane(at, 0), x[1] + lane(at, 1), x[2] + lane(at, 2)),
        (lane(v, 0), lane(v, 1), lane(v, 2)),
        _greatest(D, cells, c, ways, way), _greatest(D, cells, c, values, mean), 0.0,
    )  # fmt: skip


@inner_kernel
def _wakes(D, contact, surface, moved, every, first, last, step):
    """Whether a patch may have a pair, whether the facets next to it are to be found anew.

    Also the way by which it may come nearer in the step.
    """
    (dt, cell), begin, rigid = step, every[first], contact.rigid_bodies
    s, f = every[(first + last) // 2].facet, every[(first + last) // 2].other
    x, v, loose, most, turning = _moves(D, rigid, surface, moved, s, cell)
    square, closing = 0.0, 0.0
    if f >= 0:
        y, w, loose_there, most_there, turning_there = _moves(D, rigid, surface, moved, f, cell)
        loose, most, turning = loose + loose_there, most + most_there, turning + turning_there
        x = (x[0] - y[0], x[1] - y[1], x[2] - y[2])
        v = (v[0] - w[0], v[1] - w[1], v[2] - w[2])
    for d in range(3):
        off = x[d] - begin.way[d]
        square += (off - (turns(surface, off, d) if f >= 0 else 0.0)) ** 2
        closing += v[d] * v[d]
    loose, way = _AROUND * loose, dt * (sqrt(closing) + _AROUND * most)
    law = law_of(contact.pairs, surface.body[s], begin.body, cell, way)
    off, turning = sqrt(square) + loose + begin.loose, _AROUND * dt * turning
    begin.clear -= turning
    left = begin.clear - off - law[2]
    if law[0] > 0 and not left > 0.0:
        walks = off > WALK * cell
        if walks:
            begin.loose = loose
        return True, walks, way
    # As it moves now, what is left suffices for some times as long.
    begin.pause = LONGEST
    if SOON * way * LONGEST > left:
        begin.pause = int(left / (SOON * way))
    begin.clear -= turning * begin.pause
    return False, False, way


@kernel
def find_awake(frame, contact, surface, moved, dt, every, patches, moving) -> tuple[int, int]:
    """Find the patches that may have a pair in a step, and the facets to be moved for them.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies, at their positions.
    moved : (SurfaceCells, three times (vertices, 4) float64)
        The cells, and of the surface vertices displacements, now and since the last search, and
        velocities.
    dt : float
        The step.
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
    D, (every_moving, marks, chosen, count) = len(frame.cell), moving
    cell, awake, found = frame.cell[0], 0, 0
    for d in range(D):
        cell = min(cell, frame.cell[d])
    for n in range(count):
        for d in range(3):
            surface.now[chosen[n], d] = inf
    for g in range(len(patches.start) - 1):
        first, last = patches.start[g], patches.start[g + 1]
        if every[first].pause > 0:
            every[first].pause -= 1
            continue
        wakes, walks, way = _wakes(D, contact, surface, moved, every, first, last, (dt, cell))
        if not wakes:
            for n in range(first, last):
                every[n].gap, every[n].side = inf, -1
            continue
        patches.awake[awake], patches.ways[awake] = g, way
        patches.walks[awake] = 1 if walks else 0
        awake += 1
        marks[surface.patch[every[first].facet]] = 1
        for n in range(first, last):
            f = every[n].other
            if f >= 0:
                marks[surface.patch[f]] = 1
            if f >= 0 and walks:
                for k in range(surface.start[f], surface.start[f + 1]):
                    marks[surface.patch[surface.beside[k]]] = 1
    for n in range(len(every_moving)):
        if marks[surface.patch[every_moving[n]]] != 0:
            chosen[found] = every_moving[n]
            found += 1
    marks[:] = 0
    return awake, found
