"""Reflection at a face of what particles carry beyond it (``wall: mirror``).

The vertices beyond the face hand their sums to their mirror images before the momentum update:
mass, tangential momentum and force add, the normal parts subtract. After it they get the
reflection of their images' velocity and acceleration, which the particles then gather.
"""

from pgimp.kernels.jit import kernel


@kernel
def fold(frame, window, G, active, axis, side):
    """Add the sums beyond a face to those of the mirror images; leaves zeros beyond."""
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for j in range(window.extent[1]):
            for k in range(window.extent[2]):
                g, r = _pair(frame, window, active, axis, side, i, j, k)
                if r < 0:
                    continue
                G[r] += G[g]
                for d in range(3):
                    sign = -1.0 if d == axis else 1.0
                    G[r + 1 + d] += sign * G[g + 1 + d]
                    G[r + 5 + d] += sign * G[g + 5 + d]
                for d in range(8):
                    G[g + d] = 0.0


@kernel
def reflect(frame, window, G, active, axis, side):
    """Set velocity and acceleration beyond a face from the mirror images."""
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for j in range(window.extent[1]):
            for k in range(window.extent[2]):
                g, r = _pair(frame, window, active, axis, side, i, j, k)
                if r < 0:
                    continue
                for d in range(3):
                    sign = -1.0 if d == axis else 1.0
                    G[g + 1 + d] = sign * G[r + 1 + d]
                    G[g + 5 + d] = sign * G[r + 5 + d]


@kernel
def _pair(frame, window, active, axis, side, i, j, k):
    """Places of a vertex beyond the face and of its mirror image; -1 for other vertices."""
    number = window.lower[axis] + (i if axis == 0 else (j if axis == 1 else k))
    wall = frame.ghost if side < 0 else frame.ghost + frame.cells[axis]
    beyond = (number - wall) * side
    if beyond <= 0:
        return -1, -1
    shift = -2 * beyond * side
    image = number - window.lower[axis] + shift
    if image < 0 or image >= window.extent[axis]:
        return -1, -1
    if axis == 0 and active[image] == 0:
        return -1, -1
    place = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
    return place, place + shift * window.stride[axis]
