"""Solution for the impulses of connected groups of bodies, one group after the other.

What a group exchanges depends on it alone, and so do its sums in the books. So it does not matter
which rank has it.
"""

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.lagrangian.books import book_contacts
from pgimp.kernels.contact.lagrangian.gauss_seidel import solve_impulses
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs
from pgimp.kernels.data.ledger import Ledger


@inner_kernel
def _pairs_of(contact_pairs, a, b):
    """The pairs from `a` to `b`, without a copy."""
    return ContactPairs(
        contact_pairs.ends[a:b], contact_pairs.states[a:b], contact_pairs.rigid[a:b]
    )


@kernel
def solve_groups(contact, free, grouped, coupling, solved, changes, accuracy):
    """Solve for the impulses of each group.

    Parameters
    ----------
    grouped : (ContactPairs, (groups + 1,) int64)
        The pairs by group, and the first of each.
    changes : (2, pairs, IMPULSES) float64
        Scratch.
    contact, free, coupling, solved, accuracy
        See `solve_impulses`; the last has the sweeps and the tolerance.

    Returns
    -------
    int
        Sweeps of all groups.
    """
    (contact_pairs, first), sweeps = grouped, 0
    for g in range(len(first) - 1):
        a, b = first[g], first[g + 1]
        sweeps += solve_impulses(
            contact, free, _pairs_of(contact_pairs, a, b), coupling, solved, changes[:, a:b],
            accuracy[0], accuracy[1],
        )  # fmt: skip
    return sweeps


@kernel
def book_groups(contact, free, grouped, coupling, solved, values, walls, ledger):
    """Book what groups have exchanged, each in a plane of its own; see `book_contacts`.

    `grouped` is as of `solve_groups`.
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
