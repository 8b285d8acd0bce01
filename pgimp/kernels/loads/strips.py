"""Weights along the radius of loads on surfaces of rings: strips that weigh with their radius.

A strip of half-width h about the radius m has its centroid at m + h^2/(3 m): m follows from it. Its
weights are s0 + s1/m, as in `pgimp.kernels.transfer.rings`, with the mean s0 and the first moment
s1 of a tent over it. Their sum is one and their mean radius that of the centroid. Where a part is
the whole side of a ring, its weights are those of the ring: level ground then stays at rest.
"""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.jit.tuples import plus_scaled
from pgimp.kernels.loads.tractions import means

#: Half-width, or radius, in cells below which it counts as none.
_NEAR = 1e-9


@inner_kernel
def _middle(centroid, half):
    """Middle radius of a strip of a half-width with a centroid, in cells."""
    return 0.5 * (centroid + sqrt(max(centroid * centroid - half * half * (4.0 / 3.0), 0.0)))


@inner_kernel
def _kink(half, f):
    """Mean of max(x, 0) (x - f) over a box of a half-width about f."""
    if f >= half:
        return half * half * (1.0 / 3.0)
    if f <= -half or half < _NEAR:
        return 0.0
    a = f + half
    return (a * a * a * (1.0 / 3.0) - 0.5 * f * a * a) * (0.5 / half)


@inlined
def _moments(half, f, like):
    """First moments of the tents of vertices 0, 1, ... over a box of a half-width about f."""
    if len(like) == 0:
        return ()
    return (
        _kink(half, f + 1.0) - 2.0 * _kink(half, f) + _kink(half, f - 1.0),
        *_moments(half, f - 1.0, like[1:]),
    )


@inner_kernel
def strip_weights(load, frame, x, part, own, vertex, like):
    """Weights of the support's vertices along the radius, of a part of particles at `x`.

    See `pgimp.kernels.loads.surfaces` for the arguments.
    """
    (c, N), inverse = part, frame.inverse[0]
    square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
    across = 1.0 - N[0] * N[0] / square if square > 0.0 else 1.0
    r = x * inverse
    centroid = max(r + c[0] * inverse, 0.0)
    half = load.half[0] * sqrt(max(across, 0.0)) * inverse
    half = min(half, own, 0.75 * centroid)  # then it ends at the axis
    off = min(max(_middle(centroid, half) - r, -own), own)
    half = min(half, own - abs(off), 0.5 * (len(like) - 1.0))
    f = (x - frame.origin[0]) * inverse - (vertex - frame.ghost)
    g = min(max(f + off, half), len(like) - 1.0 - half)
    by = 1.0 / max(r + g - f, _NEAR)
    return plus_scaled(by, _moments(half, g, like), means(False, False, half, g, like))
