"""Warm start: the sweeps of a step begin at impulses extrapolated from the last two steps.

Forces change little from step to step, so that fewer sweeps reach the same tolerance. Forces are
extrapolated, not impulses: steps may differ in length.
"""

from math import inf

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.contact.impulses.gauss_seidel import apply_impulse, load_pair
from pgimp.kernels.contact.law import LEAST_GIVEN
from pgimp.physics.contact.base import TIED

#: The force of a pair in a step, and the change that it is to have until the next one. A pair is
#: known by its vertex and its bodies. And the acceleration that contact gives both ends, apart.
KEPT_FORCE = structure(
    ("vertex", "i8", 3), ("bodies", "i8", 2), ("force", "f8", 3), ("change", "f8", 3),
    ("acceleration", "f8"),
)  # fmt: skip

#: Part of the last change of a force that is added to it. With 1, changes of impulses that move
#: nothing, where rows of B depend on each other, would go on for ever.
EXTRAPOLATION = 0.9


@inner_kernel
def _order(vertex, other):
    """Below, at or above 0 as a vertex comes before another, is the same, or comes after it."""
    for d in range(3):
        if vertex[d] != other[d]:
            return vertex[d] - other[d]
    return 0


@inner_kernel
def find_kept(kept, n, end):
    """First of the kept forces from `n` on at the vertex of a pair or after, and the pair's own.

    The second is -1 without one. Vertices ascend.
    """
    while n < len(kept) and _order(kept[n].vertex, end.vertex) < 0:
        n += 1
    m = n
    while m < len(kept) and _order(kept[m].vertex, end.vertex) == 0:
        one = kept[m].bodies
        if one[0] == end.bodies[0] and one[1] == end.bodies[1]:
            return n, m
        m += 1
    return n, -1


@inner_kernel
def kept_of(kept, end):
    """Number of the kept force of a pair, -1 without one."""
    low, high = 0, len(kept)
    while low < high:
        middle = (low + high) // 2
        if _order(kept[middle].vertex, end.vertex) < 0:
            low = middle + 1
        else:
            high = middle
    _, m = find_kept(kept, low, end)
    return m


@inner_kernel
def _set_impulse(contact, entry, row, J):
    """Set the impulse of a loaded pair to the part of J that its law may transmit.

    Components that both ends hold, and pairs without compliance, have none: no sweep would change
    it.
    """
    one, other, along, answer, most = contact.fields[0], contact.fields[1], 0.0, 0.0, 0.0
    for d in range(3):
        mobility = one.inverse_mass[d] + other.inverse_mass[d]
        row.tangential_impulse[d] = J[d] if mobility > 0.0 else 0.0
        along += row.tangential_impulse[d] * row.normal[d]
        answer += row.normal[d] ** 2 * mobility
        most = max(most, mobility)
    if contact.pairs.kind[entry] == TIED:
        return
    rigid = one.mass == inf or other.mass == inf
    row.normal_impulse = max(along, -row.adhesion)
    none = not answer > 0.0 or (rigid and answer < LEAST_GIVEN * most)
    if none or row.normal_impulse == 0.0:
        row.normal_impulse = 0.0
        row.tangential_impulse[0] = row.tangential_impulse[1] = row.tangential_impulse[2] = 0.0
        return
    for d in range(3):
        row.tangential_impulse[d] -= along * row.normal[d]


@kernel
def begin_impulses(contact, kept, contact_pairs, coupling, solved, dt):
    """Set the impulses of pairs to what the last steps predict for this one, and apply them.

    Parameters
    ----------
    contact : Contact
        Laws and scratch.
    kept : (n,) KEPT_FORCE
        Of the step before, in the order of their vertices, as the pairs are.
    contact_pairs, coupling, solved
        See `pgimp.kernels.contact.surfaces.groups.solve_groups`.
    dt : float
        Length of the step.
    """
    n = 0
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        n, m = find_kept(kept, n, end)
        if m < 0:
            continue
        load_pair(contact, contact_pairs, k, coupling, solved)
        force, change = kept[m].force, kept[m].change
        J = (dt * (force[0] + change[0]), dt * (force[1] + change[1]), dt * (force[2] + change[2]))
        _set_impulse(contact, end.law - 1, row, J)
        J = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        if J[0] != 0.0 or J[1] != 0.0 or J[2] != 0.0:
            apply_impulse(contact, contact_pairs, k, J, coupling, solved)


@inner_kernel
def _parted(end, normal, coupling, solved, values):
    """Velocity apart along the normal that the ends of a pair have gained in the sweeps."""
    gained = 0.0
    for side in range(2):
        r, sign = end.rows[side], 2.0 * side - 1.0
        if r >= 0:
            for n in range(coupling.start[r], coupling.start[r + 1]):
                j, weight = coupling.column[n], sign * coupling.entry[n, 0]
                for d in range(3):
                    gained += weight * normal[d] * (solved.velocity[j, d] - values[j, d])
    return gained


@kernel
def keep_impulses(contact_pairs, coupling, solved, values, dt, before, kept):
    """Keep the impulses of a step as forces; returns how many there are.

    Parameters
    ----------
    coupling, solved
        The rows of the pairs, and the vertices after the sweeps.
    values : (m, NUMBERS) float64
        The vertices before.
    before : (n,) KEPT_FORCE
        Those of the step before.
    kept : (pairs,) KEPT_FORCE
        Set here.
    """
    n, found = 0, 0
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        n, m = find_kept(before, n, end)
        J = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        if J[0] == 0.0 and J[1] == 0.0 and J[2] == 0.0:
            continue
        own = kept[found]
        for d in range(2):
            own.bodies[d] = end.bodies[d]
        for d in range(3):
            own.vertex[d] = end.vertex[d]
            own.force[d] = J[d] / dt
            own.change[d] = EXTRAPOLATION * (own.force[d] - before[m].force[d]) if m >= 0 else 0.0
        own.acceleration = 0.0
        if row.normal_impulse > 0.0:
            gained = _parted(end, row.normal, coupling, solved, values)
            own.acceleration = max(gained, 0.0) / dt
        found += 1
    return found
