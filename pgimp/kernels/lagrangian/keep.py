"""Velocity and displacement of vertices after a step; see `pgimp.kernels.data.motion`."""

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size, is_used


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
                    G[r + MASS] = values[r + KEPT_MASS]


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
                    values[r + KEPT_VELOCITY + d] = v
                    values[r + DISPLACEMENT + d] += dt * v


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
                        x += values[r + DISPLACEMENT + d]
                        if not (bounds[d, 0] <= x <= bounds[d, 1]):
                            return True
    return False
