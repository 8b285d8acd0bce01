"""Absorbing faces: dashpots by which waves leave, and the force that holds what is at rest.

A vertex on a face has the mass m = rho h A/2 of half a cell behind the area A that material covers.
The dashpots of Lysmer and Kuhlemeyer (1969), rho c A v with the speed c of compressional waves
across the face and of shear waves along it, are r m v, r = 2 c/h. They act on the mean velocity of
the step, implicitly, so that no step is too long: with the velocity u at its beginning and the
acceleration a by all other forces,

    f = -m r (u + a dt/2)/(1 + r dt/2).

Ground that sinks brings more mass beyond the face, and ground that rises leaves less on it, but the
area stays: m is the mass when the face began to absorb, as long as there is any. Fields share it.

The static force is minus the force on the vertex when the face began to absorb. It is constant, and
shared out by mass to the vertex's fields. Both act before contact, other faces and constraints.
Where a stage removes bodies both become less, as the mass that is left.
"""

from typing import NamedTuple

from pgimp.jit.kernel import exact, inner_kernel, kernel
from pgimp.kernels.data.ledger import WALL_LOSS
from pgimp.kernels.data.motion import keeps, velocity_before
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: Numbers of a vertex in `AbsorbingFace.values`: static force, mass when it was found, wave speeds.
REACTION, REACTION_MASS, PRESSURE_WAVE, SHEAR_WAVE, NUMBERS = 0, 3, 4, 5, 6


class AbsorbingFace(NamedTuple):
    """A face that absorbs."""

    #: axis, side, number: As in `Images`.
    axis: int
    side: int
    number: int
    wall: int  #: Number of the vertices on it along its axis.
    #: lower, extent: (3,) int64: A box of vertices, which has those on the face and beyond it that
    #: had mass: the first one, and their number by direction.
    lower: IntArray
    extent: IntArray
    #: (vertices + 1, NUMBERS) float64: Its vertices, row by row; the last row is of all others.
    values: FloatArray
    #: Number of the first plane that is another copy of one inside, and the planes of the ring
    #: along x; 0 without periodic faces there.
    ring: tuple[int, int]


@inner_kernel
def _at(face, window, i, j, k):
    """Row of a window's vertex in `AbsorbingFace.values`."""
    row, first = 0, i + window.lower[0]
    if face.ring[1] > 0 and first >= face.ring[0]:
        first -= face.ring[1]
    number = (first, j + window.lower[1], k + window.lower[2])
    for d in range(3):
        n = number[d] - face.lower[d]
        if not 0 <= n < face.extent[d]:
            return len(face.values) - 1
        row = row * face.extent[d] + n
    return row


@inner_kernel
def _vertices(window, face, d):
    """Range along direction `d` of the window's vertices on the face or beyond it."""
    if d != face.axis:
        return 0, window.extent[d]
    at = face.wall - window.lower[d]
    if face.side < 0:
        return 0, min(window.extent[d], at + 1)
    return max(0, at), window.extent[d]


@inner_kernel
def _parts(field, first, cutoff, mass):
    """Static force by mass, and part of the mass that dashpots act on.

    One is over the mass at the vertex. The other is the `mass` of the start over that, of vertices
    that had none then 1. `first` is the vertex's record in the first field.
    """
    total = 0.0
    for f in range(field_count(field.window)):
        m = field.G[first + f * field_size(field.window) + MASS]
        if m > cutoff:
            total += m
    if not total > 0.0:
        return 0.0, 1.0
    return 1.0 / total, mass / total if mass > 0.0 else 1.0


@exact  # all ranks that store a vertex must find the same force
def _static_force(reaction, m, part):
    """Part of the static force of a vertex on a field of mass m, see `_parts`."""
    return reaction * (m * part)


@exact
def _acceleration(force, inverse, gravity):
    """Acceleration by a force, and gravity; `inverse` is 1 over the mass."""
    return force * inverse + gravity


