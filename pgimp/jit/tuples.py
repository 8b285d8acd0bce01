"""Tuples of numbers or vectors in kernels: arithmetic on them, rows of arrays to and from them."""

from pgimp.jit.kernel import inlined


@inlined
def scaled(a, V):
    """The tuple a V, of numbers or vectors."""
    if len(V) == 0:
        return ()
    if len(V) == 1:
        return (a * V[0],)
    return (a * V[0], *scaled(a, V[1:]))


@inlined
def joined(first, rest):
    """The tuple of `first` and the entries of `rest`."""
    return (first, *rest)


@inlined
def plus_scaled(a, V, U):
    """The tuple a V + U, of numbers or vectors."""
    if len(V) == 0:
        return ()
    if len(V) == 1:
        return (a * V[0] + U[0],)
    return (a * V[0] + U[0], *plus_scaled(a, V[1:], U[1:]))


@inlined
def squared(v):
    """Square of the length of a tuple."""
    if len(v) == 1:
        return v[0] * v[0]
    return v[0] * v[0] + squared(v[1:])


@inlined
def read(array, p, i, like):
    """Entries i, i+1, ... of row `p`, as many as `like` has."""
    if len(like) == 1:
        return (array[p, i],)
    return (array[p, i], *read(array, p, i + 1, like[1:]))


@inlined
def write(array, p, i, values):
    """Set entries i, i+1, ... of row `p`."""
    if len(values) == 1:
        array[p, i] = values[0]
    else:
        array[p, i] = values[0]
        write(array, p, i + 1, values[1:])


@inlined
def plus_first(x, S):
    """The sum of x and as many entries of S."""
    if len(x) == 1:
        return (x[0] + S[0],)
    return (x[0] + S[0], *plus_first(x[1:], S[1:]))
