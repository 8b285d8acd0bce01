"""Reflection at a face of the sums beyond it (``wall: mirror``).

The vertices beyond the face add their sums to their mirror images before the momentum update. Mass,
tangential momentum and force add, the normal parts subtract. After it they get the reflection of
their images' velocity and acceleration, which the particles then gather. At a wall that holds every
direction (`fixed`) all parts subtract, so that the velocity on it is zero. With even tangential
motion a wide particle would slide by its part beyond the wall.

The grid thus moves under a constraint: velocities beyond the face are the reflection of velocities
within. So it conserves energy, and momentum up to the face's impulse. Particles gain the sum of
m a dt over all vertices. Let m' be the mass beyond the face, and f' the normal force there.
Reflection reverses both, so that the face's impulse is -2 (f' + m' a) dt, with the images' a. For
the relaxed part of the velocity (`relaxed`), and for vertices that keep their motion, it is
-2 (p' + f' dt + m' v) likewise.

Beyond an absorbing face nothing is reversed: what lies there moves as the face does (`follows`).
"""

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.data.images import (
    beyond_count,
    box_beyond,
    image_at,
    image_of,
    mark_of,
    offset_of,
    reverses,
)
from pgimp.kernels.data.motion import KEPT_VELOCITY, grid_rate, keeps, momentum_before
from pgimp.kernels.data.record import (
    ACCELERATION,
    CLEARANCE_SUM,
    FOLDED_MASS,
    FORCE,
    HELD,
    MASS,
    MOMENTUM,
    RECORD,
    VELOCITY,
)
from pgimp.kernels.data.used_rows import is_used, use
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.constraint_flags import also_held
from pgimp.kernels.loads.loads import given, relaxed_part
from pgimp.kernels.loads.wall_gap import clearance_at


@kernel
def fold(frame, field, mirror, forcing, ledger):
    """Add the sums beyond a face to the sums of the mirror images.

    A vertex beyond it then has a mark in place of its mass, see `mark_of`, which moves to
    `FOLDED_MASS`. `reflect` needs both; everywhere else the vertex has no mass.

    Parameters
    ----------
    frame, field, forcing, ledger
        As in `update_momentum`.
    mirror : Images
        The face, which is no seam.
    """
    window, G = field.window, field.G
    (i0, x), (j0, y), (k0, z) = box_beyond(frame, window, mirror)
    for f in range(field_count(window)):
        begin = f * field_size(window)
        rate, kept = grid_rate(forcing.loads.relaxation, field.motion, f), keeps(field.motion, f)
        part = relaxed_part(rate, forcing.dt)
        for i in range(i0, i0 + x):
            if not is_used(field, i, f):
                continue
            for j in range(j0, j0 + y):
                for k in range(k0, k0 + z):
                    if G[offset_of(window, begin, i, j, k) + MASS] > 0.0:
                        image = image_at(frame, field, mirror, begin, i, j, k)
                        _fold_vertex(field, mirror, forcing, ledger, image, part, kept)


@inner_kernel
def _fold_vertex(field, mirror, forcing, ledger, image, part, kept):
    """Add the sums of a vertex beyond the face to those of its mirror image."""
    window, G, owned, motion = field.window, field.G, field.owned, field.motion
    dt, gravity, impulse, axis = forcing.dt, forcing.gravity, ledger.impulse, mirror.axis
    i, g, r, wall = image
    if r < 0 or G[r + MASS] < 0.0:
        return
    if mirror.releases:
        push = G[wall + FORCE + axis] + G[wall + MASS] * gravity[axis]
        momentum = momentum_before(motion, kept, G, wall, axis)
        into = (momentum + dt * push) * mirror.side
        near = clearance_at(forcing.clearances, mirror.number, wall)
        gap_momentum = G[wall + MASS] * near / dt
        if not (G[wall + MASS] > 0.0 and into > gap_momentum):
            return
    # Gravity will act on all mass of the image alike, but on this part in reverse.
    for d in range(3):
        if not reverses(mirror, d):
            continue
        weight = G[g + MASS] * gravity[d]
        G[r + FORCE + d] -= 2.0 * weight
        if i < owned:
            force = G[g + FORCE + d] + weight
            momentum = momentum_before(motion, kept, G, g, d)
            impulse[i, mirror.number, d] -= 2.0 * dt * force + 2.0 * part * momentum
    # The image's plane now has this field.
    plane = r // window.stride[0]
    low = r - plane * window.stride[0]
    use(field, plane, low, low + RECORD)
    _join(motion, kept, mirror, G, g, r)
    G[r + MASS] += G[g + MASS]
    G[r + CLEARANCE_SUM] += G[g + CLEARANCE_SUM]
    for d in range(3):
        sign = -1.0 if reverses(mirror, d) else 1.0
        G[r + MOMENTUM + d] += sign * G[g + MOMENTUM + d]
        G[r + FORCE + d] += sign * G[g + FORCE + d]
    mass = G[g + MASS]
    for d in range(RECORD):
        G[g + d] = 0.0
    G[g + MASS] = mark_of(mirror)
    G[g + FOLDED_MASS] = mass


