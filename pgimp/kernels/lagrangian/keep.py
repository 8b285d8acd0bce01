"""Velocity and displacement of vertices after a step; see `pgimp.kernels.data.motion`."""

from pgimp.jit.kernel import kernel, specialise
from pgimp.kernels.data import motion
from pgimp.kernels.data.record import MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size, is_used
from pgimp.kernels.grid.faces import face_count, is_beyond


@kernel
def recall_masses(field):
    """Set the masses of vertices that keep their motion, in place of sums of particles' masses."""
    G, window = field.G, field.window
    values, fields = field.motion
    plane, size = window.stride[0], field_size(window)
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for f in range(field_count(window)):
            if fields[f] and is_used(field, i, f):
                for r in range(i * plane + f * size, i * plane + (f + 1) * size, RECORD):
                    G[r + MASS] = values[r + motion.MASS]


@kernel
def keep_motion(field, dt):
    """Store the vertices' velocities after a step, and move them by it.

    Parameters
    ----------
    field : Field
        With the velocities after all conditions and contact.
    dt : float
        Length of the step.
    """
    G, window = field.G, field.window
    values, fields = field.motion
    plane, size = window.stride[0], field_size(window)
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for f in range(field_count(window)):
            if not (fields[f] and is_used(field, i, f)):
                continue
            for r in range(i * plane + f * size, i * plane + (f + 1) * size, RECORD):
                for d in range(3):
                    v = G[r + VELOCITY + d]
                    values[r + motion.VELOCITY + d] = v
                    values[r + motion.DISPLACEMENT + d] += dt * v


@kernel
def beyond_bounds(frame, field, bounds):
    """Whether a vertex with mass has moved past `bounds`, (D, 2): its particles may have, too."""
    G, window, values = field.G, field.window, field.motion.values
    plane = window.stride[0]
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for j in range(window.extent[1]):
            for k in range(window.extent[2]):
                number = (i, j, k)
                for f in range(field_count(window)):
                    r = i * plane + f * field_size(window)
                    r += j * window.stride[1] + k * window.stride[2]
                    if not G[r + MASS] > 0.0 or not is_used(field, i, f):
                        continue
                    for d in range(len(frame.origin)):
                        at = number[d] + window.lower[d] - frame.ghost
                        x = frame.origin[d] + at * frame.cell[d]
                        x += values[r + motion.DISPLACEMENT + d]
                        if not (bounds[d, 0] <= x <= bounds[d, 1]):
                            return True
    return False


def _constraint_of(marked, r, d):
    """Number of the first constraint that holds component `d` of the vertex at `r`, or -1."""


@specialise(_constraint_of)
def _constraint_at(marked, r, d):
    if len(marked) == 0:
        return lambda marked, r, d: -1

    def first(marked, r, d):
        constraints, mask = marked
        for k in range(len(constraints)):
            if mask[r // RECORD] >> k & 1 and constraints[k].held[d]:
                return k
        return -1

    return first


def _face_of(faces, frame, number):
    """Number of the first face that a vertex is on or beyond, or -1."""


@specialise(_face_of)
def _face_at(faces, frame, number):
    if len(faces) == 0:
        return lambda faces, frame, number: -1

    def first(faces, frame, number):
        for n in range(face_count(faces)):
            if is_beyond(faces, n, frame, number):
                return n
        return -1

    return first


@kernel
def book_jumps(frame, faces, field, forcing, ledger):
    """Book the jumps of kept velocities to what conditions prescribe, as a stage begins.

    Parameters
    ----------
    frame, faces
        See `update_momentum`.
    field : Field
        With the velocities after all conditions; the motion has the velocities before.
    forcing : Forcing
        With the constraints.
    ledger : Ledger
        Impulses of faces and constraints grow by mass times jump, work by that times velocity.
    """
    G, window, values = field.G, field.window, field.motion.values
    plane, size = window.stride[0], field_size(window)
    for i in range(min(field.owned, len(field.active))):
        if field.active[i] == 0:
            continue
        for f in range(field_count(window)):
            if not (field.motion.fields[f] and is_used(field, i, f)):
                continue
            for j in range(window.extent[1]):
                for k in range(window.extent[2]):
                    r = i * plane + f * size + j * window.stride[1] + k * window.stride[2]
                    m = G[r + MASS]
                    if not m > 0.0:
                        continue
                    number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                    n = _face_of(faces, frame, number)
                    for d in range(3):
                        v = G[r + VELOCITY + d]
                        change = m * (v - values[r + motion.VELOCITY + d])
                        if change == 0.0:
                            continue
                        one = _constraint_of(forcing.marked, r, d)
                        if one >= 0:
                            ledger.constraint_impulse[i, one, d] += change
                        elif n >= 0:
                            ledger.impulse[i, n, d] += change
                        ledger.work[i] += change * v
