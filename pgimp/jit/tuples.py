"""Tuples of numbers or vectors in kernels: arithmetic on them, rows of arrays to and from them."""

from math import isqrt

from pgimp.jit.kernel import inlined


@inlined
def scaled(a, V):
    """The tuple a V, of numbers or vectors."""
    return tuple(a * each for each in V)


@inlined
def joined(first, rest):
    """The tuple of `first` and the entries of `rest`."""
    return (first, *rest)


@inlined
def plus_scaled(a, V, U):
    """The tuple a V + U, of numbers or vectors."""
    return tuple(a * v + u for v, u in zip(V, U, strict=False))


@inlined
def three(V):
    """A vector of the scene as three numbers, zero in missing directions."""
    return V + (0.0,) * (3 - len(V))


@inlined
def squared(v):
    """Square of the length of a tuple."""
    if len(v) == 1:
        return v[0] * v[0]
    return v[0] * v[0] + squared(v[1:])


@inlined
def read(array, p, i, like):
    """Entries i, i+1, ... of row `p`, as many as `like` has."""
    return tuple(array[p, i + k] for k in range(len(like)))


@inlined
def write(array, p, i, values):
    """Set entries i, i+1, ... of row `p`."""
    for k, value in enumerate(values):
        array[p, i + k] = value


@inlined
def plus_first(x, S):
    """The sum of x and as many entries of S."""
    return tuple(a + b for a, b in zip(x, S, strict=False))


@inlined
def on_diagonal(k, A):
    """Whether entry `k` of a matrix is on its diagonal, as its zz is."""
    return k % (isqrt(len(A)) + 1) == 0 or k == len(A) - 1
