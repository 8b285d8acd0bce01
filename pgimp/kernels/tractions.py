"""Surface tractions (18): forces on faces of boxes, carried by the particles along the face.

A particle at the face carries a patch of it: its area in the initial state and its distance from
the particle's centre. The patch moves, stretches and turns with the particle; its force goes to the
vertices by the integral of S_v over the patch, replaced by the mean over the box along the grid
with the patch's second moments. In equilibrium that cancels the internal force (16) at the vertices
just beyond the surface, however light they are.
"""

from math import sqrt
from typing import NamedTuple

from pgimp.kernels.jit import kernel, specialise
from pgimp.kernels.simd import lane, pack
from pgimp.kernels.transfer import deformation, first_vertex, gather, half_widths, scatter

#: Least half-width of a patch in cells: below, the mean would lose digits.
THINNEST = 1e-4


class Traction(NamedTuple):
    """One traction during one step.

    Attributes
    ----------
    axis, side : int
        The box's face: its normal in the initial state is `side` times the unit vector `axis`.
    column : int
        Columns `column` (area) and `column` + 1 (distance along the axis) of ``particles.patch``.
    half : tuple of float
        Half the spacing of the particles by direction; zeros for points.
    follows : bool
        Whether patches follow the deformation gradient, as the particles of the shape do.
    traction : tuple of 3 float
        Force per current area.
    pressure : float
        Force per current area against the current normal.
    """

    axis: int
    side: int
    column: int
    half: tuple[float, ...]
    follows: bool
    traction: tuple[float, float, float]
    pressure: float


def columns(F):
    """Columns of the deformation gradient as vectors of three; 1 in directions that are missing."""


