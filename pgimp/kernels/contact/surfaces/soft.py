"""Compliance between neighbouring patches: impulses that alternate would hardly move anything.

Impulses of patches move the vertices beside these. Where they alternate from patch to patch they
cancel at every vertex. So sweeps find them slowly, and errors of gaps make them large. As for
pressures that are constant by cell, jumps between neighbours get a compliance of their own:
Silvester and Kechkar, Stabilised bilinear-constant velocity-pressure finite elements, Comput.
Methods Appl. Mech. Eng. 79, 71-86 (1990). With the response A of the pairs' velocities to impulses,
and areas a_i of patches that bear, it is

    C = c (S - A),   S_ii = sum_j A_ij a_j / a_i.

Even pressure has none. A + C = (1 - c) A + c S: the sweeps have vertices that are heavier, and a
compliance of each pair's own. So eigenvalues of A + C differ by a factor of about 1/c. The sum has
all patches that may bear in the step, so that C is never below zero. Patches of a second body at
its tips have c A_ii, and what is between them and others is not felt there. So where those of the
first body bear already, they do not.

Along the normal C J is a gap: a stiff spring. Across it the change of J since the last step counts,
so that friction holds what it bears. Normals of patches differ: what C makes of impulses along them
has a part across others, which would let these creep; it is taken away.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import lane, pack, vector
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.rigid_ends import free_velocity, is_free
from pgimp.kernels.contact.impulses.rows import add_impulse, velocity_at
from pgimp.kernels.contact.impulses.warm_start import EXTRAPOLATION, begin_impulses, find_kept
from pgimp.kernels.contact.sliding import sliding_part
from pgimp.kernels.contact.surfaces.awake import dot, in_lanes
from pgimp.kernels.contact.surfaces.groups import solve_groups
from pgimp.physics.contact.base import TIED

#: The factor c.
SOFT = 0.1

#: Least area of a patch in its weight here, in faces of a cell.
LEAST_AREA = 0.1


@inner_kernel
def _is_second(end):
    """Whether a patch is of the second of two bodies, at a tip: patches of the first are there."""
    return end.vertex[1] < max(end.bodies[0], end.bodies[1])


@inner_kernel
def _set_areas(contact_pairs, kept, sizes, areas):
    """Set the areas of patches in sums, 0 of those without; `areas` are their normal velocities.

    These are patches of first bodies that bore in the last step, or may in this one.
    """
    (dt, least, _, soon), m = sizes, 0
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        m, one = find_kept(kept, m, end)
        counts = not _is_second(end) and (one >= 0 or (areas[k] + row.gap_rate) * dt < soon)
        areas[k] = max(row.area, least) if counts else 0.0


@inner_kernel
def _sum_areas(contact_pairs, coupling, areas, sums):
    """Add the entries of rows times the area vectors of their patches."""
    for k in range(len(contact_pairs.ends)):
        if areas[k] == 0.0:
            continue
        normal = in_lanes(contact_pairs.states[k].normal)
        for side in range(2):
            r, sign = contact_pairs.ends[k].rows[side], 2.0 * side - 1.0
            if r >= 0:
                along = (sign * areas[k]) * normal
                for n in range(coupling.start[r], coupling.start[r + 1]):
                    j = coupling.column[n]
                    store_row(sums, j, 0, coupling.entry[n, 0] * along + load_row(sums, j, 0))


@inner_kernel
def _set_soft(coupling, solved, r, area, sums, normal):
    """Set the compliance c S of a row of a patch, and its whole response.

    `area` has the sign of the side; 0 of a patch that does not count, see `_set_areas`: it has a
    spring of its own, beside what its own response takes. Inverse masses are those with compliance.
    """
    whole, own = 0.0, 0.0
    for d in range(3):
        own += normal[d] * normal[d] * coupling.answer[r, d]
    if area != 0.0:  # the velocity along the normal that even pressure gives
        v = vector(0.0)
        for n in range(coupling.start[r], coupling.start[r + 1]):
            j = coupling.column[n]
            response = load_row(sums, j, 0) * load_row(solved.inverse_mass, j, 0)
            v = coupling.entry[n, 0] * response + v
        whole = dot(v, in_lanes(normal)) / (1.0 - SOFT)
        whole = max(whole / area, own)
    for d in range(3):
        answer = coupling.answer[r, d]
        least = whole if area != 0.0 else 2.0 * answer
        solved.soft[r, d] = SOFT * least if answer > 0.0 else 0.0
        coupling.answer[r, d] = (1.0 - SOFT) * answer + solved.soft[r, d]


@inner_kernel
def _along(force, normal):
    """Component along a normal."""
    return force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2]


@inner_kernel
def _reference(contact, end, row, kept, dt, across):
    """Impulse of the last step from which compliance counts, across the normal or along it: half.

    So gaps follow the impulse 2 J - J' of the step's end: springs that end steps with the impulse J
    of the step would damp. Across the normal, and where adhesion holds, gaps are not known; there
    it is how this changes. The law bounds it.
    """
    change, entry = 0.5 / EXTRAPOLATION, end.law - 1
    J = tuple(dt * (kept.force[d] + change * kept.change[d]) for d in range(3))
    if contact.pairs.kind[entry] == TIED:
        return J if across else (0.0, 0.0, 0.0)
    along = _along(J, row.normal)
    if not across:
        begins = 0.5 * dt * _along(kept.force, row.normal)
        begins = max(along, -row.adhesion) if along < 0.0 else begins
        return (begins * row.normal[0], begins * row.normal[1], begins * row.normal[2])
    t = tuple(J[d] - along * row.normal[d] for d in range(3))
    length = sqrt(t[0] ** 2 + t[1] ** 2 + t[2] ** 2)
    stress, pressed = row.area * dt, max(along, 0.0)
    part = sliding_part(contact.pairs, entry, row.shear_adhesion, pressed, stress, length, 0.0)
    return (part * t[0], part * t[1], part * t[2])


@inner_kernel
def _grown(one, normal):
    """Depth that compliance had after the last step, over what half the step's impulse gives.

    That was 2 J' - J'' of the last two steps, over J'; alike for all pairs near each other. A pair
    without a change is a new one.
    """
    force, change = _along(one.force, normal), _along(one.change, normal)
    if not force > 0.0:
        return 1.0
    return 2.0 if change == 0.0 else 1.0 + min(max(change / (EXTRAPOLATION * force), -1.0), 1.0)


@inner_kernel
def _own_depth(solved, end, row, one, dt):
    """Depth over the step that a patch's own spring keeps, see `_set_soft`."""
    begins, found = 0.25 * dt * max(_along(one.force, row.normal), 0.0), 0.0
    for side in range(2):
        r = end.rows[side]
        if r >= 0:
            for d in range(3):
                found += begins * solved.soft[r, d] * row.normal[d] ** 2
    return found


