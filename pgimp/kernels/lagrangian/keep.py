"""Velocity and displacement of vertices after a step; see `pgimp.kernels.data.motion`."""

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.vectors.simd import lane, load, pack, store, vector, with_lane
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import is_used, use
from pgimp.kernels.data.velocity_fields import field_count, field_size


@inner_kernel
def begin_with_masses(field, i):
    """Set plane `i` to its vertices' own masses, without momentum and force."""
    G, plane, values, zero = field.G, field.window.stride[0], field.motion.values, vector(0.0)
    for r in range(i * plane, (i + 1) * plane, RECORD):
        store(G, r, pack(values[r + KEPT_MASS], 0.0, 0.0, 0.0))
        store(G, r + 4, zero)


@kernel
def recall_masses(field, between):
    """Set the masses of vertices that keep their motion, in place of sums of particles' masses.

    Planes from ``between[0]`` up to ``between[1]`` have them, see `begin_with_masses`.
    """
    G, window = field.G, field.window
    values, fields = field.motion
    plane, size = window.stride[0], field_size(window)
    for i in range(len(field.active)):
        if field.active[i] == 0 or between[0] <= i < between[1]:
            continue
        for f in range(field_count(window)):
            if fields[f] and is_used(field, i, f):
                for r in range(i * plane + f * size, i * plane + (f + 1) * size, RECORD):
                    G[r + MASS] = values[r + KEPT_MASS]
                use(field, i, f * size, (f + 1) * size)


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
                v = load(G, r + VELOCITY - 1)  # behind the mass
                u = load(values, r + DISPLACEMENT - 1)
                moved = pack(0.0, dt, dt, dt) * v + u
                store(values, r + DISPLACEMENT - 1, with_lane(moved, 0, lane(u, 0)))
                store(values, r + KEPT_VELOCITY - 1, with_lane(v, 0, 0.0))


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
