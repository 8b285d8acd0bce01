"""Unbalanced forces of the vertices, for a run that comes to rest."""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.ledger import INTERNAL, KINETIC_BEFORE, KINETIC_NOW, UNBALANCED
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size


@kernel
def sum_internal_forces(field, forcing, ledger):
    """Set by plane the sum of the magnitudes of the forces before gravity and damping.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, before it.
    ledger : Ledger
        `damping` is set.
    """
    for i in range(field.owned):
        ledger.damping[i, INTERNAL] = plane_sum(field, i, forcing.mass_cutoff, _internal_force, 0.0)


@inner_kernel
def _internal_force(G, r, unused):
    h = r + FORCE
    return sqrt(G[h] ** 2 + G[h + 1] ** 2 + G[h + 2] ** 2)


@kernel
def sum_unbalanced_forces(field, forcing, ledger):
    """Set by plane the sum of the magnitudes of the unbalanced forces.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, with the accelerations after contact and all conditions. A
        component without any is held, or balanced.
    ledger : Ledger
        `damping` is set.
    """
    for i in range(field.owned):
        ledger.damping[i, UNBALANCED] = plane_sum(
            field, i, forcing.mass_cutoff, _unbalanced_force, 0.0
        )


@inner_kernel
def _unbalanced_force(G, r, unused):
    a = r + ACCELERATION
    return G[r + MASS] * sqrt(G[a] ** 2 + G[a + 1] ** 2 + G[a + 2] ** 2)


@kernel
def note_first_energy(field, forcing, ledger):
    """Set by plane the kinetic energy as this step began, and as the last one did.

    Arguments are as in `sum_unbalanced_forces`. A component that is held has no acceleration, and
    counts as it is.
    """
    for i in range(field.owned):
        ledger.damping[i, KINETIC_BEFORE] = ledger.damping[i, KINETIC_NOW]
        ledger.damping[i, KINETIC_NOW] = plane_sum(
            field, i, forcing.mass_cutoff, _first_energy, forcing.dt
        )


@inner_kernel
def _first_energy(G, r, dt):
    a, v = r + ACCELERATION, r + VELOCITY
    total = 0.0
    for d in range(3):
        total += (G[v + d] - dt * G[a + d]) ** 2
    return 0.5 * G[r + MASS] * total


@inner_kernel
def plane_sum(field, i, cutoff, value, arguments):
    """Sum of `value(G, r, arguments)` over the vertices of plane `i` with a mass above `cutoff`."""
    G, window = field.G, field.window
    total = 0.0
    for f in range(field_count(window)) if field.active[i] != 0 else range(0):
        first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
        while left:
            begin, end, left = next_rows(field, left)
            for r in range(
                first + begin * window.stride[1], first + end * window.stride[1], RECORD
            ):
                if G[r + MASS] > cutoff:
                    total += value(G, r, arguments)
    return total
