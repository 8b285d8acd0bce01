"""Momentum update (14) of the vertices, boundary conditions, and what the faces do."""

from pgimp.boundaries.base import constrain
from pgimp.kernels.jit import kernel, specialise


@kernel
def update_momentum(frame, window, G, active, dt, gravity, lightest, faces, owned, impulse, work):
    """Turn the sums of a rank's active planes into velocities and accelerations.

    Parameters
    ----------
    gravity : tuple of 3 float
        Body force per mass b, taken at the step's beginning.
    lightest : float
        A vertex that is not heavier gets v = a = 0.
    faces : tuple
        Parameters of the boundary conditions, see `pgimp.boundaries`.
    owned : int
        Number of planes, from the first, whose sums this rank accounts for.
    impulse : (planes, faces, 3) float64
        Grows by the momentum that each face gives to the material.
    work : (planes,) float64
        Grows by the work of gravity and of moving faces: force times displacement, so that a
        constant gravity's work is the weight times the way of the centre of mass. Kinetic energy
        differs from that by an amount of order dt, also in free fall.
    """
    plane = window.stride[0]
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, 8):
            m = G[r]
            if m > lightest:
                inverse = 1.0 / m
                for d in range(3):
                    a = G[r + 5 + d] * inverse + gravity[d]
                    G[r + 5 + d] = a
                    G[r + 1 + d] = G[r + 1 + d] * inverse + dt * a
            else:
                for d in range(1, 8):
                    G[r + d] = 0.0
        constrain_plane(faces, 0, frame, window, G, i, dt, lightest, i < owned, impulse, work)
        if heavy and i < owned:
            power = 0.0
            for r in range(i * plane, (i + 1) * plane, 8):
                b_v = gravity[0] * G[r + 1] + gravity[1] * G[r + 2] + gravity[2] * G[r + 3]
                power += G[r] * b_v
            work[i] += dt * power


def constrain_plane(faces, n, frame, window, G, i, dt, lightest, owned, impulse, work):
    """Apply the conditions of all faces to plane `i`; `n` numbers the first of `faces`."""


@specialise(constrain_plane)
def _constrain_plane(faces, n, frame, window, G, i, dt, lightest, owned, impulse, work):
    if len(faces) == 0:
        return lambda faces, n, frame, window, G, i, dt, lightest, owned, impulse, work: None

    def constrain_all(faces, n, frame, window, G, i, dt, lightest, owned, impulse, work):
        _constrain_face(faces[0], n, frame, window, G, i, dt, lightest, owned, impulse, work)
        constrain_plane(faces[1:], n + 1, frame, window, G, i, dt, lightest, owned, impulse, work)

    return constrain_all


@kernel
def _constrain_face(face, n, frame, window, G, i, dt, lightest, owned, impulse, work):
    """Apply one face's condition to the vertices of plane `i` on the face and beyond it.

    The momentum that the particles gain in a step is the sum of m a dt (28), so the face's part
    of it is m times what the condition changes a by.
    """
    wall = frame.ghost if face.side < 0 else frame.ghost + frame.cells[face.axis]
    j0, j1 = 0, window.extent[1]
    k0, k1 = 0, window.extent[2]
    if face.axis == 0:
        number = i + window.lower[0]
        if (face.side < 0 and number > wall) or (face.side > 0 and number < wall):
            return
    elif face.axis == 1:
        if face.side < 0:
            j1 = min(j1, wall - window.lower[1] + 1)
        else:
            j0 = max(j0, wall - window.lower[1])
    elif face.side < 0:
        k1 = min(k1, wall - window.lower[2] + 1)
    else:
        k0 = max(k0, wall - window.lower[2])
    px, py, pz, power = 0.0, 0.0, 0.0, 0.0
    for j in range(j0, j1):
        for k in range(k0, k1):
            r = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
            m = G[r]
            if not m > lightest:
                continue
            a = (G[r + 5], G[r + 6], G[r + 7])
            v, c = constrain(face, (G[r + 1], G[r + 2], G[r + 3]), a)
            fx, fy, fz = m * (c[0] - a[0]), m * (c[1] - a[1]), m * (c[2] - a[2])
            px += fx
            py += fy
            pz += fz
            power += fx * v[0] + fy * v[1] + fz * v[2]
            G[r + 1], G[r + 2], G[r + 3] = v
            G[r + 5], G[r + 6], G[r + 7] = c
    if owned:
        impulse[i, n, 0] += dt * px
        impulse[i, n, 1] += dt * py
        impulse[i, n, 2] += dt * pz
        work[i] += dt * power
