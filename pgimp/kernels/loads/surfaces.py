"""Loads on any part of a body's surface, carried by the particles near it.

A particle's part of a surface has an area, an area vector and its first moments about the particle,
all of the initial state; see `pgimp.scene.bodies.surface_elements`. Its centroid moves with the
particle: x_p + F c in the current configuration. The force is spread there by the vertices'
tent functions, averaged over a particle's width along the surface. These sum up to one, so that the
total force is exact.
"""

from math import sqrt

from pgimp.jit.kernel import class_of, inlined, inner_kernel
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import lane, pack, stack
from pgimp.kernels.data.velocity_fields import field_of
from pgimp.kernels.loads.following import surface_F
from pgimp.kernels.loads.profiles import profiled
from pgimp.kernels.loads.strips import strip_weights
from pgimp.kernels.loads.tractions import book_force, columns, half_step, means
from pgimp.kernels.transfer.first_vertex import (
    coordinate,
    deformation,
    first_vertex,
    half_widths,
    is_axial,
    is_initial,
)
from pgimp.kernels.transfer.gather import gather_products
from pgimp.kernels.transfer.parts import (
    gather_between,
    keep_corners,
    product_count,
    read_products,
    scatter_surface,
)
from pgimp.kernels.transfer.scatter import Share, scatter_products
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, keep_support
from pgimp.kernels.transfer.transfer import Support
from pgimp.physics.shapes.base import by_parts

#: Part of the squared area below which an area vector is that of no direction.
_NONE = 1e-20


@inner_kernel
def _cofactor(F, N):
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
def _vector(surface, p, first, D):
    """Area vector of a part as three numbers."""
    y = surface[p, first + 2] if D > 1 else 0.0
    z = surface[p, first + 3] if D > 2 else 0.0
    return surface[p, first + 1], y, z


@inner_kernel
def _moment(surface, p, first, D, j, d):
    """First moment along `j` of component `d` of the area vector of a part."""
    return surface[p, first + 1 + D + D * j + d] if j < D and d < D else 0.0


@inner_kernel
def _centroid(surface, p, first, D, N):
    """Centroid of a part, from its particle, in the initial state."""
    square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
    if not square > _NONE * surface[p, first] ** 2:
        return 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    for d in range(3):
        x += _moment(surface, p, first, D, 0, d) * N[d]
        y += _moment(surface, p, first, D, 1, d) * N[d]
        z += _moment(surface, p, first, D, 2, d) * N[d]
    return x / square, y / square, z / square


@inner_kernel
def _position(particles, p, D):
    """Current position as three numbers."""
    y = particles.x[p, 1] if D > 1 else 0.0
    z = particles.x[p, 2] if D > 2 else 0.0
    return particles.x[p, 0], y, z


