"""Results of `gather` for a batch, transposed: from a vector a particle to one a component."""

from pgimp.jit.kernel import specialise
from pgimp.jit.simd import lane, load, store
from pgimp.jit.simdrows import transpose

#: Room for what `gather` gives of a batch: at most five vectors of four particles each.
SUMS = 80


def components(like, U):
    """The vector's components along the directions of the scene; `like` has that many entries."""


@specialise(components)
def _components(like, U):
    if len(like) == 1:
        return lambda like, U: (lane(U, 1),)
    if len(like) == 2:
        return lambda like, U: (lane(U, 1), lane(U, 2))
    return lambda like, U: (lane(U, 1), lane(U, 2), lane(U, 3))


def keep_sums(room, j, U, A, D):
    """Put what `gather` gave for the batch's particle `j` into a room of 16 float64 a vector."""


@specialise(keep_sums)
def _keep_sums(room, j, U, A, D):
    directions = len(D)

    def keep(room, j, U, A, D):
        store(room, 4 * j, U)
        store(room, 16 + 4 * j, A)
        for d in range(directions):
            store(room, 32 + 16 * d + 4 * j, D[d])

    return keep


def repeat_sums(room, count, like):
    """Let the sums of the batch's last particle, `count` - 1, stand for those missing."""


@specialise(repeat_sums)
def _repeat_sums(room, count, like):
    kept = 2 + len(like)

    def repeat(room, count, like):
        for j in range(count, 4):
            for i in range(kept):
                store(room, 16 * i + 4 * j, load(room, 16 * i + 4 * (count - 1)))

    return repeat


def _columns(room, i):
    """The first, second, third and fourth elements of the vectors `i` of a batch."""


@specialise(_columns)
def _columns_of(room, i):
    return lambda room, i: transpose(
        load(room, 16 * i), load(room, 16 * i + 4), load(room, 16 * i + 8), load(room, 16 * i + 12)
    )


def collected(room, i, like):
    """The components of the vectors `i` of a batch: for each direction a vector of four."""


@specialise(collected)
def _collected(room, i, like):
    if len(like) == 1:
        return lambda room, i, like: (_columns(room, i)[1],)
    if len(like) == 2:
        return lambda room, i, like: _columns(room, i)[1:3]
    return lambda room, i, like: _columns(room, i)[1:]


def held_weights(room):
    """Weighted sums of what the vertices in reach of a batch's particles have in `HELD`."""


@specialise(held_weights)
def _held_weights(room):
    return lambda room: _columns(room, 1)[0]


def gradients(room, i, like):
    """Velocity gradients of a batch, row-major, from the vectors `i`, `i` + 1, ... of its sums."""


@specialise(gradients)
def _gradients(room, i, like):
    if len(like) == 1:
        return lambda room, i, like: collected(room, i, like)

    def gradients2(room, i, like):
        a, b = collected(room, i, like), collected(room, i + 1, like)
        return (a[0], b[0], a[1], b[1])

    def gradients3(room, i, like):
        a, b = collected(room, i, like), collected(room, i + 1, like)
        c = collected(room, i + 2, like)
        return (a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2])

    return gradients2 if len(like) == 2 else gradients3
