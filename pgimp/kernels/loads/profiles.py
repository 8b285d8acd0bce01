"""Factors of loads on surfaces along a line: a table in a coordinate that moves.

The factor of a part is its mean over the length that the part covers along the line, about its
centroid. So parts side by side cover a table without gaps. Where the surface is straight the sum
of their forces is exact, wherever the table is between the particles.

In 2D a part covers what its area vector says, also where a body's end cuts it; rings likewise. In
3D it is the particle's width along the surface, in the direction that covers most. A part on an
edge has both of its faces at once: there the factor is right to a part of the particle's width.
"""

from math import pi, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.kernels.loads.tractions import columns
from pgimp.kernels.transfer.first_vertex import is_axial

#: Length, over the table's, below which a part is a point.
_POINT = 1e-9


@inner_kernel
def _first_after(rows, s):
    """Number of the first row whose coordinate is above `s`."""
    low, high = 0, len(rows)
    while low < high:
        middle = (low + high) // 2
        if rows[middle, 0] > s:
            high = middle
        else:
            low = middle + 1
    return low


@inner_kernel
def _between(rows, i, s):
    """Factor at `s` on the line from row i - 1 to row i."""
    part = (s - rows[i - 1, 0]) / (rows[i, 0] - rows[i - 1, 0])
    return rows[i - 1, 1] + part * (rows[i, 1] - rows[i - 1, 1])


@inner_kernel
def mean_factor(rows, outside, s, half):
    """Mean of a table's factors over the coordinates from s - half to s + half."""
    last = len(rows) - 1
    if last < 0:
        return 1.0
    if not half > _POINT * (rows[last, 0] - rows[0, 0]):
        if s < rows[0, 0]:
            return outside[0]
        if s > rows[last, 0]:
            return outside[1]
        return _between(rows, min(max(_first_after(rows, s), 1), last), s)
    low, high = s - half, s + half
    total = outside[0] * max(min(high, rows[0, 0]) - low, 0.0)
    total += outside[1] * max(high - max(low, rows[last, 0]), 0.0)
    for i in range(max(_first_after(rows, low), 1), last + 1):
        a, b = max(low, rows[i - 1, 0]), min(high, rows[i, 0])
        if not b > a:
            break
        total += (b - a) * _between(rows, i, 0.5 * (a + b))
    return total / (high - low)


@inner_kernel
def _half_line(a, C, N):
    """Half of the length that a straight part in the plane, of area vector N, covers along `a`."""
    ahead, across = a[0] * C[0][0] + a[1] * C[0][1], a[0] * C[1][0] + a[1] * C[1][1]
    return 0.5 * abs(N[0] * across - N[1] * ahead)


@inner_kernel
def _half_box(a, C, N, h):
    """Half of the length that a particle covers along `a` on a surface, with its row.

    Of its directions this is the one that covers most. So the particles of a row cover all of it
    once. `h` are the half-widths of the particle's box in the initial state.
    """
    square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
    inverse = 1.0 / square if square > 0.0 else 0.0
    half = 0.0
    for d in range(3):
        across = max(1.0 - N[d] * N[d] * inverse, 0.0)
        along = a[0] * C[d][0] + a[1] * C[d][1] + a[2] * C[d][2]
        half = max(half, abs(along) * h[d] * sqrt(across))
    return half


@inlined
def _half_length(profile, frame, C, N, radius):
    """Half of the length that a part covers along the line.

    `C` are the columns of F; `radius` is the current one of the centroid, in axisymmetry.
    """
    if len(frame.origin) == 3:
        return _half_box(profile.direction, C, N, profile.half)
    if not is_axial(frame):
        return _half_line(profile.direction, C, N)
    # The area is that of the whole ring, round the initial radius.
    part = C[2][2] / (2.0 * pi * radius) if radius > 0.0 else 0.0
    return part * _half_line(profile.direction, C, N)


@inlined
def profiled(profile, frame, at, F, part, f):
    """Return the force `f` on a part of a surface times the factor of its profile.

    Parameters
    ----------
    profile : Profile or ()
        See `pgimp.physics.loads.surfaces`.
    frame : Frame
        The grid.
    at : tuple of 3 float
        Current position of the particle.
    F : tuple of float
        Deformation gradient that the surface follows.
    part : (tuple of 3 float, tuple of 3 float)
        Centroid, from the particle, and area vector, in the initial state.
    f : tuple of 3 float
        The force.
    """
    if not is_record(profile):
        return f
    (c, N), a, C = part, profile.direction, columns(F)
    x = at[0] + C[0][0] * c[0] + C[1][0] * c[1] + C[2][0] * c[2]
    y = at[1] + C[0][1] * c[0] + C[1][1] * c[1] + C[2][1] * c[2]
    z = at[2] + C[0][2] * c[0] + C[1][2] * c[1] + C[2][2] * c[2]
    s = a[0] * x + a[1] * y + a[2] * z - profile.origin
    half = _half_length(profile, frame, C, N, x)
    factor = mean_factor(profile.rows, profile.outside, s, half)
    return factor * f[0], factor * f[1], factor * f[2]
