"""Tuples of numbers or vectors in kernels: arithmetic on them, rows of arrays to and from them."""

from pgimp.jit.kernel import specialise


def scaled(a, V):
    """The tuple a V, of numbers or vectors."""


@specialise(scaled)
def _scaled(a, V):
    if len(V) == 0:
        return lambda a, V: ()
    if len(V) == 1:
        return lambda a, V: (a * V[0],)
    return lambda a, V: (a * V[0], *scaled(a, V[1:]))


def joined(first, rest):
    """The tuple of `first` and the entries of `rest`."""


@specialise(joined)
def _joined(first, rest):
    return lambda first, rest: (first, *rest)


def plus_scaled(a, V, U):
    """The tuple a V + U, of numbers or vectors."""


@specialise(plus_scaled)
def _plus_scaled(a, V, U):
    if len(V) == 0:
        return lambda a, V, U: ()
    if len(V) == 1:
        return lambda a, V, U: (a * V[0] + U[0],)
    return lambda a, V, U: (a * V[0] + U[0], *plus_scaled(a, V[1:], U[1:]))


def squared(v):
    """Square of the length of a tuple."""


@specialise(squared)
def _squared(v):
    if len(v) == 1:
        return lambda v: v[0] * v[0]
    return lambda v: v[0] * v[0] + squared(v[1:])


def read(array, p, i, like):
    """Entries i, i+1, ... of row `p`, as many as `like` has."""


@specialise(read)
def _read(array, p, i, like):
    if len(like) == 1:
        return lambda array, p, i, like: (array[p, i],)
    return lambda array, p, i, like: (array[p, i], *read(array, p, i + 1, like[1:]))


def write(array, p, i, values):
    """Set entries i, i+1, ... of row `p`."""


@specialise(write)
def _write(array, p, i, values):
    def write_one(array, p, i, values):
        array[p, i] = values[0]

    if len(values) == 1:
        return write_one

    def write_all(array, p, i, values):
        array[p, i] = values[0]
        write(array, p, i + 1, values[1:])

    return write_all


def plus_first(x, S):
    """The sum of x and as many entries of S."""


@specialise(plus_first)
def _plus_first_of(x, S):
    if len(x) == 1:
        return lambda x, S: (x[0] + S[0],)
    return lambda x, S: (x[0] + S[0], *plus_first(x[1:], S[1:]))
