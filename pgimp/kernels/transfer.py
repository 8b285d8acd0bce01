"""Scatter and gather: what one particle gives to the vertices of its support, and takes back.

A vertex's record is 8 float64: (m, mv) and (-, f) while particles are summed, (m, v) and (-, a)
after the momentum update. Both transfers are written once, as recursions over the vertices of a
direction and over the directions that the compiler unrolls. They factor the sums by direction: in
3D the innermost vertex costs P2G three vector multiply-adds, and G2P three.
"""

from math import floor

from pgimp.kernels.jit import exact, specialise
from pgimp.kernels.simd import lane, load, store
from pgimp.kernels.tuples import plus_scaled, read, scaled
from pgimp.shapes.base import size, weights


def first_vertex(frame, d, half, x):
    """Number of the first vertex, along direction `d`, of a particle at coordinate `x`."""


@exact(first_vertex)  # all kernels must find the same layer, whatever the code around
def _first_vertex(frame, d, half, x):
    return lambda frame, d, half, x: (
        floor((x - frame.origin[d]) * frame.inverse[d] - half) + frame.ghost
    )


def deformation(frame, particles, p):
    """Deformation gradient of particle `p`, a row-major tuple."""


@specialise(deformation)
def _deformation(frame, particles, p):
    like = (0.0,) * len(frame.types[0]) ** 2
    return lambda frame, particles, p: read(particles.F, p, 0, like)


def half_widths(shape, frame, particles, p):
    """Half-widths of particle `p` in cells; costs nothing where the shape keeps its size."""


@specialise(half_widths)
def _half_widths(shape, frame, particles, p):
    return lambda shape, frame, particles, p: (
        size(shape, frame.cell, deformation(frame, particles, p))[0]
    )


def _along(shape, frame, window, d, half, x, vertex):
    """Weights (19), gradients (20), the window's stride and arms, along direction `d`."""


