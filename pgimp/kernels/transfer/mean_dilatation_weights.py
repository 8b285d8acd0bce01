"""Weights of vertices in the mean dilatation of a particle.

See `pgimp.kernels.update.mean_dilatation`.

The rate D_p is the sum over vertices of dD_p/dv_v times velocities. Its factors along each
direction are the a and g of the particle's box. In P2G they turn `mean_force` into forces, in G2P
velocities into D_p.
"""

from pgimp.jit.kernel import class_of, inlined, is_empty
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.simd import load, number, pack, store, vector, where
from pgimp.kernels.transfer.first_vertex import is_axial
from pgimp.kernels.transfer.supports import BOX, MEANS, PLAIN, entry, four_entries, keep_vectors

#: Offset of the four particles' gathered sums in the buffer for supports, after their a.
GATHERED_RATES = MEANS + 48


@inlined
def keep_means(mean, shape, frame, buffer):
    """Store the weights a of four particles in the buffer with their supports.

    Nothing unless there is a `mean`, see `Loads`; () is none, as everywhere here.
    """
    if is_empty(mean):
        return None
    if is_axial(frame):
        a, g = means_of_rings(shape, buffer)
        keep_vectors(buffer, MEANS, a)
        keep_vectors(buffer, PLAIN, scaled(frame.inverse[0], g))
        _along(shape, frame, buffer, 1)
    else:
        return _along(shape, frame, buffer, 0)


@inlined
def _along(shape, frame, buffer, first):
    """Store the weights along the directions from `first` on."""
    for d in range(first, len(frame.cell)):
        keep_vectors(buffer, MEANS + 16 * d, means_of_parts(shape, buffer, d, frame.cell[d]))


@inlined
def means_of_parts(shape, buffer, d, cell):
    """The weights a of four particles along direction `d`, a tuple of Vec4."""
    if class_of(shape).vertices() == 3:
        half = 0.5 * cell
        return (
            -half * four_entries(buffer, d, 1, 0),
            vector(0.5),
            half * four_entries(buffer, d, 1, 2),
        )
    half = 0.5 * cell
    g0, g3 = four_entries(buffer, d, 1, 0), four_entries(buffer, d, 1, 3)
    return (
        -half * g0,
        -half * (2.0 * g0 + four_entries(buffer, d, 1, 1)),
        half * (2.0 * g3 + four_entries(buffer, d, 1, 2)),
        half * g3,
    )


@inlined
def means_of_rings(shape, buffer):
    """As `means_of_parts`, along the radius; with the factors of the radial component.

    Parts weigh with their mean radius. The rate of a cell between the radii a and b = a + h, with
    the middle m, has from a radial velocity (b v_b - a v_a)/(m h). From an axial one at a it has
    1/2 - h/(12 m) of what a cell of plane strain has, at b 1/2 + h/(12 m).
    """
    if class_of(shape).vertices() == 3:
        half, f, r = load(buffer, BOX), load(buffer, BOX + 4), load(buffer, BOX + 8)
        first, last, v = -load(buffer, PLAIN), load(buffer, PLAIN + 8), r - f
        p, q = first * (r - half + half * first) / r, last * (r + half - half * last) / r
        k, m = 1.0 / (v + 0.5), 1.0 / (v + 1.5)
        return (
            p * (0.5 - k * (1.0 / 12.0)),
            p * (0.5 + k * (1.0 / 12.0)) + q * (0.5 - m * (1.0 / 12.0)),
            q * (0.5 + m * (1.0 / 12.0)),
        ), (-p * k * v, (p * k - q * m) * (v + 1.0), q * m * (v + 2.0))
    half, f, r = load(buffer, BOX), load(buffer, BOX + 4), load(buffer, BOX + 8)
    first, last, v = -load(buffer, PLAIN), load(buffer, PLAIN + 12), r - f
    inner = 1.0 - first - last
    p, q = first * (r - half + half * first) / r, last * (r + half - half * last) / r
    s = inner * (r - half + half * (2.0 * first + inner)) / r
    k, n, m = 1.0 / (v + 0.5), 1.0 / (v + 1.5), 1.0 / (v + 2.5)
    return (
        p * (0.5 - k * (1.0 / 12.0)),
        p * (0.5 + k * (1.0 / 12.0)) + s * (0.5 - n * (1.0 / 12.0)),
        s * (0.5 + n * (1.0 / 12.0)) + q * (0.5 - m * (1.0 / 12.0)),
        q * (0.5 + m * (1.0 / 12.0)),
    ), (-p * k * v, (p * k - s * n) * (v + 1.0), (s * n - q * m) * (v + 2.0), q * m * (v + 3.0))


