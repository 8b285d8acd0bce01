"""Velocity and displacement of vertices after a step; see `pgimp.kernels.data.motion`."""

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size, is_used


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
                    values[r + VELOCITY + d] = v
                    values[r + DISPLACEMENT + d] += dt * v