@inner_kernel
def _velocity(contact, contact_pairs, k, coupling, solved):
    """Velocity of a pair's ends apart, without impulses of its own."""
    end, rigid, v = contact_pairs.ends[k], contact_pairs.rigid[k], vector(0.0)
    for side in range(2):
        r, sign = end.rows[side], 2.0 * side - 1.0
        if is_free(contact.rigid_bodies, r):
            w = free_velocity(contact.rigid_bodies, r, rigid)
            v = sign * pack(w[0], w[1], w[2], 0.0) + v
            continue
        v = sign * pack(rigid[side, 0], rigid[side, 1], rigid[side, 2], 0.0) + v
        if r >= 0:
            v = sign * velocity_at(r, coupling, solved) + v
    return (lane(v, 0), lane(v, 1), lane(v, 2))


@inner_kernel
def _add_references(contact, kept, contact_pairs, coupling, solved, dt, across):
    """Let compliance count from the impulses of the last step, see `_reference`."""
    again, m = SOFT / (1.0 - SOFT), 0
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        m, one = find_kept(kept, m, end)
        if one < 0:
            continue
        J = _reference(contact, end, row, kept[one], dt, across)
        for side in range(2):
            r, sign = end.rows[side], 2.0 * side - 1.0
            if r >= 0:
                for d in range(3):
                    contact_pairs.rigid[k, side, d] -= sign * solved.soft[r, d] * J[d]
                add_impulse(r, (again * J[0], again * J[1], again * J[2]), sign, coupling, solved)


@inner_kernel
def _hold_across(contact, contact_pairs, k, coupling, solved, before):
    """Take the part across the normal from what impulses along normals have added to a pair."""
    end, normal = contact_pairs.ends[k], contact_pairs.states[k].normal
    side = 1 if end.rows[1] >= 0 else 0
    if end.rows[side] < 0:
        return
    v, along = _velocity(contact, contact_pairs, k, coupling, solved), 0.0
    for d in range(3):
        along += normal[d] * (before[d] - v[d])
    for d in range(3):
        change = before[d] - v[d] - along * normal[d]
        contact_pairs.rigid[k, side, d] -= (2.0 * side - 1.0) * change


