"""Damping of the vertices: forces against their velocities, before contact, faces and constraints.

Mass-proportional damping is integrated exactly over a step, with the step's other forces: of
dv/dt = f/m - c v is left exp(-c dt) v + (1 - exp(-c dt))/c f/m. Local damping (Cundall) reduces the
unbalanced force by a part of it, component by component, against the velocity; a motion with
balanced forces, as steady flow, is not damped. What a face or a constraint holds stays held.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.ledger import DAMPED_ENERGY, KINETIC_BEFORE, KINETIC_NOW
from pgimp.kernels.data.motion import keeps, velocity_before
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size


class DampingForces(NamedTuple):
    """Damping in one step.

    Attributes
    ----------
    lost : float
        Part of the velocity that mass-proportional damping takes, 1 - exp(-c dt).
    used : float
        Part of the other forces that is left by it, (1 - exp(-c dt))/(c dt).
    local : float
        Part of the unbalanced force that local damping takes.
    impulse : (3 * vertices,) float64
        The vertices' impulses by damping, set where the mass is above the cutoff.
    """

    lost: float
    used: float
    local: float
    impulse: FloatArray


@kernel
def damp_forces(field, forcing, damping):
    """Add the damping's forces to the sums of a rank's active planes.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`, before it.
    damping : DampingForces
        The damping; its impulses are set.
    """
    G, window, dt = field.G, field.window, forcing.dt
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for f in range(field_count(window)):
            kept = (field.motion, keeps(field.motion, f))
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    if G[r + MASS] > forcing.mass_cutoff:
                        _damp(G, kept, r, dt, forcing.gravity, damping)


@inner_kernel
def _damp(G, kept, r, dt, gravity, damping):
    """Damp the vertex at `r`; `kept` is the vertices' motion, and whether they keep it."""
    m, at = G[r + MASS], r // RECORD * 3
    inverse = 1.0 / m
    for d in range(3):
        v = velocity_before(*kept, G, r, d, inverse)
        unbalanced = G[r + FORCE + d] + m * gravity[d]
        left = unbalanced
        if v > 0.0:
            left -= damping.local * abs(unbalanced)
        elif v < 0.0:
            left += damping.local * abs(unbalanced)
        force = damping.used * left - unbalanced - damping.lost / dt * (m * v)
        damping.impulse[at + d] = dt * force
        G[r + FORCE + d] += force


@kernel
def book_damping(field, forcing, damping, ledger):
    """Book the energy that the damping's forces took: impulse times mean velocity in the step.

    Parameters
    ----------
    field, forcing, damping
        As in `damp_forces`; the field has the velocities after all conditions and contact. The
        mean of a velocity that a face holds is that velocity, whatever particles bring there.
    ledger : Ledger
        `damping` grows.
    """
    G, window, dt = field.G, field.window, forcing.dt
    for i in range(field.owned):
        if field.active[i] == 0:
            continue
        taken = 0.0
        for f in range(field_count(window)):
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    if not G[r + MASS] > forcing.mass_cutoff:
                        continue
                    at = r // RECORD * 3
                    for d in range(3):
                        mean = G[r + VELOCITY + d] - 0.5 * dt * G[r + ACCELERATION + d]
                        taken -= damping.impulse[at + d] * mean
        ledger.damping[i, DAMPED_ENERGY] += taken


@kernel
def note_kinetic_energy(field, ledger):
    """Set the kinetic energy of the vertices by plane, at the end of this step and of the last."""
    G, window = field.G, field.window
    for i in range(field.owned):
        ledger.damping[i, KINETIC_BEFORE] = ledger.damping[i, KINETIC_NOW]
        total = 0.0
        for f in range(field_count(window)) if field.active[i] != 0 else range(0):
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    m, v = G[r + MASS], r + VELOCITY
                    if m > 0.0:
                        total += 0.5 * m * (G[v] ** 2 + G[v + 1] ** 2 + G[v + 2] ** 2)
        ledger.damping[i, KINETIC_NOW] = total
