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

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.data import clear_pair
from pgimp.kernels.contact.impulses.coupling import set_answer, velocity_before
from pgimp.kernels.contact.impulses.warm_start import kept_acceleration
from pgimp.kernels.contact.surfaces.held import release_across
from pgimp.kernels.contact.surfaces.levels import (
    FADES,
    FOLLOWS,
    NEAR,
    end_of_patch,
    find_sides,
    law_of,
    level,
    share,
)
from pgimp.kernels.contact.surfaces.pressed import pressed_area
from pgimp.kernels.contact.surfaces.spread import spread_weights
from pgimp.kernels.rigid.bodies import arm_of
from pgimp.physics.contact.base import TIED

#: Cells by which overlapping surfaces part in a step, at most, if they did not approach; others
#: than rigid ones beyond what compliance takes, see `soften`.
PARTS = 2e-5


@inner_kernel
def _add_cell(D, cells, c, sums, r, used, seen, coupling):
    """Add to row `r` the sums over places in a cell, by its vertices; clears the sums.

    Returns the number of entries.
    """
    column, entry = coupling.column, coupling.entry
    for k in range(cells.start[c], cells.start[c + 1]):
        w, j = 0.0, cells.column[k]
        for corner in range(1 << D):
            w += cells.weight[k, corner] * sums[corner]
        if w == 0.0:
            continue
        if seen[0, j] != r:
            if used < len(column):
                seen[0, j], seen[1, j], column[used], entry[used, 0] = r, used, j, w
            used += 1
        elif seen[1, j] < len(column):
            entry[seen[1, j], 0] += w
    for corner in range(1 << D):
        sums[corner] = 0.0
    return used


@inner_kernel
def _add_row(frame, surface, cells, group, own, at, scratch, coupling):
    """Add a row of a patch's own body, or of the other; returns the number of entries.

    `group` are facets with their weights, the first and the end of the patch's; `at` the number of
    the row, and of entries so far.
    """
    (_, seen, sums, pieces, kept), (every, first, last), (r, used), c = scratch, group, at, -1
    D = len(frame.cell)
    for n in range(first, last):
        near, part = every[n], every[n].weight
        if part == 0.0:
            continue
        f, count = near.facet if own else near.other, 1
        if not own:
            count = near.pieces
            if count == 0:
                count = spread_weights(D, cells, surface.cell[f], near, pieces)
        for m in range(count):
            cell, k = surface.cell[f], near.piece + m
            if not own:
                cell = kept[0][k] if near.pieces > 0 else pieces[0][m]
            if cell != c:
                if c >= 0:
                    used = _add_cell(D, cells, c, sums, r, used, seen, coupling)
                c = cell
            for corner in range(1 << D):
                if own:
                    sums[corner] += part * surface.means[f, corner]
                elif near.pieces > 0:
                    sums[corner] += part * kept[1][k, corner]
                else:
                    sums[corner] += part * pieces[1][m, corner]
    return _add_cell(D, cells, c, sums, r, used, seen, coupling) if c >= 0 else used


@inner_kernel
def _set_pair(contact, surface, group, side, law, size, pair):
    """Set the state of a pair, given its facets, and their weights; returns whether it is one.

    `group` is as in `_add_row`; `size` are the least side of a cell, the step, and kept forces.
    """
    (every, first, last), (cell, dt, kept), (end, row, rigid) = group, size, pair
    pairs, a, b = contact.pairs, surface.body[every[first].facet], every[first].body
    entry, swapped, near = law
    tied, least = pairs.kind[entry - 1] == TIED, inf
    for n in range(first, last):
        every[n].weight = 0.0
        if every[n].side == side:
            least = min(least, every[n].gap)
    if not least < near:
        return False
    normal, shear, reach = pairs.adhesion[entry - 1]
    glued = 0.0
    clear_pair(row)
    end.law = entry
    end.bodies[0], end.bodies[1] = (b, a) if swapped else (a, b)
    end.vertex[0], end.vertex[1] = surface.patch[every[first].facet], b
    end.vertex[2] = 2 * side  # none is beside another one
    width = max(FADES * cell, FOLLOWS * dt * dt * kept_acceleration(kept, end))
    above = NEAR * cell if tied else level(surface, every, first, last, side, least, width)
    whole, gap, sign = 0.0, above - width, 1.0 if swapped else -1.0
    if width > FADES * cell and not tied:
        gap = level(surface, every, first, last, side, least, FADES * cell) - FADES * cell
    for k in range(3):
        for d in range(3):
            rigid[k, d] = 0.0
    for n in range(first, last):
        s, w = every[n].facet, share(surface, every[n], side, above, tied)
        if every[n].side == side and every[n].gap < reach:
            glued += surface.area[s]
        if w == 0.0:
            continue
        every[n].weight = w
        whole += w
        row.area += surface.area[s]
        for d in range(3):
            row.normal[d] += sign * w * every[n].normal[d]
            rigid[2, d] += w * surface.now[s, d]
    square = row.normal[0] ** 2 + row.normal[1] ** 2 + row.normal[2] ** 2
    if not square > 0.0:
        return False
    inverse = 1.0 / sqrt(square)
    for d in range(3):
        row.normal[d] *= inverse
        rigid[2, d] /= whole
    # Facets beyond these are of material in the current configuration: it does not part.
    row.gap_rate = (gap if every[first].other < len(surface.patch) else max(gap, 0.0)) / dt
    row.adhesion, row.shear_adhesion = normal * glued * dt, shear * glued * dt
    whole = 1.0 / whole
    for n in range(first, last):
        every[n].weight *= whole
    pressed = pressed_area(surface, every, first, last, side, least, cell)
    row.area = max(row.area, pressed, glued)
    return True


