"""Pairs of a patch and another body, and their rows of the coupling matrix.

The gap G of a patch is that of `pgimp.kernels.contact.surfaces.levels`, with weights W_k of its
facets. So the constraint G >= 0 acts where the patch touches. It neither takes nor gives energy: it
is holonomic. The velocity at the patch is the mean

    w = sum_k W_k sum_j N_j(X_k) v_j.

Facets that meet another side of the other body, as at its edges, are a pair of their own: no one
normal would keep both sides out.

The other body has the same sum with the places Y_k of the same points in it. So an impulse acts at
one place of space on both bodies: momentum and angular momentum are exact.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.data import clear_pair
from pgimp.kernels.contact.impulses.coupling import set_answer
from pgimp.kernels.contact.impulses.warm_start import kept_acceleration
from pgimp.kernels.contact.surfaces.held import release_across
from pgimp.kernels.contact.surfaces.levels import (
    FADES,
    FOLLOWS,
    NEAR,
    find_sides,
    law_of,
    level,
    share,
)
from pgimp.kernels.contact.surfaces.pressed import pressed_area
from pgimp.kernels.contact.surfaces.spread import spread_weights
from pgimp.kernels.rigid.bodies import arm_of
from pgimp.physics.contact.base import TIED

#: Cells by which overlapping surfaces part in a step, at most; others than rigid ones beyond what
#: compliance takes, see `soften`.
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
def _set_rigid_velocity(rigid_bodies, s, rigid, side):
    """Set the velocity of a rigid end; walls are at rest. `s` is as in `load_rigid`."""
    if not is_record(rigid_bodies):
        return None
    t = -1 - s - rigid_bodies.bodies
    if t >= len(rigid_bodies.motion):
        return
    v = rigid_bodies.motion[t].velocity_after
    arm = arm_of(rigid_bodies, t, (rigid[2, 0], rigid[2, 1], rigid[2, 2]))
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        rigid[side, d] = v[d] + v[3 + e] * arm[f] - v[3 + f] * arm[e]


@kernel
def find_patch_pairs(
    contact, frame, surface, cells, near, step, scratch, found
) -> tuple[int, int, int]:
    """Find the pairs of patches and other bodies, and their rows.

    Parameters
    ----------
    contact : Contact
        Laws and rigid bodies.
    near : ((n,) NEAR_FACET, Patches)
        Facets with their gaps, by patch and other body. Sides and weights are set here, of patches
        that are awake.
    step : (float, (n,) KEPT_FORCE)
        Length of the step, and forces of the last step, see `begin_impulses`.
    scratch : ((m, NUMBERS) float64, (2, m) int64, (2^D,) float64, pieces, kept)
        The records of `ReferenceVertices`, and scratch; the last two as of `scratch_of`.
    found : (ContactPairs, Coupling)
        Filled: pairs, with room for one each `n`, and their rows, as far as there is room.

    Returns
    -------
    tuple of 3 int
        Numbers of pairs, rows and entries.
    """
    D, (numbers, seen, sums, _, _), (dt, kept) = len(frame.cell), scratch, step
    (contact_pairs, coupling), (every, patches), cell = found, near, frame.cell[0]
    for d in range(D):
        cell = min(cell, frame.cell[d])
    seen[0, :] = -1
    sums[:] = 0.0
    pairs, rows, used, start = 0, 0, 0, coupling.start
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
            group, pair = (every, first, last), (end, row, rigid)
            if not _set_pair(contact, surface, group, side, law, (cell, dt, kept), pair):
                continue
            for a in range(2):
                body = end.bodies[a]
                own = (a == 1) == law[1]
                f = s if own else every[first].other
                if f < 0 or surface.cell[f] < 0:
                    end.rows[a] = -1 - body
                    _set_rigid_velocity(contact.rigid_bodies, -1 - body, rigid, a)
                    continue
                end.rows[a] = rows
                at = rows, used
                used = _add_row(frame, surface, cells, group, own, at, scratch, coupling)
                start[rows + 1] = used
                if used <= len(coupling.column):
                    set_answer(coupling, rows, numbers)
                    release_across(coupling, rows, numbers, row.normal)
                rows += 1
            if end.rows[0] < 0 and end.rows[1] < 0:
                row.gap_rate = max(row.gap_rate, -PARTS * cell / dt)
            pairs += 1
    return pairs, rows, used
