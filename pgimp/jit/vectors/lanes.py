"""Vectors of four particles and the numbers of each: values, or tuples of them."""

from numba.core import types

from pgimp.jit.kernel import inlined, of_types
from pgimp.jit.outside import NumbaObject
from pgimp.jit.own import named
from pgimp.jit.vectors.kinds import is_vector
from pgimp.jit.vectors.simd import halves, lane, number, vector, vector_as, where, with_lane


@of_types
def _is_tuple(kind):
    return isinstance(kind, types.BaseTuple)


@of_types
def has_vectors(kind: NumbaObject) -> bool:
    """Whether values of a Numba type are vectors, or tuples with vectors in them."""
    return any(map(has_vectors, kind)) if _is_tuple(kind) else is_vector(kind)


@of_types
def lanes_of(kind: NumbaObject) -> int:
    """Number of lanes of the vectors in a Numba type."""
    if _is_tuple(kind):
        return next(filter(None, map(lanes_of, kind)), 0)
    return kind.lanes if is_vector(kind) else 0


@inlined
def vectors(values):
    """The values with vectors in place of numbers."""
    if not _is_tuple(values):
        return vector(values)
    if len(values) == 1:
        return (vector(values[0]),)
    return (vector(values[0]), *vectors(values[1:]))


@inlined
def vectors_as(values, like):
    """The values with vectors as long as `like` in place of numbers."""
    if not _is_tuple(values):
        return vector_as(values, like)
    if len(values) == 1:
        return (vector_as(values[0], like),)
    return (vector_as(values[0], like), *vectors_as(values[1:], like))


@inlined
def half_of(values, i):
    """Vectors of the first or second four of eight particles, `i` a literal 0 or 1."""
    if is_vector(values):
        return halves(values)[i]
    if len(values) == 1:
        return (halves(values[0])[i],)
    return (halves(values[0])[i], *half_of(values[1:], i))


@inlined
def zeros(like):
    """Zero vectors, as many as `like` has entries."""
    if len(like) == 0:
        return ()
    return (vector(0.0), *zeros(like[1:]))


@inlined
def numbers(buffer, at, step, like):
    """Every `step`-th number of a buffer on the stack from `at` on, as many as `like` has."""
    if len(like) == 0:
        return ()
    return (number(buffer, at), *numbers(buffer, at + step, step, like[1:]))


@inlined
def of_lane(values, j):
    """The values of particle `j`; numbers belong to all."""
    if is_vector(values):
        return lane(values, j)
    if not _is_tuple(values):
        return values
    if len(values) == 0:
        return ()
    if isinstance(values, types.BaseNamedTuple):
        return named(values, _each_of_lane(values, j))
    return _each_of_lane(values, j)


@inlined
def _each_of_lane(values, j):
    """The entries of a tuple for particle `j`, see `of_lane`, as a plain tuple."""
    if len(values) == 1:
        return (of_lane(values[0], j),)
    return (of_lane(values[0], j), *_each_of_lane(values[1:], j))


@inlined
def with_lanes(values, j, one):
    """The vectors `values` with the numbers `one` for particle `j`."""
    if is_vector(values):
        return with_lane(values, j, one)
    if len(values) == 1:
        return (with_lane(values[0], j, one[0]),)
    return (with_lane(values[0], j, one[0]), *with_lanes(values[1:], j, one[1:]))


@inlined
def where_all(mask, a, b):
    """Vectors of `a` where the mask is true, else of `b`."""
    if is_vector(a):
        return where(mask, a, b)
    if len(a) == 1:
        return (where(mask, a[0], b[0]),)
    return (where(mask, a[0], b[0]), *where_all(mask, a[1:], b[1:]))


@inlined
def and_finite(mask, values):
    """The mask, also false where one of the vectors `values` is not finite."""
    if len(values) == 0:
        return mask
    return and_finite(mask & (values[0] - values[0] == 0.0), values[1:])


@inlined
def and_positive(mask, margin):
    """The mask, also false where a vector is not above zero; a number does not change it."""
    if is_vector(margin):
        return mask & (margin > 0.0)
    return mask