@inner_kernel
def _soften(contact, kept, contact_pairs, coupling, solved, sizes, scratch):
    """Give the pairs their compliance; `_apply` ends what this begins.

    Masses are those with it. Changes the answers of `coupling`. `sizes` and `scratch` are as of
    `solve_softly`.
    """
    (dt, _, parts, _), (sums, before, areas) = sizes, scratch
    for k in range(len(contact_pairs.ends)):
        v = _velocity(contact, contact_pairs, k, coupling, solved)
        before[k, 0], before[k, 1], before[k, 2] = v
        areas[k] = _along(v, contact_pairs.states[k].normal)
    _set_areas(contact_pairs, kept, sizes, areas)
    _sum_areas(contact_pairs, coupling, areas, sums)
    for k in range(len(contact_pairs.ends)):
        for side in range(2):
            r = contact_pairs.ends[k].rows[side]
            if r >= 0:
                area, normal = (2.0 * side - 1.0) * areas[k], contact_pairs.states[k].normal
                _set_soft(coupling, solved, r, area, sums, normal)
    _add_references(contact, kept, contact_pairs, coupling, solved, dt, False)
    for k in range(len(contact_pairs.ends)):
        _hold_across(contact, contact_pairs, k, coupling, solved, before[k])
    _add_references(contact, kept, contact_pairs, coupling, solved, dt, True)
    m = 0
    for k in range(len(contact_pairs.ends)):
        row = contact_pairs.states[k]
        m, one = find_kept(kept, m, contact_pairs.ends[k])
        if contact_pairs.ends[k].rows[0] < 0 and contact_pairs.ends[k].rows[1] < 0:
            continue
        # Half of what the last step's impulses give: the depth of the compliance at rest.
        v = _velocity(contact, contact_pairs, k, coupling, solved)
        deep = _along(before[k], row.normal) - _along(v, row.normal)
        part = _grown(kept[one], row.normal) if one >= 0 else 1.0
        if one >= 0 and areas[k] == 0.0:
            row.gap_rate += _own_depth(solved, contact_pairs.ends[k], row, kept[one], dt)
        most = max(parts / dt, -contact_pairs.ends[k].parted)
        row.gap_rate = max(row.gap_rate, -most - part * max(deep, 0.0))
        if areas[k] == 0.0 or row.gap_rate == 0.0:  # no gap corrects it
            row.gap_rate -= deep


@inner_kernel
def _apply(contact_pairs, coupling, solved):
    """Apply the impulses of all pairs to the vertices, as they are without compliance.

    `solved` is as after `begin_solution`.
    """
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        J = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        for side in range(2):
            r = end.rows[side]
            if r >= 0:
                for d in range(3):
                    contact_pairs.rigid[k, side, d] = 0.0
                add_impulse(r, J, 2.0 * side - 1.0, coupling, solved)


@kernel
def solve_softly(contact, free, kept, pairs, coupling, solved, room, limits) -> int:
    """Solve for the impulses of groups, with compliance between patches; returns the sweeps.

    Parameters
    ----------
    contact, free, pairs, coupling
        See `solve_groups`.
    kept : (n,) KEPT_FORCE
        Of the last step, see `begin_impulses`.
    solved : Solved
        After `begin_solution`; impulses of the solution are applied.
    room : (Solved, (rows, 3) float64, tuple, tuple)
        Scratch: vertices and answers with compliance, with `soft` of their own. Then sums at
        vertices, (vertices, 4) float64; velocities, (pairs, 3) float64; areas, (pairs,) float64.
        Last that of `solve_groups`.
    limits : (float, float, float, float), (int, float)
        The step; least area of a patch in its weight; the length by which overlaps end in a step,
        see `pgimp.kernels.contact.surfaces.patches.rows`, beyond what compliance takes; the gap at
        which a patch may bear. Then the accuracy, see `solve_groups`.
    """
    (contact_pairs, _, _), (softened, answer, scratch, sweeping) = pairs, room
    (sizes, accuracy), sums = limits, scratch[0]
    for j in range(len(solved.velocity)):
        store_row(softened.velocity, j, 0, load_row(solved.velocity, j, 0))
        store_row(softened.inverse_mass, j, 0, (1.0 - SOFT) * load_row(solved.inverse_mass, j, 0))
        store_row(softened.held_impulse, j, 0, load_row(solved.held_impulse, j, 0))
        store_row(sums, j, 0, vector(0.0))
    for k in range(len(coupling.column)):
        softened.moved[k] = (1.0 - SOFT) * solved.moved[k]
    for r in range(len(coupling.answer)):
        softened.free[r] = solved.free[r]
        for d in range(3):
            answer[r, d], softened.soft[r, d] = coupling.answer[r, d], 0.0
    compliant = Coupling(coupling.start, coupling.column, coupling.entry, answer)
    _soften(contact, kept, contact_pairs, compliant, softened, sizes, scratch)
    begin_impulses(contact, kept, contact_pairs, compliant, softened, sizes[0])
    sweeps = solve_groups(contact, free, pairs, compliant, softened, sweeping, accuracy)
    _apply(contact_pairs, coupling, solved)
    return sweeps