@inlined
def gradients_of_rings(shape, buffer):
    """The means of four particles' cells, in cells, of dv/dr and of v/r for a velocity v.

    Along the radius, tuples of Vec4. In a cell they are (v_b - v_a)/h and (v_a + v_b)/(2 m). Their
    sum has the factors of the radial component of `means_of_rings`.
    """
    if class_of(shape).vertices() == 3:
        half, f, r = load(buffer, BOX), load(buffer, BOX + 4), load(buffer, BOX + 8)
        first, last, v = -load(buffer, PLAIN), load(buffer, PLAIN + 8), r - f
        p, q = first * (r - half + half * first) / r, last * (r + half - half * last) / r
        a, b = 0.5 * p / (v + 0.5), 0.5 * q / (v + 1.5)
        return (-p, p - q, q), (a, a + b, b)
    half, f, r = load(buffer, BOX), load(buffer, BOX + 4), load(buffer, BOX + 8)
    first, last, v = -load(buffer, PLAIN), load(buffer, PLAIN + 12), r - f
    inner = 1.0 - first - last
    p, q = first * (r - half + half * first) / r, last * (r + half - half * last) / r
    s = inner * (r - half + half * (2.0 * first + inner)) / r
    a, b, c = 0.5 * p / (v + 0.5), 0.5 * s / (v + 1.5), 0.5 * q / (v + 2.5)
    return (-p, p - s, s - q, q), (a, a + b, b + c, c)


@inlined
def factor(mean, hoop, buffer, d, i, j):
    """Factors of direction `d` in dD_p/dv_v of its vertex `i`, for particle `j` of four.

    A vector like a velocity or a force in its record: g for the component along `d`, else a. An
    unused weight unless there is a `mean`. Along the radius there is a `hoop`, which is () else.
    """
    if is_empty(mean):
        return entry(buffer, d, 0, i, j)
    if not is_empty(hoop):
        return where(
            pack(0.0, 1.0, 2.0, 3.0) == 1.0,
            number(buffer, PLAIN + 4 * i + j),
            number(buffer, MEANS + 4 * i + j),
        )
    return where(
        pack(0.0, 1.0, 2.0, 3.0) == d + 1.0,
        entry(buffer, d, 1, i, j),
        number(buffer, MEANS + 16 * d + 4 * i + j),
    )


@inlined
def factors(mean, buffer, d, i, j, like):
    """The factors of the vertices i, i+1, ..., as many as `like` has."""
    return tuple(factor(mean, (), buffer, d, i + k, j) for k in range(len(like)))


@inlined
def factored(f, M):
    """The vector f M; () if M is ()."""
    if is_empty(M):
        return ()
    return f * M


@inlined
def plus_factored(f, M, V):
    """The vector f M + V; V if M is ()."""
    if is_empty(M):
        return V
    return f * M + V


@inlined
def no_rates(mean):
    """Initial value of the sums of velocities times factors; () unless there is a `mean`."""
    if is_empty(mean):
        return ()
    return vector(0.0)


@inlined
def keep_rates(M, buffer, j):
    """Store the sum M of velocities times factors of particle `j` of four in the buffer."""
    if is_empty(M):
        return None
    return store(buffer, GATHERED_RATES + 4 * j, M)
