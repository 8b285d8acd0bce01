"""Reactions of faces and constraints to impulses of contact in the initial configuration.

An impulse is shared by all reference vertices in its row of B. Held vertices do not move: faces
and constraints bear their share, as for all forces there.
"""

from pgimp.jit.kernel import inner_kernel, kernel, specialise
from pgimp.kernels.contact.lagrangian.reference_grid import offset_of_key
from pgimp.kernels.data.record import ACCELERATION, MASS, RECORD, VELOCITY
from pgimp.kernels.grid.conditions import Holding, hold


@inner_kernel
def _book_faces(holding, number, r, u, b, lost, m):
    """Book the faces' share of `lost` at a vertex of mass m and velocity u; returns the rest.

    Impulses are linear in the mass, so that the faces' other reactions cancel in the books.
    """
    dt = holding.forcing.dt
    v, _ = hold(holding, number, r, u, b, -m)
    pushed = (u[0] + lost[0] / m, u[1] + lost[1] / m, u[2] + lost[2] / m)
    faster = (b[0] + lost[0] / (m * dt), b[1] + lost[1] / (m * dt), b[2] + lost[2] / (m * dt))
    w, _ = hold(holding, number, r, pushed, faster, m)
    return m * (w[0] - v[0]), m * (w[1] - v[1]), m * (w[2] - v[2])


def _book_constraints(marked, r, rest, impulse):
    """Book the share of the first constraint that holds a component."""


@specialise(_book_constraints)
def _book_each_constraint(marked, r, rest, impulse):
    if len(marked) == 0:
        return lambda marked, r, rest, impulse: None

    def book_each(marked, r, rest, impulse):
        constraints, mask = marked
        for d in range(3):
            for k in range(len(constraints)):
                if mask[r // RECORD] >> k & 1 and constraints[k].held[d]:
                    impulse[k, d] -= rest[d]
                    break

    return book_each


@kernel
def book_held(holding, field, changes, ledger):
    """Book the impulses on held components at the reference vertices that a rank owns.

    Parameters
    ----------
    holding : Holding
        Faces and constraints.
    field : Field
        After `change_velocities`: held components move as prescribed.
    changes : Changes
        The keys of vertices of all ranks, and the impulses on held components.
    ledger : Ledger
        Impulses grow by the shares, and work by the shares times the velocities there.
    """
    G, forcing = field.G, holding.forcing
    for n in range(len(changes.keys)):
        lost = (changes.held[n, 0], changes.held[n, 1], changes.held[n, 2])
        if lost[0] == 0.0 and lost[1] == 0.0 and lost[2] == 0.0:
            continue
        r, number = offset_of_key(holding.frame, field, changes.keys[n])
        i = number[0] - field.window.lower[0]
        if r < 0 or i >= field.owned or not G[r + MASS] > forcing.mass_cutoff:
            continue
        u = (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
        b = (G[r + ACCELERATION], G[r + ACCELERATION + 1], G[r + ACCELERATION + 2])
        own = Holding(holding.faces, holding.frame, forcing, ledger.impulse[i], holding.rate)
        rest = _book_faces(own, number, r, u, b, lost, G[r + MASS])
        _book_constraints(forcing.marked, r, rest, ledger.constraint_impulse[i])
        for d in range(3):
            ledger.work[i] -= lost[d] * u[d]
