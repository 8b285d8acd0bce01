"""Pairs of a patch and another body, and their rows of the coupling matrix.

The gap G of a patch is that of `pgimp.kernels.contact.surfaces.patches.levels`, with weights W_k of
its facets. So the constraint G >= 0 acts where the patch touches. It neither takes nor gives
energy: it is holonomic. The velocity at the patch is the mean

    w = sum_k W_k sum_j N_j(X_k) v_j.

Facets that meet another side of the other body, as at its edges, are a pair of their own: no one
normal would keep both sides out.

The other body has the same sum with the places Y_k of the same points in it. So an impulse acts at
one place of space on both bodies: momentum and angular momentum are exact.

In a step G falls by more than its weights tell, as these move to what comes nearer: bodies overlap
after it. Were that forgotten, what the weights have moved to would be stopped without return. So
overlaps end in the next step, but no faster than the ends approached before it: the impulse times
the mean of both velocities, which is what contact does to the energy, is never above zero.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.data import clear_pair
from pgimp.kernels.contact.impulses.coupling import release_across, set_answer, velocity_of
from pgimp.kernels.contact.impulses.pairs import SIDES
from pgimp.kernels.contact.impulses.reference_grid import OF_VELOCITY, OF_VELOCITY_BEFORE
from pgimp.kernels.contact.impulses.warm_start import find_kept
from pgimp.kernels.contact.surfaces.patches.entries import add_row
from pgimp.kernels.contact.surfaces.patches.levels import (
    AREA,
    FACET,
    FADES,
    FOLLOWS,
    GAP,
    NEAR,
    NUMBER,
    WEIGHT,
    find_sides,
    gather,
    law_of,
    level,
)
from pgimp.kernels.contact.surfaces.patches.pressed import pressed_area
from pgimp.kernels.contact.surfaces.patches.stiff import (
    are_stiff,
    foresee,
    free_acceleration,
    lean,
    rigid_velocity,
)
from pgimp.physics.contact.base import TIED

#: Cells by which overlapping surfaces part in a step, at most, if they did not approach; others
#: than rigid ones beyond what compliance takes, see `solve_softly`.
PARTS = 2e-5

#: Factor by which the length d that a step asks for is above the one that it has, if pairs are set
#: anew.
WIDER = 2.0


@inner_kernel
def _set_end(surface, near, side, law, end):
    """Set law, bodies and number of a pair, given one of its facets."""
    a, b = surface.body[near.facet], near.body
    end.law = law[0]
    end.bodies[0], end.bodies[1] = (b, a) if law[1] else (a, b)
    end.vertex[0], end.vertex[1], end.vertex[2] = surface.patch[near.facet], b, SIDES + side


@inner_kernel
def _set_pair(contact, surface, group, law, size, pair, width):
    """Set the state of a pair, given its facets, and their weights; returns the length d, or 0.

    There is no pair if that is 0; d is at least `width`. `group` is as in `add_row`, with the
    number of these facets, the area of the patch, and the deepest one. `size` are the least side of
    a cell, the step, kept forces, and the number of the pair's own, -1 without one.
    """
    (every, own, numbers, (count, all_of_it, deepest)), (cell, dt, kept, m), (end, row, rigid) = (
        group, size, pair
    )  # fmt: skip
    pairs, (entry, swapped, near), least = contact.pairs, law, every[deepest].gap
    tied = pairs.kind[entry - 1] == TIED
    if not least < near:
        return 0.0
    normal, shear, reach = pairs.adhesion[entry - 1]
    glued = 0.0
    clear_pair(row)
    stiff = not tied and are_stiff(contact, surface, every[deepest])
    width = max(width, FADES * cell)
    if m >= 0:
        width = max(width, FOLLOWS * dt * dt * kept[m].acceleration)
    if stiff:
        least, width = foresee(contact, surface, group, cell, dt)
        if m >= 0:
            pushed = free_acceleration(contact.rigid_bodies, end, kept[m].force)
            width = max(width, FOLLOWS * dt * dt * pushed)
    above = NEAR * cell if tied else level(own, count, all_of_it, least, width)
    whole, gap, sign = 0.0, 0.0 if stiff else above - width, 1.0 if swapped else -1.0
    if width > FADES * cell and not (tied or stiff):
        gap = level(own, count, all_of_it, least, FADES * cell) - FADES * cell
    for k in range(3):
        for d in range(3):
            rigid[k, d] = 0.0
    for m in range(count):
        depth, area = above - own[GAP, m], own[AREA, m]
        if own[GAP, m] < reach:
            glued += area
        if not depth > 0.0:
            continue
        w, s, one = (area if tied else area * depth), numbers[FACET, m], every[numbers[NUMBER, m]]
        own[WEIGHT, m] = w
        whole += w
        row.area += area
        for d in range(3):
            row.normal[d] += sign * w * one.normal[d]
            rigid[2, d] += w * surface.now[s, d]
        if stiff:
            gap += w * one.gap - lean(surface, one, s, depth, w, rigid[2])
    square = row.normal[0] ** 2 + row.normal[1] ** 2 + row.normal[2] ** 2
    if not square > 0.0:
        return 0.0
    inverse = 1.0 / sqrt(square)
    for d in range(3):
        row.normal[d] *= inverse
        rigid[2, d] /= whole
    if stiff:
        gap /= whole
    # Facets beyond these are of material in the current configuration: it does not part.
    parts = every[deepest].other >= len(surface.patch)
    row.gap_rate = (max(gap, 0.0) if parts else gap) / dt
    row.adhesion, row.shear_adhesion = normal * glued * dt, shear * glued * dt
    whole = 1.0 / whole
    for m in range(count):
        own[WEIGHT, m] *= whole
        every[numbers[NUMBER, m]].weight = own[WEIGHT, m]
    pressed = pressed_area(surface, own, numbers, count, least, cell)
    row.area = max(row.area, pressed, glued)
    return width


@inner_kernel
def _set_rows(contact, frame, of, at, scratch, coupling):
    """Set the rows of a pair, velocities of rigid ends, and how fast its ends parted before.

    `of` are the surface, its cells, whether the law swaps the bodies, and group and pair of
    `_set_pair`. `at` are numbers of rows and of entries so far. Returns both, and the velocity at
    which the ends come nearer without contact.
    """
    (surface, cells, swapped, (every, own, numbers, gathered), (end, row, rigid)), (rows, used) = (
        of, at
    )  # fmt: skip
    near, values, coming, start = every[gathered[2]], scratch[0], 0.0, coupling.start
    end.parted = 0.0
    for a in range(2):
        body, is_own = end.bodies[a], (a == 1) == swapped
        f = near.facet if is_own else near.other
        v, before = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if f < 0 or surface.cell[f] < 0:
            end.rows[a] = -1 - body
            v = rigid_velocity(contact.rigid_bodies, -1 - body, rigid[2], False)
            before = rigid_velocity(contact.rigid_bodies, -1 - body, rigid[2], True)
            rigid[a, 0], rigid[a, 1], rigid[a, 2] = v
        else:
            end.rows[a], facets = rows, (every, own, numbers, gathered[0])
            place = rows, used
            used = add_row(frame, surface, cells, facets, is_own, place, scratch, coupling)
            start[rows + 1] = used
            if used <= len(coupling.column):
                set_answer(coupling, rows, values)
                release_across(coupling, rows, values, row.normal)
                v = velocity_of(coupling, rows, values, OF_VELOCITY)
                before = velocity_of(coupling, rows, values, OF_VELOCITY_BEFORE)
            rows += 1
        for d in range(3):
            along = (2.0 * a - 1.0) * row.normal[d]
            coming -= along * v[d]
            end.parted += along * before[d]
    return rows, used, coming


@kernel
def find_patch_pairs(
    contact, frame, surface, cells, near, step, scratch, found
) -> tuple[int, int, int, int]:
    """Find the pairs of patches and other bodies, and their rows.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies.
    near : ((n,) NEAR_FACET, Patches)
        Candidates with their gaps, by patch and other body. Sides and weights are set here, of
        patches that are awake.
    step : (float, (n,) KEPT_FORCE)
        Length of the step, and forces of the last step, see `begin_impulses`.
    scratch : ((m, NUMBERS) float64, (m, 2) int64, group, pieces, kept)
        The records of `ReferenceVertices`, and scratch; the last two as of `scratch_of`. In
        `group` are sums, (cells, 2^D) float64, cells, (cells,) int64, and room of `gather`.
    found : (ContactPairs, Coupling)
        Filled: pairs, with room for one each `n`, and their rows, as far as there is room.

    Returns
    -------
    tuple of 4 int
        Numbers of pairs, rows and entries; the candidate with the least gap, -1 without any.
    """
    D, (values, seen, (sums, known, own, numbers), pieces, its), (dt, kept) = (
        len(frame.cell), scratch, step
    )  # fmt: skip
    (contact_pairs, coupling), (every, patches), cell = found, near, frame.cell[0]
    room = values, seen, (sums, known), pieces, its
    for d in range(D):
        cell = min(cell, frame.cell[d])
    seen[:, 0] = -1
    sums[:] = 0.0
    pairs, rows, used, start, deepest, later = 0, 0, 0, coupling.start, -1, 0
    start[0] = 0
    for k in range(len(patches.awake)):
        first, last = patches.start[patches.awake[k]], patches.start[patches.awake[k] + 1]
        s = every[first].facet
        law = law_of(contact.pairs, surface.body[s], every[first].body, cell, patches.ways[k])
        sides, side = 0, -1
        if law[0] > 0:
            sides = find_sides(surface, every, first, last, law[2])
        while sides >> (side + 1) != 0:
            side += 1
            if sides >> side & 1 == 0:
                continue
            end, rigid = contact_pairs.ends[pairs], contact_pairs.rigid[pairs]
            row = contact_pairs.states[pairs]
            gathered = gather(surface, (every, first, last), side, own, numbers)
            if deepest < 0 or every[gathered[2]].gap < every[deepest].gap:
                deepest = gathered[2]
            group, pair = (every, own, numbers, gathered), (end, row, rigid)
            _set_end(surface, every[gathered[2]], side, law, end)
            later, one = find_kept(kept, later, end)
            size, began = (cell, dt, kept, one), (rows, used)
            width = _set_pair(contact, surface, group, law, size, pair, 0.0)
            if not width > 0.0:
                continue
            of = surface, cells, law[1], group, pair
            rows, used, coming = _set_rows(contact, frame, of, began, room, coupling)
            wider = FOLLOWS * dt * (coming - row.gap_rate)
            moves = end.rows[0] >= 0 or end.rows[1] >= 0  # rigid ones foresee it
            if moves and wider > WIDER * width:
                for n in range(began[1], min(used, len(coupling.column))):
                    seen[coupling.column[n], 0] = -1
                _set_pair(contact, surface, group, law, size, pair, wider)
                rows, used, _ = _set_rows(contact, frame, of, began, room, coupling)
            if end.rows[0] < 0 and end.rows[1] < 0:
                row.gap_rate = max(row.gap_rate, -PARTS * cell / dt)
            pairs += 1
    return pairs, rows, used, deepest
