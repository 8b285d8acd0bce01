"""Pairs of a patch and another body, and their rows of the coupling matrix.

The gap G of a patch is that of `pgimp.kernels.contact.surfaces.levels`, with weights W_k of its
facets. So the constraint G >= 0 acts where the patch touches. It neither takes nor gives energy: it
is holonomic. The velocity at the patch is the mean

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
from pgimp.jit.vectors.lanes import sum_of
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.kernels.contact.data import clear_pair
from pgimp.kernels.contact.impulses.coupling import release_across, set_answer, velocity_before
from pgimp.kernels.contact.impulses.pairs import SIDES
from pgimp.kernels.contact.impulses.warm_start import kept_of
from pgimp.kernels.contact.surfaces.levels import (
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
from pgimp.kernels.contact.surfaces.pressed import pressed_area
from pgimp.kernels.contact.surfaces.spread import spread_weights
from pgimp.kernels.contact.surfaces.stiff import (
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


@inner_kernel
def _add_cell(D, cells, c, place, at, seen, coupling):
    """Add to a row the sums over places in a cell, by its vertices; clears the sums.

    `place` are all sums, and the row of these; `at` is as in `_add_row`. Returns the number of
    entries.
    """
    (r, used), (sums, m), column, entry = at, place, coupling.column, coupling.entry
    for k in range(cells.start[c], cells.start[c + 1]):
        w, j = 0.0, cells.column[k]
        if D == 3:
            part = load_row(cells.weight, k, 0) * load_row(sums, m, 0)
            part = load_row(cells.weight, k, 4) * load_row(sums, m, 4) + part
            w = sum_of(part)
        else:
            for corner in range(1 << D):
                w += cells.weight[k, corner] * sums[m, corner]
        if w == 0.0:
            continue
        if seen[j, 0] != r:
            if used < len(column):
                seen[j, 0], seen[j, 1], column[used], entry[used, 0] = r, used, j, w
            used += 1
        elif seen[j, 1] < len(column):
            entry[seen[j, 1], 0] += w
    for corner in range(1 << D):
        sums[m, corner] = 0.0
    return used


@inner_kernel
def _add_places(D, sums, m, part, weights, row):
    """Add a part of the weights at a place to the sums of its cell."""
    if D == 3:
        store_row(sums, m, 0, part * load_row(weights, row, 0) + load_row(sums, m, 0))
        store_row(sums, m, 4, part * load_row(weights, row, 4) + load_row(sums, m, 4))
    else:
        for corner in range(1 << D):
            sums[m, corner] += part * weights[row, corner]


@inner_kernel
def _add_row(frame, surface, cells, group, own, at, scratch, coupling):
    """Add a row of a patch's own body, or of the other; returns the number of entries.

    `group` are candidates, with those of the patch from `gather`; `at` the number of the row, and
    of entries so far.
    """
    (_, seen, (sums, known), pieces, kept), (every, gathered, numbers, count) = scratch, group
    D, found, m, (r, used) = len(frame.cell), 0, 0, at
    for n in range(count):
        part, f = gathered[WEIGHT, n], numbers[FACET, n]
        if part == 0.0:
            continue
        near, several = every[numbers[NUMBER, n]], 1
        if not own:
            f, several = near.other, near.pieces
            if several == 0:
                several = spread_weights(D, cells, surface.cell[f], near, pieces)
        for k in range(several):
            cell = surface.cell[f]
            if not own:
                cell = kept[0][near.piece + k] if near.pieces > 0 else pieces[0][k]
            if found == 0 or known[m] != cell:
                m = 0
                while m < found and known[m] != cell:
                    m += 1
                if m == len(known):  # many cells: begin anew
                    for each in range(found):
                        place = sums, each
                        used = _add_cell(D, cells, known[each], place, (r, used), seen, coupling)
                    m, found = 0, 0
                if m == found:
                    known[m] = cell
                    found += 1
            if own:
                _add_places(D, sums, m, part, surface.means, f)
            elif near.pieces > 0:
                _add_places(D, sums, m, part, kept[1], near.piece + k)
            else:
                _add_places(D, sums, m, part, pieces[1], k)
    for each in range(found):
        used = _add_cell(D, cells, known[each], (sums, each), (r, used), seen, coupling)
    return used


@inner_kernel
def _set_pair(contact, surface, group, side, law, size, pair):
    """Set the state of a pair, given its facets, and their weights; returns whether it is one.

    `group` is as in `_add_row`, with the number of these facets, the area of the patch, and the
    deepest one; `size` are the least side of a cell, the step, and kept forces.
    """
    (every, own, numbers, (count, all_of_it, deepest)), (cell, dt, kept), (end, row, rigid) = (
        group, size, pair
    )  # fmt: skip
    pairs, (entry, swapped, near), least = contact.pairs, law, every[deepest].gap
    a, b = surface.body[every[deepest].facet], every[deepest].body
    tied = pairs.kind[entry - 1] == TIED
    if not least < near:
        return False
    normal, shear, reach = pairs.adhesion[entry - 1]
    glued = 0.0
    clear_pair(row)
    end.law = entry
    end.bodies[0], end.bodies[1] = (b, a) if swapped else (a, b)
    end.vertex[0], end.vertex[1] = surface.patch[every[deepest].facet], b
    end.vertex[2] = SIDES + side
    m, stiff = kept_of(kept, end), not tied and are_stiff(contact, surface, every[deepest])
    width = max(FADES * cell, FOLLOWS * dt * dt * kept[m].acceleration if m >= 0 else 0.0)
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
        return False
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
    return True


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
    pairs, rows, used, start, deepest = 0, 0, 0, coupling.start, -1
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
            if not _set_pair(contact, surface, group, side, law, (cell, dt, kept), pair):
                continue
            for a in range(2):
                body = end.bodies[a]
                is_own = (a == 1) == law[1]
                f = s if is_own else every[gathered[2]].other
                if f < 0 or surface.cell[f] < 0:
                    end.rows[a] = -1 - body
                    v = rigid_velocity(contact.rigid_bodies, -1 - body, rigid[2], False)
                    rigid[a, 0], rigid[a, 1], rigid[a, 2] = v
                    continue
                end.rows[a] = rows
                at, facets = (rows, used), (every, own, numbers, gathered[0])
                used = _add_row(frame, surface, cells, facets, is_own, at, room, coupling)
                start[rows + 1] = used
                if used <= len(coupling.column):
                    set_answer(coupling, rows, values)
                    release_across(coupling, rows, values, row.normal)
                rows += 1
            end.parted = 0.0
            for a in range(2 if used <= len(coupling.column) else 0):
                if end.rows[a] < 0:
                    v = rigid_velocity(contact.rigid_bodies, end.rows[a], rigid[2], True)
                else:
                    v = velocity_before(coupling, end.rows[a], values)
                for d in range(3):
                    end.parted += (2.0 * a - 1.0) * row.normal[d] * v[d]
            if end.rows[0] < 0 and end.rows[1] < 0:
                row.gap_rate = max(row.gap_rate, -PARTS * cell / dt)
            pairs += 1
    return pairs, rows, used, deepest
