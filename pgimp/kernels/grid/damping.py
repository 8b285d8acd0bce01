"""Damping of the vertices: forces against their velocities, before contact, faces and constraints.

Mass-proportional damping leaves exp(-c dt) of the velocity that a vertex has as a step begins.
Local damping (Cundall) reduces the unbalanced force by a part of it, component by component,
against the velocity; a motion with balanced forces, as steady flow, is not damped. A component that
a face or a constraint holds is balanced by it, and has no local damping: the reaction stays what it
is.

Velocities are half a step away from places (leapfrog), so that motion from rest begins with half a
kick. A whole one multiplies short waves by 1 - (omega dt)^2, so that with repeated stops half of
the stable step is the longest.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.ledger import DAMPED_ENERGY, DAMPED_MOMENTUM, KINETIC_BEFORE, KINETIC_NOW
from pgimp.kernels.data.motion import grid_rate, keeps, velocity_before
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.conditions import Holding, hold
from pgimp.kernels.grid.constraints import constrained_velocity
from pgimp.kernels.grid.unbalanced import plane_sum


class DampingForces(NamedTuple):
    """Damping in one step."""

    lost: float  #: Part of the velocity that mass-proportional damping takes, 1 - exp(-c dt).
    local: float  #: Part of the unbalanced force that local damping takes.
    #: (3 * vertices,) float64: The vertices' impulses by damping, set where the mass is above the
    #: cutoff.
    impulse: FloatArray
    scratch: FloatArray  #: (faces, 3) float64: For impulses of faces, which are not booked.


@kernel
def damp_forces(frame, field, faces, forcing, damping):
    """Add the damping's forces to the sums of a rank's active planes.

    Parameters
    ----------
    frame, field, faces, forcing
        As in `update_momentum`, before it.
    damping : DampingForces
        The damping; its impulses are set.
    """
    G, window, rate = field.G, field.window, forcing.loads.relaxation
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for f in range(field_count(window)):
            kept = (field.motion, keeps(field.motion, f))
            holding = Holding(
                faces, frame, forcing, damping.scratch, grid_rate(rate, field.motion, f)
            )
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for j in range(begin, end):
                    for k in range(window.extent[2]):
                        r = first + j * window.stride[1] + k * window.stride[2]
                        number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                        if G[r + MASS] > forcing.mass_cutoff:
                            _damp(G, kept, holding, number, r, damping)


@inner_kernel
def _damp(G, kept, holding, number, r, damping):
    """Damp the vertex at `r`; `kept` is the vertices' motion, and whether they keep it."""
    m, at, dt = G[r + MASS], r // RECORD * 3, holding.forcing.dt
    inverse, g = 1.0 / m, holding.forcing.gravity
    v = tuple(velocity_before(*kept, G, r, d, inverse) for d in range(3))
    b = tuple(G[r + FORCE + d] * inverse + g[d] for d in range(3))
    local = tuple(damping.local for _ in range(3))
    if damping.local > 0.0:
        u = (v[0] + dt * b[0], v[1] + dt * b[1], v[2] + dt * b[2])
        w, a = hold(holding, number, r, u, b, 0.0)
        w = constrained_velocity(holding.forcing.marked, r, w)
        free = tuple(w[d] == u[d] and a[d] == b[d] for d in range(3))
        local = tuple(damping.local if each else 0.0 for each in free)
    for d in range(3):
        force = -damping.lost / dt * (m * v[d])
        if v[d] > 0.0:
            force -= local[d] * abs(m * b[d])
        elif v[d] < 0.0:
            force += local[d] * abs(m * b[d])
        damping.impulse[at + d] = dt * force
        G[r + FORCE + d] += force


@kernel
def book_damping(field, forcing, damping, ledger):
    """Book energy and momentum that the damping's forces took; energy by the step's mean velocity.

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
        taken, px, py, pz = 0.0, 0.0, 0.0, 0.0
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
                    px -= damping.impulse[at]
                    py -= damping.impulse[at + 1]
                    pz -= damping.impulse[at + 2]
        ledger.damping[i, DAMPED_ENERGY] += taken
        ledger.damping[i, DAMPED_MOMENTUM] += px
        ledger.damping[i, DAMPED_MOMENTUM + 1] += py
        ledger.damping[i, DAMPED_MOMENTUM + 2] += pz


@kernel
def relax(field, forcing, n, ledger):
    """Damp the `n`-th step from rest: 2/(n + 1) of the step's mean velocity is taken, in the mean.

    Of the velocity before and of the kick (n - 1)/(n + 1) and n/(n + 1) stay. Contact and all
    conditions keep the forces that they had without.

    Parameters
    ----------
    field, forcing
        As in `book_damping`. Components that are held have no acceleration, and stay.
    n : int
        Number of the step since all bodies were at rest, from 1.
    ledger : Ledger
        `damping` grows by the energy and momentum taken. `work` of gravity follows the velocities.
    """
    G, window, dt, g = field.G, field.window, forcing.dt, forcing.gravity
    for i in range(len(field.active)):
        taken, px, py, pz = 0.0, 0.0, 0.0, 0.0
        for f in range(field_count(window)) if field.active[i] != 0 else range(0):
            first, left = i * window.stride[0] + f * field_size(window), used_rows(field, i, f)
            while left:
                begin, end, left = next_rows(field, left)
                for r in range(
                    first + begin * window.stride[1], first + end * window.stride[1], RECORD
                ):
                    m = G[r + MASS]
                    if m > forcing.mass_cutoff:
                        x, ex = _relax(G, r, dt, n)
                        y, ey = _relax(G, r + 1, dt, n)
                        z, ez = _relax(G, r + 2, dt, n)
                        px, py, pz = px + m * x, py + m * y, pz + m * z
                        taken += m * (ex + ey + ez)
        if i < field.owned:
            ledger.damping[i, DAMPED_ENERGY] += taken
            ledger.damping[i, DAMPED_MOMENTUM] += px
            ledger.damping[i, DAMPED_MOMENTUM + 1] += py
            ledger.damping[i, DAMPED_MOMENTUM + 2] += pz
            ledger.work[i] -= dt * (g[0] * px + g[1] * py + g[2] * pz)


@inner_kernel
def _relax(G, r, dt, n):
    """Damp a component; return the velocity taken, and the work done against it, by mass."""
    a, v = G[r + ACCELERATION], G[r + VELOCITY]
    if a == 0.0:
        return 0.0, 0.0
    change = (2.0 * v - dt * a) / (n + 1.0)
    G[r + VELOCITY] = v - change
    G[r + ACCELERATION] = a - change / dt
    return change, change * (v - change)


@kernel
def note_kinetic_energy(field, ledger):
    """Set the kinetic energy of the vertices by plane, at the end of this step and of the last."""
    for i in range(field.owned):
        ledger.damping[i, KINETIC_BEFORE] = ledger.damping[i, KINETIC_NOW]
        ledger.damping[i, KINETIC_NOW] = plane_sum(field, i, 0.0, _kinetic_energy, 0.0)


@inner_kernel
def _kinetic_energy(G, r, unused):
    v = r + VELOCITY
    return 0.5 * G[r + MASS] * (G[v] ** 2 + G[v + 1] ** 2 + G[v + 2] ** 2)