@exact
def _dashpot(m, rate, u, a, dt):
    """Force of the dashpots at the rate r on a mass m with the velocity u and acceleration a."""
    return -m * rate * (u + 0.5 * dt * a) / (1.0 + 0.5 * rate * dt)


@kernel
def absorb(frame, field, forcing, face, impulse, ledger, moving):
    """Add forces of an absorbing face to the sums of a rank's active planes.

    First the static forces of all faces, then their dashpots: these see all other forces.

    Parameters
    ----------
    frame, field, forcing
        As in `update_momentum`, before it.
    face
        AbsorbingFace.
    impulse : (3 * vertices,) float64
        Set to the impulses of the dashpots.
    ledger : Ledger
        `impulse` grows.
    moving : bool
        Whether to add the forces of the dashpots, or the static forces.
    """
    known = face.values
    window, G, dt, g = field.window, field.G, forcing.dt, forcing.gravity
    inverse_h = frame.inverse[face.axis]
    i0, i1 = _vertices(window, face, 0)
    j0, j1 = _vertices(window, face, 1)
    k0, k1 = _vertices(window, face, 2)
    for i in range(i0, i1):
        if field.active[i] == 0:
            continue
        for j in range(j0, j1):
            for k in range(k0, k1):
                first = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
                at = _at(face, window, i, j, k)
                part, damped = _parts(field, first, forcing.mass_cutoff, known[at, REACTION_MASS])
                for f in range(field_count(window)):
                    r = first + f * field_size(window)
                    m = G[r + MASS]
                    if not m > forcing.mass_cutoff:
                        continue
                    inverse, kept = 1.0 / m, keeps(field.motion, f)
                    for d in range(3):
                        force = _static_force(known[at, REACTION + d], m, part)
                        if moving:
                            speed = known[at, PRESSURE_WAVE if d == face.axis else SHEAR_WAVE]
                            u = velocity_before(field.motion, kept, G, r, d, inverse)
                            a = _acceleration(G[r + FORCE + d], inverse, g[d])
                            force = _dashpot(m, 2.0 * speed * inverse_h * damped, u, a, dt)
                            impulse[r // RECORD * 3 + d] = dt * force
                        G[r + FORCE + d] += force
                        if i < field.owned:
                            ledger.impulse[i, face.number, d] += dt * force


@kernel
def book_absorbed(field, forcing, face, impulse, ledger):
    """Book the energy that left through an absorbing face, and the work of its static force.

    Parameters
    ----------
    field, forcing, face, impulse
        As in `absorb`; the field has the velocities after all conditions and contact.
    ledger : Ledger
        `wall_energy` grows by what dashpots took, force times mean velocity; `work` by the work of
        the static force, as by that of gravity.
    """
    known = face.values
    window, G, dt = field.window, field.G, forcing.dt
    i0, i1 = _vertices(window, face, 0)
    j0, j1 = _vertices(window, face, 1)
    k0, k1 = _vertices(window, face, 2)
    for i in range(i0, min(i1, field.owned)):
        if field.active[i] == 0:
            continue
        work, radiated = 0.0, 0.0
        for j in range(j0, j1):
            for k in range(k0, k1):
                first = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
                at = _at(face, window, i, j, k)
                part, _ = _parts(field, first, forcing.mass_cutoff, known[at, REACTION_MASS])
                for f in range(field_count(window)):
                    r = first + f * field_size(window)
                    if not G[r + MASS] > forcing.mass_cutoff:
                        continue
                    for d in range(3):
                        v = G[r + VELOCITY + d]
                        work += dt * known[at, REACTION + d] * (G[r + MASS] * part) * v
                        mean = v - 0.5 * dt * G[r + ACCELERATION + d]
                        radiated -= impulse[r // RECORD * 3 + d] * mean
        ledger.work[i] += work
        ledger.wall_energy[i, face.number, WALL_LOSS] += radiated
