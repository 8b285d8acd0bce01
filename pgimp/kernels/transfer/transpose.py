"""Results of `gather` for four particles, as a vector a component in place of one a particle."""

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, store

#: Size of four particles' results of `gather`: at most five vectors for each of four particles.
SUMS = 80


@inlined
def keep_sums(buffer, j, U, A, D):
    """Store the results of `gather` for particle `j` in a buffer of 16 float64 a vector."""
    directions = len(D)
    store(buffer, 4 * j, U)
    store(buffer, 16 + 4 * j, A)
    for d in range(directions):
        store(buffer, 32 + 16 * d + 4 * j, D[d])


@inlined
def repeat_sums(buffer, count, like):
    """Repeat the sums of the last of four particles, `count` - 1, for missing ones.

    `like` has an entry for each derivative.
    """
    kept = 2 + len(like)
    for j in range(count, 4):
        for i in range(kept):
            store(buffer, 16 * i + 4 * j, load(buffer, 16 * i + 4 * (count - 1)))


@inlined
def _columns(buffer, i):
    """The first, second, third and fourth elements of the vectors `i` of four particles."""
    return transpose(*tuple(load(buffer, 16 * i + 4 * j) for j in range(4)))


@inlined
def collected(buffer, i, like):
    """The components of the vectors `i` of four particles: for each direction a vector of four."""
    return _columns(buffer, i)[1 : 1 + len(like)]


@inlined
def gathered_mass(buffer):
    """Weighted sums of the masses of the vertices in the supports of four particles."""
    return _columns(buffer, 0)[0]


@inlined
def held_weights(buffer):
    """Weighted sums of `HELD` over the vertices in the supports of four particles."""
    return _columns(buffer, 1)[0]


@inlined
def gradients(buffer, i, like):
    """Velocity gradients of four particles, row-major, from the vectors `i`, ... of their sums."""
    columns = tuple(collected(buffer, i + d, like) for d in range(len(like)))
    return tuple(column[d] for d in range(len(like)) for column in columns)