@inner_kernel
def _surface_force(load, particles, p, F, D, N, c):
    """Force on a part: with a pressure that varies in space by its first moments."""
    surface, first = particles.surface, load.column
    n, area = N, surface[p, first]
    C, g = columns(F), load.gradient
    if load.follows:
        n = _cofactor(F, N)
        square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
        if square > _NONE * area * area:
            area *= sqrt((n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / square)
    q, t = load.pressure, load.traction
    if g[0] != 0.0 or g[1] != 0.0 or g[2] != 0.0:
        at = _position(particles, p, D)
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
            x += h[j] * _moment(surface, p, first, D, j, 0)
            y += h[j] * _moment(surface, p, first, D, j, 1)
            z += h[j] * _moment(surface, p, first, D, j, 2)
        n, q = _cofactor(F, (x, y, z)), 1.0
    return t[0] * area - q * n[0], t[1] * area - q * n[1], t[2] * area - q * n[2]


@inlined
def _moved(load, frame, F, part):
    """Centroid of a part, from its particle, and its area vector, where its weights are."""
    if is_initial(frame):
        return part
    c, N = part
    C = columns(F)
    x = C[0][0] * c[0] + C[1][0] * c[1] + C[2][0] * c[2]
    y = C[0][1] * c[0] + C[1][1] * c[1] + C[2][1] * c[2]
    z = C[0][2] * c[0] + C[1][2] * c[1] + C[2][2] * c[2]
    if load.stretches:
        return (x, y, z), _cofactor(F, N)
    square, before = x * x + y * y + z * z, c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    kept = sqrt(before / square) if square > 0.0 else 0.0  # as the particle keeps its size
    return (kept * x, kept * y, kept * z), _cofactor(F, N)


@inner_kernel
def _along(load, frame, x, part, own, d, vertex, like):
    """Weights of the support's vertices along direction `d`; they stay within the particle.

    `own` is the particle's half-width in cells, about x: beyond it there may be no mass. A part is
    spread less rather than put elsewhere, as a force beside its line would turn the body.
    """
    c, N = part
    square = N[0] * N[0] + N[1] * N[1] + N[2] * N[2]
    across = 1.0 - N[d] * N[d] / square if square > 0.0 else 1.0
    last = len(like) - 1.0
    off = min(max(c[d] * frame.inverse[d], -own), own)
    half = load.half[d] * sqrt(max(across, 0.0)) * frame.inverse[d]
    half = min(half, own - abs(off), 0.5 * last)
    g = (x - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost) + off
    return means(False, False, half, min(max(g, half), last - half), like)


@inlined
def _bearing(load, D):
    """First of the numbers of a part's products of inertia, see `Particles.bearing`."""
    return load.column // (1 + D + D * D) * product_count(D) * (1 + D)


@inlined
def _keep_point(load, frame, window, particles, p, c, vertex, buffer):
    """Store a part's weights in its particle's cell, along the last directions, as many as in `c`.

    `vertex` is the cell's first vertex along the first of them; returns the offset along the
    following ones.
    """
    D = len(frame.origin)
    d = D - len(c)
    f = (coordinate(frame, particles, p, d) - frame.origin[d]) * frame.inverse[d]
    t = f - (vertex - frame.ghost) + c[0] * frame.inverse[d]
    keep_support(buffer, d, (1.0 - t, t), (-frame.inverse[d], frame.inverse[d]))
    if len(c) == 1:
        number = _bearing(load, D)
        keep_corners(buffer, read_products(particles.bearing, p, number, D), frame.origin, ())
        return 0
    x = coordinate(frame, particles, p, d + 1)
    following = first_vertex(frame, d + 1, 0.0, x)
    rest = _keep_point(load, frame, window, particles, p, c[1:], following, buffer)
    return (following - window.lower[d + 1]) * window.stride[d + 1] + rest


@inlined
def _along_first(load, frame, x, part, own, vertex, like):
    """As `_along`, along x; in axisymmetry as of `strip_weights`."""
    if is_axial(frame):
        return strip_weights(load, frame, x, part, own, vertex, like)
    return _along(load, frame, x, part, own, 0, vertex, like)


@inlined
def _support(load, layout, window, particles, p, layer, part, buffer):
    """Store the weights of the vertices under a part; returns the first offset."""
    D = len(layout[1].origin)
    if by_parts(layout[0]):
        return _keep_point(load, layout[1], window, particles, p, part[0][:D], layer, buffer)
    like = (0.0,) * class_of(layout[0]).vertices()
    if D == 1:
        shape, frame = layout
        half, x = half_widths(shape, frame, particles, p), coordinate(frame, particles, p, 0)
        w = _along(load, frame, x, part, half[0], 0, layer, like)
        keep_support(buffer, 0, w, w)
        return 0
    if D == 2:
        shape, frame = layout
        half = half_widths(shape, frame, particles, p)
        x, y = coordinate(frame, particles, p, 0), coordinate(frame, particles, p, 1)
        j = first_vertex(frame, 1, half[1], y)
        w = _along_first(load, frame, x, part, half[0], layer, like)
        v = _along(load, frame, y, part, half[1], 1, j, like)
        keep_support(buffer, 0, w, w)
        keep_support(buffer, 1, v, v)
        return (j - window.lower[1]) * window.stride[1]
    shape, frame = layout
    half = half_widths(shape, frame, particles, p)
    x, y = coordinate(frame, particles, p, 0), coordinate(frame, particles, p, 1)
    j = first_vertex(frame, 1, half[1], y)
    z = coordinate(frame, particles, p, 2)
    k = first_vertex(frame, 2, half[2], z)
    w = _along(load, frame, x, part, half[0], 0, layer, like)
    v = _along(load, frame, y, part, half[1], 1, j, like)
    u = _along(load, frame, z, part, half[2], 2, k, like)
    keep_support(buffer, 0, w, w)
    keep_support(buffer, 1, v, v)
    keep_support(buffer, 2, u, u)
    return (j - window.lower[1]) * window.stride[1] + (k - window.lower[2]) * window.stride[2]


@inner_kernel
def _part(load, frame, particles, p):
    """Force on a particle's part of a surface, and (centroid, area vector) for its weights."""
    D = len(frame.origin)
    F = surface_F(load.corrected, frame, particles, p)
    N = _vector(particles.surface, p, load.column, D)
    c = _centroid(particles.surface, p, load.column, D, N)
    f = _surface_force(load, particles, p, F, D, N, c)
    f = profiled(load.profile, frame, _position(particles, p, D), F, (c, N), f)
    return f, _moved(load, frame, F, (c, N))


@inner_kernel
def _couple(load, frame, particles, p, j, N, c):
    """First moment along `j` of a pressure's force on a part, about its centroid.

    Where a part is bent, or round an edge, its components act at different places.
    """
    D, surface, first = len(frame.origin), particles.surface, load.column
    n = (
        _moment(surface, p, first, D, j, 0) - c[j] * N[0],
        _moment(surface, p, first, D, j, 1) - c[j] * N[1],
        _moment(surface, p, first, D, j, 2) - c[j] * N[2],
    )
    return _pressed(load, frame, particles, p, N, c, n)


@inner_kernel
def _spread(load, frame, particles, p, k, N, c):
    """Moment of a pressure's force on a part by the `k`-th product of distances.

    It is what one mean for all components of the force leaves.
    """
    D = len(frame.origin)
    count, first = product_count(D), _bearing(load, D) + k
    x, y = particles.bearing[p, first + count], particles.bearing[p, first + 2 * count]
    z = particles.bearing[p, first + 3 * count] if D > 2 else 0.0
    return _pressed(load, frame, particles, p, N, c, (x, y, z))


@inner_kernel
def _pressed(load, frame, particles, p, N, c, n):
    """Moment of a pressure's force on a part, given that of its normal in the initial state."""
    D = len(frame.origin)
    F = deformation(frame, particles, p)
    g, q = load.gradient, load.pressure
    if g[0] != 0.0 or g[1] != 0.0 or g[2] != 0.0:
        at, C = _position(particles, p, D), columns(F)
        for d in range(3):
            q += g[d] * (at[d] + C[0][d] * c[0] + C[1][d] * c[1] + C[2][d] * c[2])
        q = max(q, 0.0)
    if load.follows:
        n = _cofactor(F, n)
    f = (-q * n[0], -q * n[1], -q * n[2])
    return profiled(load.profile, frame, _position(particles, p, D), F, (c, N), f)


@inlined
def _couples(load, frame, particles, p, part, like):
    """Moments of the force on a part, see `scatter_surface`, vectors (0, f)."""
    if len(like) == 0:
        count = product_count(len(frame.origin))
        each = tuple(_spread(load, frame, particles, p, k, part[1], part[0]) for k in range(count))
        return tuple(pack(0.0, *f) for f in each)
    f = _couple(load, frame, particles, p, len(frame.origin) - len(like), part[1], part[0])
    return (pack(0.0, *f), *_couples(load, frame, particles, p, part, like[1:]))


@inlined
def _scatter(load, layout, particles, p, part, planes, support, f):
    """Add the force `f` on a part; `planes` are G, offset and stride."""
    (shape, frame), (G, offset, stride) = layout, planes
    zero, nothing = pack(0.0, 0.0, 0.0, 0.0), zeros(frame.origin)
    force = pack(0.0, f[0], f[1], f[2])
    if by_parts(shape):
        couples = _couples(load, frame, particles, p, part, frame.origin)
        return scatter_surface(G, support, offset, stride, force, couples, frame.origin)
    share = Share(zero, force, nothing, (), (), ())
    return scatter_products(shape, G, support, offset, stride, share)


@inlined
def _power(load, layout, particles, p, acts, planes, support, half):
    """Power of the force on a part, both in `acts`; the other arguments are as of `_scatter`.

    `half` is from `half_step`.
    """
    (shape, frame), (G, offset, stride), like = layout, planes, layout[1].origin
    part, f = acts
    if by_parts(shape):
        U, D = gather_between(G, support, offset, stride, half, like)
        couples = _couples(load, frame, particles, p, part, like)
        return _scalar(f, U) + _powers(couples, D)
    U, A = gather_products(shape, G, support, offset, stride, like, (), ())[:2]
    return _scalar(f, U - half * A)


@inlined
def _scalar(f, u):
    """Product of a force and a velocity, a vector (m, v)."""
    return f[0] * lane(u, 1) + f[1] * lane(u, 2) + f[2] * lane(u, 3)


@inlined
def _powers(couples, D):
    """Sum of the products of moments and derivatives of the velocity."""
    if len(couples) == 0:
        return 0.0
    f = couples[0]
    return _scalar((lane(f, 1), lane(f, 2), lane(f, 3)), D[0]) + _powers(couples[1:], D[1:])


@inner_kernel
def scatter_surfaces(loads, setting, field, particles, rows, span, layer):
    """Add the forces on a layer's parts of surfaces, in canonical order, to its own planes.

    For the arguments see `pgimp.kernels.loads.tractions.scatter_tractions`.
    """
    shape, frame, window, scratch = setting.shape, setting.frame, field.window, field.scratch
    buffer = stack(SUPPORT_SIZE)
    for k in range(span[0], span[1]):
        p = rows[k]
        for t in range(len(loads)):
            if particles.surface[p, loads[t].column] == 0.0:
                continue
            f, part = _part(loads[t], frame, particles, p)
            offset = _support(loads[t], (shape, frame), window, particles, p, layer, part, buffer)
            offset += field_of(window, particles, p)
            planes, layout = (scratch, offset, window.stride), (shape, frame)
            _scatter(loads[t], layout, particles, p, part, planes, Support(buffer, 0), f)


@inner_kernel
def surface_power(loads, setting, field, particles, rows, span, layer, booking):
    """Power of the loads on a layer's parts of surfaces, as of tractions."""
    shape, frame, window, G = setting.shape, setting.frame, field.window, field.G
    start = (layer - window.lower[0]) * window.stride[0]
    buffer = stack(SUPPORT_SIZE)
    power = 0.0
    for k in range(span[0], span[1]):
        p = rows[k]
        for t in range(len(loads)):
            if particles.surface[p, loads[t].column] == 0.0:
                continue
            f, part = _part(loads[t], frame, particles, p)
            offset = _support(loads[t], (shape, frame), window, particles, p, layer, part, buffer)
            offset += field_of(window, particles, p)
            planes, layout = (G, start + offset, window.stride), (shape, frame)
            book_force(booking, layer - window.lower[0], t, f)
            half, support = half_step(loads[t].follows, booking.dt), Support(buffer, 0)
            power += _power(loads[t], layout, particles, p, (part, f), planes, support, half)
    return power
