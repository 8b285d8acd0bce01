"""Results of `gather` for four particles, as a vector a component in place of one a particle."""

from pgimp.jit.kernel import specialise
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, store

#: Size of four particles' results of `gather`: at most five vectors for each of four particles.
SUMS = 80


def keep_sums(buffer, j, U, A, D):
    """Store the results of `gather` for particle `j` in a buffer of 16 float64 a vector."""


@specialise(keep_sums)
def _keep_sums(buffer, j, U, A, D):
    directions = len(D)

    def keep(buffer, j, U, A, D):
        store(buffer, 4 * j, U)
        store(buffer, 16 + 4 * j, A)
        for d in range(directions):
            store(buffer, 32 + 16 * d + 4 * j, D[d])

    return keep


def repeat_sums(buffer, count, like):
    """Repeat the sums of the last of four particles, `count` - 1, for missing ones.

    `like` has an entry for each derivative.
    """


@specialise(repeat_sums)
def _repeat_sums(buffer, count, like):
    kept = 2 + len(like)

    def repeat(buffer, count, like):
        for j in range(count, 4):
            for i in range(kept):
                store(buffer, 16 * i + 4 * j, load(buffer, 16 * i + 4 * (count - 1)))

    return repeat


def _columns(buffer, i):
    """The first, second, third and fourth elements of the vectors `i` of four particles."""


@specialise(_columns)
def _columns_of(buffer, i):
    return lambda buffer, i: transpose(
        load(buffer, 16 * i),
        load(buffer, 16 * i + 4),
        load(buffer, 16 * i + 8),
        load(buffer, 16 * i + 12),
    )


def collected(buffer, i, like):
    """The components of the vectors `i` of four particles: for each direction a vector of four."""


@specialise(collected)
def _collected(buffer, i, like):
    if len(like) == 1:
        return lambda buffer, i, like: (_columns(buffer, i)[1],)
    if len(like) == 2:
        return lambda buffer, i, like: _columns(buffer, i)[1:3]
    return lambda buffer, i, like: _columns(buffer, i)[1:]


def gathered_mass(buffer):
    """Weighted sums of the masses of the vertices in the supports of four particles."""


@specialise(gathered_mass)
def _gathered_mass(buffer):
    return lambda buffer: _columns(buffer, 0)[0]


def held_weights(buffer):
    """Weighted sums of `HELD` over the vertices in the supports of four particles."""


@specialise(held_weights)
def _held_weights(buffer):
    return lambda buffer: _columns(buffer, 1)[0]


def gradients(buffer, i, like):
    """Velocity gradients of four particles, row-major, from the vectors `i`, ... of their sums."""


@specialise(gradients)
def _gradients(buffer, i, like):
    if len(like) == 1:
        return lambda buffer, i, like: collected(buffer, i, like)

    def gradients2(buffer, i, like):
        a, b = collected(buffer, i, like), collected(buffer, i + 1, like)
        return (a[0], b[0], a[1], b[1])

    def gradients3(buffer, i, like):
        a, b = collected(buffer, i, like), collected(buffer, i + 1, like)
        c = collected(buffer, i + 2, like)
        return (a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2])

    return gradients2 if len(like) == 2 else gradients3