@inlined
def _rigid_velocity(rigid_bodies, s, place, before):
    """Velocity of a rigid end before the step or after it. Walls are at rest.

    `s` is as in `load_rigid`.
    """
    if not is_record(rigid_bodies):
        return 0.0, 0.0, 0.0
    t = -1 - s - rigid_bodies.bodies
    if t >= len(rigid_bodies.motion):
        return 0.0, 0.0, 0.0
    motion = rigid_bodies.motion[t]
    v = motion.velocity_before if before else motion.velocity_after
    r = arm_of(rigid_bodies, t, (place[0], place[1], place[2]))
    return (
        v[0] + v[4] * r[2] - v[5] * r[1],
        v[1] + v[5] * r[0] - v[3] * r[2],
        v[2] + v[3] * r[1] - v[4] * r[0],
    )


@kernel
def find_patch_pairs(
    contact, frame, surface, cells, every, step, scratch, found
) -> tuple[int, int, int]:
    """Find the pairs of patches and other bodies, and their rows.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies.
    every : (n,) NEAR_FACET
        Facets with their gaps, by patch and other body. Sides and weights are set here.
    step : (float, (bodies,) float64, (n,) KEPT_FORCE)
        Length of the step, the ways of the fastest vertices in it, see `law_of`, and forces of
        the last step, see `begin_impulses`.
    scratch : ((m, NUMBERS) float64, (2, m) int64, (2^D,) float64, pieces, kept)
        The records of `ReferenceVertices`, and scratch; the last two as of `scratch_of`.
    found : (ContactPairs, Coupling)
        Filled: pairs, with room for one each `n`, and their rows, as far as there is room.

    Returns
    -------
    tuple of 3 int
        Numbers of pairs, rows and entries.
    """
    D, (numbers, seen, sums, _, _), (dt, travels, kept) = len(frame.cell), scratch, step
    contact_pairs, coupling = found
    cell = frame.cell[0]
    for d in range(D):
        cell = min(cell, frame.cell[d])
    seen[0, :] = -1
    sums[:] = 0.0
    pairs, rows, used, first, start = 0, 0, 0, 0, coupling.start
    start[0] = 0
    while first < len(every):
        s, last = every[first].facet, end_of_patch(surface, every, first)
        law = law_of(contact.pairs, surface.body[s], every[first].body, cell, travels)
        sides, side = 0, -1
        if law[0] > 0:
            sides = find_sides(surface, every, first, last, law[2])
        while sides >> (side + 1) != 0:
            side += 1
            if sides >> side & 1 == 0:
                continue
            end, rigid = contact_pairs.ends[pairs], contact_pairs.rigid[pairs]
            row = contact_pairs.states[pairs]
            group, pair = (every, first, last), (end, row, rigid)
            if not _set_pair(contact, surface, group, side, law, (cell, dt, kept), pair):
                continue
            for a in range(2):
                body = end.bodies[a]
                own = (a == 1) == law[1]
                f = s if own else every[first].other
                if f < 0 or surface.cell[f] < 0:
                    end.rows[a] = -1 - body
                    v = _rigid_velocity(contact.rigid_bodies, -1 - body, rigid[2], False)
                    rigid[a, 0], rigid[a, 1], rigid[a, 2] = v
                    continue
                end.rows[a] = rows
                at = rows, used
                used = _add_row(frame, surface, cells, group, own, at, scratch, coupling)
                start[rows + 1] = used
                if used <= len(coupling.column):
                    set_answer(coupling, rows, numbers)
                    release_across(coupling, rows, numbers, row.normal)
                rows += 1
            end.parted = 0.0
            for a in range(2 if used <= len(coupling.column) else 0):
                if end.rows[a] < 0:
                    v = _rigid_velocity(contact.rigid_bodies, end.rows[a], rigid[2], True)
                else:
                    v = velocity_before(coupling, end.rows[a], numbers)
                for d in range(3):
                    end.parted += (2.0 * a - 1.0) * row.normal[d] * v[d]
            if end.rows[0] < 0 and end.rows[1] < 0:
                row.gap_rate = max(row.gap_rate, -PARTS * cell / dt)
            pairs += 1
        first = last
    return pairs, rows, used
