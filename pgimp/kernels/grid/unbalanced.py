"""Unbalanced forces of the vertices, for a run that comes to rest."""

from math import sqrt

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.ledger import INTERNAL, UNBALANCED
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, RECORD
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
    G, window = field.G, field.window
    for i in range(field.owned):
        ledger.damping[i, INTERNAL] = 0.0
        if field.active[i] == 0:
            continue
        total = 0.0
        for f in range(field_count(window)):
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    if G[r + MASS] > forcing.mass_cutoff:
                        h = r + FORCE
                        total += sqrt(G[h] ** 2 + G[h + 1] ** 2 + G[h + 2] ** 2)
        ledger.damping[i, INTERNAL] = total


@kernel
def sum_unbalanced_forces(field, forcing, impulse, ledger):
    """Set by plane the sum of the magnitudes of the unbalanced forces, without those of damping.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, with the accelerations after contact and all conditions. A
        component without any is held, or balanced.
    impulse : (3 * vertices,) float64
        Impulses of damping, see `DampingForces`; empty without any.
    ledger : Ledger
        `damping` is set.
    """
    G, window, damped = field.G, field.window, len(impulse) > 0
    for i in range(field.owned):
        ledger.damping[i, UNBALANCED] = 0.0
        if field.active[i] == 0:
            continue
        total = 0.0
        for f in range(field_count(window)):
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    if not G[r + MASS] > forcing.mass_cutoff:
                        continue
                    square = 0.0
                    for d in range(3):
                        force = G[r + MASS] * G[r + ACCELERATION + d]
                        if damped and force != 0.0:
                            force -= impulse[r // RECORD * 3 + d] / forcing.dt
                        square += force * force
                    total += sqrt(square)
        ledger.damping[i, UNBALANCED] = total
