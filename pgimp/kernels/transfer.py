"""Scatter and gather: what one particle gives to the vertices of its support, and takes back.

What they move is the record of a vertex, see `pgimp.kernels.record`.
Both transfers are written once for all dimensions, and factor the sums by direction: in 3D the
innermost vertex costs P2G three vector multiply-adds, and G2P three. Vertices without weight at the
support's end are left out; the innermost direction, along which records follow each other, is
unrolled for each number of vertices, the others are loops.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.simd import load, store, vector
from pgimp.jit.tuples import joined, plus_scaled, scaled
from pgimp.kernels.batch import entries, entry, extent, extents
from pgimp.kernels.mean import factor, factored, factors, no_rates, plus_factored
from pgimp.kernels.record import RECORD

#: Codes of component d are this to the power d: so far apart that a weighted sum of them tells the
#: greatest.
_APART = 1e12

#: Code of several components, and of what constraints hold, which need not lie along a wall.
SEVERAL = _APART**3

#: Least weight of a vertex that counts as being in a particle's reach; less is rounding.
LEAST_WEIGHT = 1e-9


class Support(NamedTuple):
    """Where one particle of a batch has weight.

    Attributes
    ----------
    buffer
        The supports of the batch, see `pgimp.kernels.batch`.
    j : int
        Number of the particle in the batch.
    """

    buffer: Any
    j: int


class Share(NamedTuple):
    """What a particle gives to the vertices of its support.

    Attributes
    ----------
    A : Vec4
        Mass and momentum; times S_vp, see `contribution`.
    B : Vec4 or ()
        What else is given times S_vp, see `weight`.
    S : tuple of D Vec4
        Columns of the stress times the volume; the force is the sum of S_i dS_vp/dx_i.
    C : tuple of D Vec4 or ()
        What `affine_momentum` gives, times arms.
    M : Vec4 or ()
        What `mean_force` gives; times dD_p/dv_v, see `pgimp.kernels.mean`.
    """

    A: Any
    B: Any
    S: tuple
    C: tuple
    M: Any


@inner_kernel
def also_held(code, d):
    """Code of the components that are held, of which `code` is 0 for none yet, with component d."""
    one = (1.0, _APART, _APART * _APART)[d]
    return one if code == 0.0 or code == one else SEVERAL


@inner_kernel
def held_codes(d):
    """Between what a weighted sum of codes lies whose greatest is that of component d; 3: several.

    A weight below `LEAST_WEIGHT` of the next code falls to this one, which then may be missed.
    """
    one = (1.0, _APART, _APART * _APART, SEVERAL)[d]
    return LEAST_WEIGHT * one, LEAST_WEIGHT * _APART * one


def _sloped(w, A, e, C):
    """The vector w A + e C_0, w A where C is ()."""


@specialise(_sloped)
def _sloped_by(w, A, e, C):
    if len(C) == 0:
        return lambda w, A, e, C: w * A
    return lambda w, A, e, C: w * A + e * C[0]


def _force(w, B, g, S):
    """The vector w B + g S, g S where B is ()."""


@specialise(_force)
def _force_of(w, B, g, S):
    if hasattr(B, "count"):  # ()
        return lambda w, B, g, S: g * S
    return lambda w, B, g, S: w * B + g * S


def _step(stride):
    """Distance of neighbours along the last direction, given its stride and those behind it.

    In 1D that is the distance of planes, which may hold several fields; else it is known.
    """


@specialise(_step)
def _step_of(stride):
    return (lambda stride: stride[0]) if len(stride) == 3 else (lambda stride: RECORD)


def _scatter_line(G, place, step, w, g, e, f, share):
    """Add a particle to a line of vertices, which are `step` apart."""


@specialise(_scatter_line)
def _scatter_vertices(G, place, step, w, g, e, f, share):
    def vertex(G, place, step, w, g, e, f, share):
        A, B, S, C, M = share
        store(G, place, load(G, place) + _sloped(w[0], A, e[0], C))
        more = plus_factored(f[0], M, _force(w[0], B, g[0], S[0]))
        store(G, place + 4, load(G, place + 4) + more)

    if len(w) == 1:
        return vertex

    def vertices(G, place, step, w, g, e, f, share):
        A, B, S, C, M = share
        store(G, place, load(G, place) + _sloped(w[0], A, e[0], C))
        more = plus_factored(f[0], M, _force(w[0], B, g[0], S[0]))
        store(G, place + 4, load(G, place + 4) + more)
        _scatter_line(G, place + step, step, w[1:], g[1:], e[1:], f[1:], share)

    return vertices


def _scatter_lines(G, support, d, place, counts, stride, Z, share):
    """Add a particle to the lines of its support, from direction `d` on.

    Parameters
    ----------
    place : int
        Of the first vertex.
    counts : tuple of int
        Vertices of the current direction and the following ones but the last; `stride` alike.
    Z : tuple
        Weights, gradients, arms and `factors` along the last direction.
    share : Share
        What remains of it: A and B with the sums over the directions that came before, S and C of
        the current direction and the following ones, times the weights so far, and M times the
        factors so far.
    """


@specialise(_scatter_lines)
def _scatter_all(G, support, d, place, counts, stride, Z, share):
    if len(counts) == 0:
        return lambda G, support, d, place, counts, stride, Z, share: _scatter_line(
            G, place, _step(stride), Z[0], Z[1], Z[2], Z[3], share
        )

    def lines(G, support, d, place, counts, stride, Z, share):
        (buffer, j), (A, B, S, C, M) = support, share
        for i in range(counts[0]):
            w, g = entry(buffer, d, 0, i, j), entry(buffer, d, 1, i, j)
            e = entry(buffer, d, 2, i, j)
            at = place + i * stride[0]
            part = Share(
                _sloped(w, A, e, C), _force(w, B, g, S[0]), scaled(w, S[1:]), scaled(w, C[1:]),
                factored(factor(M, buffer, d, i, j), M),
            )  # fmt: skip
            _scatter_lines(G, support, d + 1, at, counts[1:], stride[1:], Z, part)

    return lines


def _last(support, d, like, mean):
    """Weights, gradients, arms and factors along the last direction, as many as `like` has."""


@specialise(_last)
def _last_of(support, d, like, mean):
    return lambda support, d, like, mean: (
        entries(support.buffer, d, 0, 0, support.j, like),
        entries(support.buffer, d, 1, 0, support.j, like),
        entries(support.buffer, d, 2, 0, support.j, like),
        factors(mean, support.buffer, d, 0, support.j, like),
    )


def _scatter_some(like, count, G, support, place, counts, stride, share):
    """Add a particle that has weight on `count` vertices along the last direction.

    There are no more than `like` has; each number has code of its own.
    """


@specialise(_scatter_some)
def _scatter_number(like, count, G, support, place, counts, stride, share):
    last = len(counts)

    def exactly(like, count, G, support, place, counts, stride, share):
        Z = _last(support, last, like, share.M)
        _scatter_lines(G, support, 0, place, counts, stride, Z, share)

    if len(like) == 2:
        return exactly

    def at_most(like, count, G, support, place, counts, stride, share):
        if count < len(like):
            _scatter_some(like[1:], count, G, support, place, counts, stride, share)
        else:
            Z = _last(support, last, like, share.M)
            _scatter_lines(G, support, 0, place, counts, stride, Z, share)

    return at_most


def scatter(shape, G, support, place, stride, share):
    """Add a particle's share to its support.

    Parameters
    ----------
    support : Support
        Where it has weight.
    place : int
        Of the first vertex in `G`.
    stride : tuple of int
        The window's.
    share : Share
        What it gives.
    """


@specialise(scatter)
def _scatter(shape, G, support, place, stride, share):
    last = len(share.types[2]) - 1
    outer = (0,) * last
    like = (0.0,) * shape.instance_class.vertices()

    def scatter(shape, G, support, place, stride, share):
        counts = extents(shape, support.buffer, 0, support.j, outer)
        count = extent(shape, support.buffer, last, support.j)
        _scatter_some(like, count, G, support, place, counts, stride, share)

    return scatter


def _rates(mean, f, u):
    """The vector f u; () unless there is a `mean`."""


@specialise(_rates)
def _rates_of(mean, f, u):
    return (lambda mean, f, u: ()) if hasattr(mean, "count") else (lambda mean, f, u: f * u)


def _plus_rates(mean, f, u, M):
    """The vector f u + M; () unless there is a `mean`."""


@specialise(_plus_rates)
def _plus_rates_of(mean, f, u, M):
    if hasattr(mean, "count"):  # ()
        return lambda mean, f, u, M: ()
    return lambda mean, f, u, M: f * u + M


def _gather_line(G, place, step, w, g, f, mean):
    """Sums over a line of vertices, which are `step` apart."""


@specialise(_gather_line)
def _gather_vertices(G, place, step, w, g, f, mean):
    def vertex(G, place, step, w, g, f, mean):
        u = load(G, place)
        return w[0] * u, w[0] * load(G, place + 4), (g[0] * u,), _rates(mean, f[0], u)

    if len(w) == 1:
        return vertex

    def vertices(G, place, step, w, g, f, mean):
        U, A, D, M = _gather_line(G, place + step, step, w[1:], g[1:], f[1:], mean)
        u = load(G, place)
        M = _plus_rates(mean, f[0], u, M)
        return w[0] * u + U, w[0] * load(G, place + 4) + A, (g[0] * u + D[0],), M

    return vertices


def _nothing(counts):
    """Zero vectors, one more than there are counts."""


@specialise(_nothing)
def _nothing_of(counts):
    if len(counts) == 0:
        return lambda counts: (vector(0.0),)
    return lambda counts: (vector(0.0), *_nothing(counts[1:]))


def _gather_lines(G, support, d, place, counts, stride, Z, mean):
    """Sums over the lines of a support, from direction `d` on; see `gather`, `_scatter_lines`."""


@specialise(_gather_lines)
def _gather_all(G, support, d, place, counts, stride, Z, mean):
    if len(counts) == 0:
        return lambda G, support, d, place, counts, stride, Z, mean: _gather_line(
            G, place, _step(stride), Z[0], Z[1], Z[3], mean
        )

    def lines(G, support, d, place, counts, stride, Z, mean):
        buffer, j = support
        U, A, D, M = vector(0.0), vector(0.0), _nothing(counts), no_rates(mean)
        for i in range(counts[0]):
            w, g = entry(buffer, d, 0, i, j), entry(buffer, d, 1, i, j)
            u, a, b, m = _gather_lines(
                G, support, d + 1, place + i * stride[0], counts[1:], stride[1:], Z, mean
            )
            U, A = w * u + U, w * a + A
            D = joined(g * u + D[0], plus_scaled(w, b, D[1:]))
            M = _plus_rates(mean, factor(mean, buffer, d, i, j), m, M)
        return U, A, D, M

    return lines


def _gather_some(like, count, G, support, place, counts, stride, mean):
    """Sums over the support of a particle that has weight on `count` vertices; `_scatter_some`."""


@specialise(_gather_some)
def _gather_number(like, count, G, support, place, counts, stride, mean):
    last = len(counts)

    def exactly(like, count, G, support, place, counts, stride, mean):
        Z = _last(support, last, like, mean)
        return _gather_lines(G, support, 0, place, counts, stride, Z, mean)

    if len(like) == 2:
        return exactly

    def at_most(like, count, G, support, place, counts, stride, mean):
        if count < len(like):
            return _gather_some(like[1:], count, G, support, place, counts, stride, mean)
        Z = _last(support, last, like, mean)
        return _gather_lines(G, support, 0, place, counts, stride, Z, mean)

    return at_most


def gather(shape, G, support, place, stride, like, mean):
    """Sums over a particle's support.

    Parameters
    ----------
    shape, G, support, place, stride
        As in `scatter`.
    like : tuple
        One entry a direction of the scene.
    mean : float or ()
        See `Loads`.

    Returns
    -------
    U, A : Vec4
        Sums of the first and second vectors of the records times S_vp (26, 27).
    D : tuple of Vec4
        For each direction, the sum of the first vector times dS_vp/dx_i (30).
    M : Vec4 or ()
        With a `mean`, the sum of dD_p/dv_v times velocities, component by component.
    """


@specialise(gather)
def _gather(shape, G, support, place, stride, like, mean):
    outer, last = (0,) * (len(like) - 1), len(like) - 1
    most = (0.0,) * shape.instance_class.vertices()

    def gather(shape, G, support, place, stride, like, mean):
        counts = extents(shape, support.buffer, 0, support.j, outer)
        count = extent(shape, support.buffer, last, support.j)
        return _gather_some(most, count, G, support, place, counts, stride, mean)

    return gather
