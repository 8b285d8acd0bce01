"""Solution for the impulses of connected groups of bodies, one group after the other.

What a group exchanges depends on it alone, and so do its sums in the books. So it does not matter
which rank has it.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import lane, pack, vector
from pgimp.kernels.contact.impulses.books import book_contacts
from pgimp.kernels.contact.impulses.gauss_seidel import apply_impulse, load_pair
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.rigid_ends import free_velocity, is_free
from pgimp.kernels.contact.impulses.rows import velocity_at
from pgimp.kernels.contact.law import LEAST_GIVEN
from pgimp.kernels.contact.sliding import sliding_part
from pgimp.kernels.data.ledger import Ledger
from pgimp.physics.contact.base import TIED

#: What the sweeps need of a pair, in rows of four numbers. Three components and a number: inverse
#: mass, and mass along the normal; compliance of its own, and least mass; velocity that no impulse
#: changes, and the root of the inverse of that mass; normal, and velocity that closes the gap;
#: impulse across the normal, and along it; that at the begin of two sweeps, and its last change.
#: Masses are 0 where nothing moves: sweeps multiply by them, as divisions would take their time.
_INVERSE, _SOFT, _FIXED, _NORMAL, _IMPULSE, _START, _CHANGE = 0, 4, 8, 12, 16, 20, 24
PREPARED = 28


@inner_kernel
def _pairs_of(contact_pairs, a, b):
    """The pairs from `a` to `b`, without a copy."""
    return ContactPairs(
        contact_pairs.ends[a:b], contact_pairs.states[a:b], contact_pairs.rigid[a:b]
    )


@inner_kernel
def _prepare(contact, contact_pairs, k, coupling, solved, prepared):
    """Set what the sweeps need of pair `k`."""
    end, row, rigid = contact_pairs.ends[k], contact_pairs.states[k], contact_pairs.rigid[k]
    load_pair(contact, contact_pairs, k, coupling, solved)
    answer, most, own = 0.0, 0.0, prepared[k]
    for d in range(3):
        inverse = contact.fields[0].inverse_mass[d] + contact.fields[1].inverse_mass[d]
        answer += row.normal[d] ** 2 * inverse
        most = max(most, inverse)
        own[_INVERSE + d], own[_NORMAL + d] = inverse, row.normal[d]
        own[_SOFT + d] = own[_FIXED + d] = 0.0
        own[_IMPULSE + d] = row.tangential_impulse[d]
        for side in range(2):
            if end.rows[side] >= 0 and len(solved.soft) > 0:
                own[_SOFT + d] += solved.soft[end.rows[side], d]
            if not is_free(contact.rigid_bodies, end.rows[side]):
                own[_FIXED + d] += (2.0 * side - 1.0) * rigid[side, d]
    own[_NORMAL + 3], own[_IMPULSE + 3], own[_FIXED + 3] = (
        row.gap_rate, row.normal_impulse, sqrt(most)
    )  # fmt: skip
    rigid_end = end.rows[0] < 0 or end.rows[1] < 0
    if contact.pairs.kind[end.law - 1] != TIED and rigid_end and answer < LEAST_GIVEN * most:
        most = 0.0  # it has no impulse
    own[_INVERSE + 3] = 1.0 / answer if answer > 0.0 else 0.0
    own[_SOFT + 3] = 1.0 / most if most > 0.0 else 0.0


@inner_kernel
def _dot(a, b):
    """Product of two vectors of three components, in lanes."""
    whole = a * b
    return lane(whole, 0) + lane(whole, 1) + lane(whole, 2)


@inner_kernel
def _exchange(contact, dt, contact_pairs, k, coupling, solved, prepared):
    """Exchange the rest of the impulse that the law of pair `k` requires.

    As `pgimp.kernels.contact.law.exchange`. Returns the greatest change and impulse, see
    `solve_groups`.
    """
    end, row, rigid = contact_pairs.ends[k], contact_pairs.states[k], contact_pairs.rigid[k]
    soft, fixed = load_row(prepared, k, _SOFT), load_row(prepared, k, _FIXED)
    least, root, entry = lane(soft, 3), lane(fixed, 3), end.law - 1
    if not least > 0.0:
        return 0.0, 0.0
    normal, across = load_row(prepared, k, _NORMAL), load_row(prepared, k, _IMPULSE)
    inverse, push = load_row(prepared, k, _INVERSE), lane(across, 3)
    before = push * normal + across
    w = soft * before + fixed
    for side in range(2):
        s, sign = end.rows[side], 2.0 * side - 1.0
        if s >= 0:
            w = sign * velocity_at(s, coupling, solved) + w
        else:
            v = free_velocity(contact.rigid_bodies, s, rigid)
            w = sign * pack(v[0], v[1], v[2], 0.0) + w
    if contact.pairs.kind[entry] == TIED:
        for d in range(3):
            if prepared[k, _INVERSE + d] > 0.0:
                prepared[k, _IMPULSE + d] -= lane(w, d) / prepared[k, _INVERSE + d]
        after = push * normal + load_row(prepared, k, _IMPULSE)
    else:
        mass, along, pressed = lane(inverse, 3), _dot(w, normal), push
        if mass > 0.0:
            pressed = max(0.0, push - mass * (along + lane(normal, 3)))
            if pressed == 0.0 and row.adhesion > 0.0:
                required = min(0.0, push - mass * along)
                pressed = max(-row.adhesion, required)
                row.adhesion_used = pressed / required if required < 0.0 else 1.0
        stick = across - least * (w - along * normal)
        length, shear_adhesion = sqrt(_dot(stick, stick)), row.shear_adhesion
        if pressed < 0.0:
            shear_adhesion *= sqrt(1.0 - (pressed / row.adhesion) ** 2)
        part = sliding_part(
            contact.pairs, entry, shear_adhesion, max(pressed, 0.0), row.area * dt, length,
            length * (root * root),
        )  # fmt: skip
        row.sticking = part
        stick = part * stick
        store_row(
            prepared, k, _IMPULSE, pack(lane(stick, 0), lane(stick, 1), lane(stick, 2), pressed)
        )
        after = pressed * normal + stick
    change = after - before
    J = (lane(change, 0), lane(change, 1), lane(change, 2))
    if J[0] != 0.0 or J[1] != 0.0 or J[2] != 0.0:
        apply_impulse(contact, contact_pairs, k, J, coupling, solved)
    size = max(abs(lane(after, 0)), abs(lane(after, 1)), abs(lane(after, 2)))
    return max(abs(J[0]), abs(J[1]), abs(J[2])) * root, size * root


@inner_kernel
def _go_on(contact, contact_pairs, group, coupling, solved, prepared, before):
    """Go on along the last changes of the impulses of a group; returns their square.

    `before` is that of the two sweeps before, below 0 without any.
    """
    (order, a, b), square = group, 0.0
    for n in range(a, b):
        k = order[n]
        change = load_row(prepared, k, _IMPULSE) - load_row(prepared, k, _START)
        store_row(prepared, k, _START, change)
        square += _dot(change, change) + lane(change, 3) ** 2
    part = square / before if before > 0.0 else 0.0
    for n in range(a, b):
        k = order[n]
        if part > 1.0:
            store_row(prepared, k, _CHANGE, vector(0.0))
            continue
        way = part * load_row(prepared, k, _CHANGE)
        if part > 0.0:
            store_row(prepared, k, _IMPULSE, load_row(prepared, k, _IMPULSE) + way)
            J = lane(way, 3) * load_row(prepared, k, _NORMAL) + way
            J = (lane(J, 0), lane(J, 1), lane(J, 2))
            if J[0] != 0.0 or J[1] != 0.0 or J[2] != 0.0:
                apply_impulse(contact, contact_pairs, k, J, coupling, solved)
        store_row(prepared, k, _CHANGE, way + load_row(prepared, k, _START))
    return square


@inner_kernel
def _solve_group(contact, dt, contact_pairs, group, coupling, solved, prepared, accuracy):
    """Solve for the impulses of a group; returns the sweeps.

    `group` has the pairs by group, and of these the first one and the end.
    """
    (order, a, b), before = group, -1.0
    for n in range(a, b):
        _prepare(contact, contact_pairs, order[n], coupling, solved, prepared)
        store_row(prepared, order[n], _CHANGE, vector(0.0))
    done, sweep = False, 0
    while not done and sweep < accuracy[0]:
        forwards, change, most = sweep % 2 == 0, 0.0, 0.0
        if forwards:
            for n in range(a, b):
                store_row(prepared, order[n], _START, load_row(prepared, order[n], _IMPULSE))
        for n in range(b - a):
            k = order[a + n if forwards else b - 1 - n]
            own = _exchange(contact, dt, contact_pairs, k, coupling, solved, prepared)
            change, most = max(change, own[0]), max(most, own[1])
        sweep += 1
        done = change <= accuracy[1] * most
        if not done and not forwards and sweep < accuracy[0]:
            before = _go_on(contact, contact_pairs, group, coupling, solved, prepared, before)
    for n in range(a, b):
        k = order[n]
        row = contact_pairs.states[k]
        row.normal_impulse = prepared[k, _IMPULSE + 3]
        for d in range(3):
            row.tangential_impulse[d] = prepared[k, _IMPULSE + d]
    return sweep


@kernel
def solve_groups(contact, free, pairs, coupling, solved, prepared, accuracy):
    """Exchange impulses in the pairs of each group until the law holds for all of them.

    Patches side by side have some vertices in common, and sweeps alone converge slowly. After two
    of them, forwards and backwards, the impulses go on along their last changes, as in the method
    of conjugate gradients: Silcowitz, Niebe and Erleben, A nonsmooth nonlinear conjugate gradient
    method for interactive contact force problems, Visual Comput. 26, 893-901 (2010).

    Parameters
    ----------
    contact : Contact
        Laws and scratch.
    free : Holding
        With the step. Held components have zero inverse mass.
    pairs : (ContactPairs, (pairs,) int64, (groups + 1,) int64)
        The pairs; their offsets by group, and the first of each in that order.
    coupling : Coupling
        The response to impulses.
    solved : Solved
        The reference vertices; their velocities are changed here.
    prepared : (pairs, PREPARED) float64
        Scratch.
    accuracy : (int, float)
        Sweeps, at most, alternately forwards and backwards; and the greatest change of an impulse
        in a sweep that ends them, relative to the greatest impulse. Both are times the root of the
        pair's inverse mass, so that energies are compared.

    Returns
    -------
    int
        Sweeps of all groups.
    """
    (contact_pairs, order, first), sweeps = pairs, 0
    for g in range(len(first) - 1):
        group = order, first[g], first[g + 1]
        sweeps += _solve_group(
            contact, free.forcing.dt, contact_pairs, group, coupling, solved, prepared, accuracy
        )
    return sweeps


@kernel
def book_groups(contact, free, grouped, coupling, solved, values, walls, ledger):
    """Book what groups have exchanged, each in a plane of its own; see `book_contacts`.

    `grouped` has the pairs by group, and the first of each.
    """
    contact_pairs, first = grouped
    for g in range(len(first) - 1):
        own = _pairs_of(contact_pairs, first[g], first[g + 1])
        books = Ledger(
            ledger.work[g : g + 1], ledger.impulse[g : g + 1], ledger.outside_mass,
            ledger.constraint_impulse, ledger.wall_energy[g : g + 1], ledger.contact[g : g + 1],
            ledger.rigid_bodies[g : g + 1], ledger.escaped, ledger.filled, ledger.damping,
            ledger.crossed, ledger.traction_impulse, ledger.contact_moments[g : g + 1],
        )  # fmt: skip
        book_contacts(contact, free, own, coupling, solved, values, walls, books)


@kernel
def find_changed(keys, values, solved, changes) -> int:
    """Find what impulses have changed, see `Changes`; returns at how many vertices.

    `keys`, (m,) int64, and `values`, (m, NUMBERS) float64, are those of `ReferenceVertices`.
    """
    found = 0
    for j in range(len(keys)):
        some = False
        for d in range(3):
            changes.velocities[found, d] = solved.velocity[j, d] - values[j, d]
            changes.held[found, d] = solved.held_impulse[j, d]
            some = some or changes.velocities[found, d] != 0.0 or changes.held[found, d] != 0.0
        if some:
            changes.keys[found] = keys[j]
            found += 1
    return found