@specialise(_along)
def _along_direction(shape, frame, window, d, half, x, vertex):
    def along(shape, frame, window, d, half, x, vertex):
        f = (x - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
        w, g = weights(shape, half, f)
        return w, scaled(frame.inverse[d], g), window.stride[d], _arms(w, f, frame.cell[d])

    return along


def _arms(w, f, cell):
    """Weights times the vertices' coordinates relative to the particle's."""


@specialise(_arms)
def _arms_of(w, f, cell):
    if len(w) == 1:
        return lambda w, f, cell: (-w[0] * f * cell,)
    return lambda w, f, cell: (-w[0] * f * cell, *_arms(w[1:], f - 1.0, cell))


def support(shape, frame, window, particles, p, layer):
    """Support of particle `p`, whose layer is known.

    Returns
    -------
    place : int
        Of the support's first vertex within its plane of the window, in float64.
    W : tuple
        For each direction: weights (19), gradients (20), stride, weights times arms.
    """


@specialise(support)
def _support(shape, frame, window, particles, p, layer):
    D = len(frame.types[0])
    if D == 1:

        def support1(shape, frame, window, particles, p, layer):
            half = half_widths(shape, frame, particles, p)
            return 0, (_along(shape, frame, window, 0, half[0], particles.x[p, 0], layer),)

        return support1
    if D == 2:

        def support2(shape, frame, window, particles, p, layer):
            half = half_widths(shape, frame, particles, p)
            x, y = particles.x[p, 0], particles.x[p, 1]
            j = first_vertex(frame, 1, half[1], y)
            return (j - window.lower[1]) * window.stride[1], (
                _along(shape, frame, window, 0, half[0], x, layer),
                _along(shape, frame, window, 1, half[1], y, j),
            )

        return support2

    def support3(shape, frame, window, particles, p, layer):
        half = half_widths(shape, frame, particles, p)
        x, y, z = particles.x[p, 0], particles.x[p, 1], particles.x[p, 2]
        j = first_vertex(frame, 1, half[1], y)
        k = first_vertex(frame, 2, half[2], z)
        place = (j - window.lower[1]) * window.stride[1] + (k - window.lower[2]) * window.stride[2]
        return place, (
            _along(shape, frame, window, 0, half[0], x, layer),
            _along(shape, frame, window, 1, half[1], y, j),
            _along(shape, frame, window, 2, half[2], z, k),
        )

    return support3


def _sloped(w, A, e, C):
    """The vector w A + e C_0, w A where C is ()."""


@specialise(_sloped)
def _sloped_by(w, A, e, C):
    if len(C) == 0:
        return lambda w, A, e, C: w * A
    return lambda w, A, e, C: w * A + e * C[0]


def scatter(G, place, w, g, e, stride, rest, A, B, S, C):
    """Add a particle to its support: A times S_vp, and the sum of S_i dS_vp/dx_i to the force.

    Parameters
    ----------
    place : int
        Of the first vertex; `w`, `g`, `e`, `stride` belong to the current direction, `rest` holds
        the following ones.
    B : Vec4
        The force so far: the sum over the directions that came before.
    S : tuple of Vec4
        Stress columns of the current direction and the following ones, times the weights so far.
    C : tuple of Vec4
        Likewise what `slopes` gives.
    """


@specialise(scatter)
def _scatter(G, place, w, g, e, stride, rest, A, B, S, C):
    last = len(w) == 1
    if len(rest) == 0:

        def vertex(G, place, w, g, e, stride, rest, A, B, S, C):
            store(G, place, load(G, place) + _sloped(w[0], A, e[0], C))
            store(G, place + 4, load(G, place + 4) + (w[0] * B + g[0] * S[0]))

        if last:
            return vertex

        def vertices(G, place, w, g, e, stride, rest, A, B, S, C):
            store(G, place, load(G, place) + _sloped(w[0], A, e[0], C))
            store(G, place + 4, load(G, place + 4) + (w[0] * B + g[0] * S[0]))
            scatter(G, place + stride, w[1:], g[1:], e[1:], stride, rest, A, B, S, C)

        return vertices

    def line(G, place, w, g, e, stride, rest, A, B, S, C):
        scatter(
            G, place, rest[0][0], rest[0][1], rest[0][3], rest[0][2], rest[1:],
            _sloped(w[0], A, e[0], C), w[0] * B + g[0] * S[0], scaled(w[0], S[1:]),
            scaled(w[0], C[1:]),
        )  # fmt: skip

    if last:
        return line

    def lines(G, place, w, g, e, stride, rest, A, B, S, C):
        scatter(
            G, place, rest[0][0], rest[0][1], rest[0][3], rest[0][2], rest[1:],
            _sloped(w[0], A, e[0], C), w[0] * B + g[0] * S[0], scaled(w[0], S[1:]),
            scaled(w[0], C[1:]),
        )  # fmt: skip
        scatter(G, place + stride, w[1:], g[1:], e[1:], stride, rest, A, B, S, C)

    return lines


def gather(G, place, w, g, stride, rest):
    """Sums over a particle's support.

    Returns
    -------
    U, A : Vec4
        Sums of the first and second vectors of the records times S_vp (26, 27).
    D : tuple of Vec4
        For the current direction and the following ones, the sum of the first vector times
        dS_vp/dx_i (30).
    """


@specialise(gather)
def _gather(G, place, w, g, stride, rest):
    last = len(w) == 1
    if len(rest) == 0:

        def vertex(G, place, w, g, stride, rest):
            u = load(G, place)
            return w[0] * u, w[0] * load(G, place + 4), (g[0] * u,)

        if last:
            return vertex

        def vertices(G, place, w, g, stride, rest):
            U, A, D = gather(G, place + stride, w[1:], g[1:], stride, rest)
            u = load(G, place)
            return w[0] * u + U, w[0] * load(G, place + 4) + A, (g[0] * u + D[0],)

        return vertices

    def line(G, place, w, g, stride, rest):
        u, a, d = gather(G, place, rest[0][0], rest[0][1], rest[0][2], rest[1:])
        return w[0] * u, w[0] * a, (g[0] * u, *scaled(w[0], d))

    if last:
        return line

    def lines(G, place, w, g, stride, rest):
        U, A, D = gather(G, place + stride, w[1:], g[1:], stride, rest)
        u, a, d = gather(G, place, rest[0][0], rest[0][1], rest[0][2], rest[1:])
        return w[0] * u + U, w[0] * a + A, (g[0] * u + D[0], *plus_scaled(w[0], d, D[1:]))

    return lines


def components(like, U):
    """The vector's components along the directions of the scene; `like` has that many entries."""


@specialise(components)
def _components(like, U):
    if len(like) == 1:
        return lambda like, U: (lane(U, 1),)
    if len(like) == 2:
        return lambda like, U: (lane(U, 1), lane(U, 2))
    return lambda like, U: (lane(U, 1), lane(U, 2), lane(U, 3))


def gradient(D):
    """Velocity gradient, row-major, from the vectors of `gather`."""


@specialise(gradient)
def _gradient(D):
    if len(D) == 1:
        return lambda D: (lane(D[0], 1),)
    if len(D) == 2:
        return lambda D: (lane(D[0], 1), lane(D[1], 1), lane(D[0], 2), lane(D[1], 2))
    return lambda D: (
        lane(D[0], 1), lane(D[1], 1), lane(D[2], 1),
        lane(D[0], 2), lane(D[1], 2), lane(D[2], 2),
        lane(D[0], 3), lane(D[1], 3), lane(D[2], 3),
    )  # fmt: skip