@specialise(columns)
def _columns(F):
    if len(F) == 1:
        return lambda F: ((F[0], 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    if len(F) == 4:
        return lambda F: ((F[0], F[2], 0.0), (F[1], F[3], 0.0), (0.0, 0.0, 1.0))
    return lambda F: ((F[0], F[3], F[6]), (F[1], F[4], F[7]), (F[2], F[5], F[8]))


@kernel
def patch_force(traction, F, area):
    """Force on a patch: per area, with the area vector J F^-T N A by Nanson's formula."""
    C = columns(F)
    a, b = C[(traction.axis + 1) % 3], C[(traction.axis + 2) % 3]
    A = traction.side * area
    n0 = A * (a[1] * b[2] - a[2] * b[1])
    n1 = A * (a[2] * b[0] - a[0] * b[2])
    n2 = A * (a[0] * b[1] - a[1] * b[0])
    size = sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    t, q = traction.traction, traction.pressure
    return t[0] * size - q * n0, t[1] * size - q * n1, t[2] * size - q * n2


@kernel
def _integral(r):
    """Integral of the tent function from -1 to r, r in cells."""
    r = min(max(r, -1.0), 1.0)
    if r < 0.0:
        return 0.5 * (1.0 + r) * (1.0 + r)
    return 0.5 + r - 0.5 * r * r


def _means(g, half, like):
    """Means of the tents of vertices 0, 1, ... over [g - half, g + half], as many as in `like`."""


@specialise(_means)
def _means_of(g, half, like):
    if len(like) == 1:
        return lambda g, half, like: (
            (_integral(g + half) - _integral(g - half)) / (2.0 * half),
        )
    return lambda g, half, like: (
        (_integral(g + half) - _integral(g - half)) / (2.0 * half),
        *_means(g - 1.0, half, like[1:]),
    )


@kernel
def _along(traction, frame, F, distance, x, d, vertex, like):
    """Weights of the support's vertices along direction `d`; the patch stays within the support."""
    D = len(frame.origin)
    centre, square = 0.0, 0.0
    if traction.follows:
        for j in range(D):
            if j == traction.axis:
                centre = F[d * D + j] * distance
            else:
                square += (F[d * D + j] * traction.half[j]) ** 2
    elif d == traction.axis:
        centre = distance
    else:
        square = traction.half[d] ** 2
    last = len(like) - 1.0
    half = min(max(sqrt(square) * frame.inverse[d], THINNEST), 0.5 * last)
    g = (x + centre - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
    return _means(min(max(g, half), last - half), half, like)


def _support(traction, shape, frame, window, particles, p, layer, F, like):
    """The vertices that get a patch's force, as `pgimp.kernels.transfer.support` gives them."""


@specialise(_support)
def _support_of(traction, shape, frame, window, particles, p, layer, F, like):
    D = len(frame.types[0])

    def support1(traction, shape, frame, window, particles, p, layer, F, like):
        o = particles.patch[p, traction.column + 1]
        w = _along(traction, frame, F, o, particles.x[p, 0], 0, layer, like)
        return 0, ((w, w, window.stride[0]),)

    def support2(traction, shape, frame, window, particles, p, layer, F, like):
        o = particles.patch[p, traction.column + 1]
        x, y = particles.x[p, 0], particles.x[p, 1]
        j = first_vertex(frame, 1, half_widths(shape, frame, particles, p)[1], y)
        w = _along(traction, frame, F, o, x, 0, layer, like)
        v = _along(traction, frame, F, o, y, 1, j, like)
        return (j - window.lower[1]) * window.stride[1], (
            (w, w, window.stride[0]),
            (v, v, window.stride[1]),
        )

    def support3(traction, shape, frame, window, particles, p, layer, F, like):
        o = particles.patch[p, traction.column + 1]
        x, y, z = particles.x[p, 0], particles.x[p, 1], particles.x[p, 2]
        half = half_widths(shape, frame, particles, p)
        j, k = first_vertex(frame, 1, half[1], y), first_vertex(frame, 2, half[2], z)
        w = _along(traction, frame, F, o, x, 0, layer, like)
        v = _along(traction, frame, F, o, y, 1, j, like)
        u = _along(traction, frame, F, o, z, 2, k, like)
        place = (j - window.lower[1]) * window.stride[1] + (k - window.lower[2]) * window.stride[2]
        return place, (
            (w, w, window.stride[0]),
            (v, v, window.stride[1]),
            (u, u, window.stride[2]),
        )

    return (support1, support2, support3)[D - 1]


def _nothing(W):
    """Zero vectors, one a direction."""


@specialise(_nothing)
def _nothing_of(W):
    if len(W) == 1:
        return lambda W: (pack(0.0, 0.0, 0.0, 0.0),)
    return lambda W: (pack(0.0, 0.0, 0.0, 0.0), *_nothing(W[1:]))


@kernel
def scatter_tractions(tractions, shape, frame, window, particles, p, layer, W, scratch):
    """Add the forces on all patches of particle `p` to its layer's own planes.

    `W` is the particle's support; the patches use as many vertices.
    """
    F = deformation(frame, particles, p)
    for t in range(len(tractions)):
        area = particles.patch[p, tractions[t].column]
        if area == 0.0:
            continue
        f = patch_force(tractions[t], F, area)
        place, V = _support(tractions[t], shape, frame, window, particles, p, layer, F, W[0][0])
        force = pack(0.0, f[0], f[1], f[2])
        zero = pack(0.0, 0.0, 0.0, 0.0)
        scatter(scratch, place, V[0][0], V[0][1], V[0][2], V[1:], zero, force, _nothing(W))


@kernel
def traction_power(tractions, shape, frame, window, particles, p, layer, W, start, G):
    """Power of the tractions on particle `p`: its patches' forces times the vertices' velocities.

    `start` is the place of the layer's first plane in `G`.
    """
    F = deformation(frame, particles, p)
    power = 0.0
    for t in range(len(tractions)):
        area = particles.patch[p, tractions[t].column]
        if area == 0.0:
            continue
        f = patch_force(tractions[t], F, area)
        place, V = _support(tractions[t], shape, frame, window, particles, p, layer, F, W[0][0])
        U = gather(G, start + place, V[0][0], V[0][1], V[0][2], V[1:])[0]
        power += f[0] * lane(U, 1) + f[1] * lane(U, 2) + f[2] * lane(U, 3)
    return power
