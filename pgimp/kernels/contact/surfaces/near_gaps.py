"""Gaps of the patches that may have a pair in a step: which ones, where facets are, gaps."""

from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.surfaces.awake import choose, find_awake, set_place
from pgimp.kernels.contact.surfaces.data import KNOWN, PLACE, Patches
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.nearest import stays


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
            choose(surface, mobile[n], at)
        marks[p] = False
    return count[0]


@kernel
def find_near_gaps(
    frame, contact, walls, surface, moved, dt, near, moving, scratch, far, now
) -> int:
    """Find the gaps of the patches that may have a pair in a step; returns how many patches.

    See `find_awake` for what patches and facets these are, with `now` for its scratch, and
    `find_gaps` for the rest.
    """
    (cells, u, _), (every, patches), chosen = moved, near, moving[4]
    own, cell = (scratch[0], *now), frame.cell[0]
    for d in range(len(frame.cell)):
        cell = min(cell, frame.cell[d])
    awake, moves = find_awake(frame, contact, surface, moved, dt, near, moving, own)
    move_facets(frame, contact.rigid_bodies, surface, cells, u, chosen[:moves], scratch)
    patches = Patches(
        patches.start, patches.awake[:awake], patches.walks[:awake], patches.ways[:awake],
        patches.known,
    )  # fmt: skip
    every_move = find_around(surface, (every, patches), moving)
    more = chosen[moves:every_move]
    move_facets(frame, contact.rigid_bodies, surface, cells, u, more, scratch)
    find_gaps(frame, contact, walls, surface, (cells, u), scratch, far, (every, patches))
    for k in range(awake):
        if patches.walks[k] == 0:
            continue
        g = patches.awake[k]
        known, middle = patches.known[g], every[(patches.start[g] + patches.start[g + 1]) // 2]
        if middle.other == now[1][k]:
            for n in range(PLACE, KNOWN):
                known[n] = now[0][k, n]
        else:
            of = surface, moved, scratch[0], (middle.facet, middle.other)
            set_place(frame, contact.rigid_bodies, *of, cell, known)
    return awake
