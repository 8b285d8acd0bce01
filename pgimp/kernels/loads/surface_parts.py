"""Parts of surfaces that particles carry: their area vectors, centroids, and the forces on them.

All are of the initial state, see `pgimp.scene.bodies.surface_elements`; `surfaces.py` has the
transfer to the vertices.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.loads.profiles import profiled
from pgimp.kernels.loads.tractions import columns
from pgimp.kernels.transfer.first_vertex import deformation

#: Part of the squared area below which an area vector is that of no direction.
_NONE = 1e-20


@inner_kernel
def current_area(F, N):
    """J F^-T N: the current area vector by Nanson's formula."""
    C = columns(F)
    x, y, z = 0.0, 0.0, 0.0
    for i in range(3):
        a, b, n = C[(i + 1) % 3], C[(i + 2) % 3], N[i]
        x += n * (a[1] * b[2] - a[2] * b[1])
        y += n * (a[2] * b[0] - a[0] * b[2])
        z += n * (a[0] * b[1] - a[1] * b[0])
    return x, y, z


@inner_kernel
def area_vector(surface, p, first, D):
    """Area vector of a part as three numbers."""
    y = surface[p, first + 2] if D > 1 else 0.0
    z = surface[p, first + 3] if D > 2 else 0.0
    return surface[p, first + 1], y, z


@inner_kernel
def area_moment(surface, p, first, D, j, d):
    """First moment along `j` of component `d` of the area vector of a part."""
    return surface[p, first + 1 + D + D * j + d] if j < D and d < D else 0.0


@inner_kernel
def part_centroid(surface, p, first, D, N):
    """Centroid of a part, from its particle, in the initial state."""
    square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
    if not square > _NONE * surface[p, first] ** 2:
        return 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    for d in range(3):
        x += area_moment(surface, p, first, D, 0, d) * N[d]
        y += area_moment(surface, p, first, D, 1, d) * N[d]
        z += area_moment(surface, p, first, D, 2, d) * N[d]
    return x / square, y / square, z / square


@inner_kernel
def position_of(particles, p, D):
    """Current position as three numbers."""
    y = particles.x[p, 1] if D > 1 else 0.0
    z = particles.x[p, 2] if D > 2 else 0.0
    return particles.x[p, 0], y, z


@inner_kernel
def part_force(load, particles, p, F, D, N, c):
    """Force on a part: with a pressure that varies in space by its first moments."""
    surface, first = particles.surface, load.column
    n, area = N, surface[p, first]
    C, g = columns(F), load.gradient
    if load.follows:
        n = current_area(F, N)
        square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
        if square > _NONE * area * area:
            area *= sqrt((n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / square)
    q, t = load.pressure, load.traction
    if g[0] != 0.0 or g[1] != 0.0 or g[2] != 0.0:
        at = position_of(particles, p, D)
        q += g[0] * at[0] + g[1] * at[1] + g[2] * at[2]
        h = (
            g[0] * C[0][0] + g[1] * C[0][1] + g[2] * C[0][2],
            g[0] * C[1][0] + g[1] * C[1][1] + g[2] * C[1][2],
            g[0] * C[2][0] + g[1] * C[2][1] + g[2] * C[2][2],
        )
        if not q + h[0] * c[0] + h[1] * c[1] + h[2] * c[2] > 0.0:  # above the level
            return 0.0, 0.0, 0.0
        x, y, z = q * N[0], q * N[1], q * N[2]
        for j in range(3):
            x += h[j] * area_moment(surface, p, first, D, j, 0)
            y += h[j] * area_moment(surface, p, first, D, j, 1)
            z += h[j] * area_moment(surface, p, first, D, j, 2)
        n, q = current_area(F, (x, y, z)), 1.0
    return t[0] * area - q * n[0], t[1] * area - q * n[1], t[2] * area - q * n[2]


@inner_kernel
def pressure_couple(load, frame, particles, p, j, N, c):
    """First moment along `j` of a pressure's force on a part, about its centroid.

    Where a part is bent, or round an edge, its components act at different places.
    """
    D, surface, first = len(frame.origin), particles.surface, load.column
    n = (
        area_moment(surface, p, first, D, j, 0) - c[j] * N[0],
        area_moment(surface, p, first, D, j, 1) - c[j] * N[1],
        area_moment(surface, p, first, D, j, 2) - c[j] * N[2],
    )
    return pressure_moment(load, frame, particles, p, N, c, n)


@inner_kernel
def pressure_moment(load, frame, particles, p, N, c, n):
    """Moment of a pressure's force on a part, given that of its normal in the initial state."""
    D = len(frame.origin)
    F = deformation(frame, particles, p)
    g, q = load.gradient, load.pressure
    if g[0] != 0.0 or g[1] != 0.0 or g[2] != 0.0:
        at, C = position_of(particles, p, D), columns(F)
        for d in range(3):
            q += g[d] * (at[d] + C[0][d] * c[0] + C[1][d] * c[1] + C[2][d] * c[2])
        q = max(q, 0.0)
    if load.follows:
        n = current_area(F, n)
    f = (-q * n[0], -q * n[1], -q * n[2])
    return profiled(load.profile, frame, position_of(particles, p, D), F, (c, N), f)