@inlined
def _join(motion, kept, mirror, G, g, r):
    """Give the image at `r` the mean velocity of it and of the vertex at `g`, where they keep it.

    The two differ as a run, a stage or contact with the face begins. Momentum is conserved.
    """
    if not is_record(motion):
        return None
    if not kept:
        return
    m, mass, values = G[r + MASS], G[g + MASS], motion.values
    for d in range(3):
        sign = -1.0 if reverses(mirror, d) else 1.0
        u, v = values[r + KEPT_VELOCITY + d], sign * values[g + KEPT_VELOCITY + d]
        if u != v:
            values[r + KEPT_VELOCITY + d] = u + mass / (m + mass) * (v - u)


@kernel
def reflect(frame, field, mirror, forcing, ledger):
    """Set velocity and acceleration beyond a face from the images, also of seams.

    Of several faces the last one that has folded reflects first.

    Parameters
    ----------
    frame, field, forcing, ledger
        As in `update_momentum`. It has booked gravity's work on the folded mass as if it moved with
        the images; reversed components move against them.
    mirror : Images
        The face, or the seam.
    """
    window, G = field.window, field.G
    (i0, x), (j0, y), (k0, z) = box_beyond(frame, window, mirror)
    for f in range(field_count(window)):
        begin = f * field_size(window)
        rate = grid_rate(forcing.loads.relaxation, field.motion, f)
        for i in range(i0, i0 + x):
            if field.active[i] == 0:
                continue
            for j in range(j0, j0 + y):
                for k in range(k0, k0 + z):
                    if G[offset_of(window, begin, i, j, k) + MASS] == mark_of(mirror):
                        image = image_at(frame, field, mirror, begin, i, j, k)
                        _reflect_vertex(field, mirror, forcing, ledger, image, rate, f)


@inner_kernel
def _reflect_vertex(field, mirror, forcing, ledger, image, rate, f):
    """Set velocity and acceleration of a vertex beyond the face from its image."""
    G, owned, axis = field.G, field.owned, mirror.axis
    dt, gravity, impulse, work = forcing.dt, forcing.gravity, ledger.impulse, ledger.work
    i, g, r, _ = image
    if r < 0:
        return
    twice = 2.0 * G[g + FOLDED_MASS]
    for d in range(3):
        if i < owned and reverses(mirror, d):
            v, a = G[r + VELOCITY + d], G[r + ACCELERATION + d]
            impulse[i, mirror.number, d] -= given(rate, twice, dt, 0.0, 0.0, v, a)
            work[i] -= twice * dt * gravity[d] * v
    if not mirror.follows:
        G[r + HELD] = also_held(G[r + HELD], axis)
    G[g + HELD] = G[r + HELD]
    if mirror.period > 0 or not keeps(field.motion, f):  # for the filled part of mean dilatation
        G[g + MASS] = G[r + MASS]
    for d in range(3):
        sign = -1.0 if reverses(mirror, d) else 1.0
        G[g + VELOCITY + d] = sign * G[r + VELOCITY + d]
        G[g + ACCELERATION + d] = sign * G[r + ACCELERATION + d]


@kernel
def fold_forces(frame, field, images, dt, ledger):
    """Add forces beyond a face, found since `fold` or `fold_values`, to those of the images.

    Parameters
    ----------
    frame, field
        As in `fold`.
    images : Images
        The face, or the seam.
    dt : float
        Length of the step.
    ledger : Ledger
        `impulse` grows by what the face takes of reversed components.
    """
    window, G = field.window, field.G
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for n in range(beyond_count(frame, window, images)):
            i, g, r, _ = image_of(frame, field, images, begin, n)
            if r < 0 or not is_used(field, i, f) or G[g + MASS] != mark_of(images):
                continue
            for d in range(3):
                force = G[g + FORCE + d]
                G[g + FORCE + d] = 0.0
                if reverses(images, d):
                    if i < field.owned:
                        ledger.impulse[i, images.number, d] -= 2.0 * dt * force
                    force = -force
                G[r + FORCE + d] += force
