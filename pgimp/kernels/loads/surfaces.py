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
from pgimp.kernels.loads.surface_parts import (
    area_vector,
    current_area,
    part_centroid,
    part_force,
    position_of,
    pressure_couple,
    pressure_moment,
)
from pgimp.kernels.loads.tractions import book_force, columns, half_step, means
from pgimp.kernels.transfer.first_vertex import (
    coordinate,
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
        return (x, y, z), current_area(F, N)
    square, before = x * x + y * y + z * z, c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    kept = sqrt(before / square) if square > 0.0 else 0.0  # as the particle keeps its size
    return (kept * x, kept * y, kept * z), current_area(F, N)


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
    N = area_vector(particles.surface, p, load.column, D)
    c = part_centroid(particles.surface, p, load.column, D, N)
    f = part_force(load, particles, p, F, D, N, c)
    f = profiled(load.profile, frame, position_of(particles, p, D), F, (c, N), f)
    return f, _moved(load, frame, F, (c, N))


@inner_kernel
def _spread(load, frame, particles, p, k, N, c):
    """Moment of a pressure's force on a part by the `k`-th product of distances.

    It is what one mean for all components of the force leaves.
    """
    D = len(frame.origin)
    count, first = product_count(D), _bearing(load, D) + k
    x, y = particles.bearing[p, first + count], particles.bearing[p, first + 2 * count]
    z = particles.bearing[p, first + 3 * count] if D > 2 else 0.0
    return pressure_moment(load, frame, particles, p, N, c, (x, y, z))


@inlined
def _couples(load, frame, particles, p, part, like):
    """Moments of the force on a part, see `scatter_surface`, vectors (0, f)."""
    if len(like) == 0:
        count = product_count(len(frame.origin))
        each = tuple(_spread(load, frame, particles, p, k, part[1], part[0]) for k in range(count))
        return tuple(pack(0.0, *f) for f in each)
    f = pressure_couple(load, frame, particles, p, len(frame.origin) - len(like), part[1], part[0])
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
            half, support = half_step(loads[t].follows, booking.half), Support(buffer, 0)
            power += _power(loads[t], layout, particles, p, (part, f), planes, support, half)
    return power
