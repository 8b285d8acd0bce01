"""Vectors of four particles and the numbers of each: values, or tuples of them."""

from numba.core import types

from pgimp.jit.kernel import inlined, is_record, of_types
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
    return tuple(vector(each) for each in values) if _is_tuple(values) else vector(values)


@inlined
def vectors_as(values, like):
    """The values with vectors as long as `like` in place of numbers."""
    if not _is_tuple(values):
        return vector_as(values, like)
    return tuple(vector_as(each, like) for each in values)


@inlined
def half_of(values, i):
    """Vectors of the first or second four of eight particles, `i` a literal 0 or 1."""
    if is_vector(values):
        return halves(values)[i]
    return tuple(halves(each)[i] for each in values)


@inlined
def zeros(like):
    """Zero vectors, as many as `like` has entries."""
    return tuple(vector(0.0) for _ in like)


@inlined
def numbers(buffer, at, step, like):
    """Every `step`-th number of a buffer on the stack from `at` on, as many as `like` has."""
    return tuple(number(buffer, at + k * step) for k in range(len(like)))


@inlined
def of_lane(values, j):
    """The values of particle `j`; numbers belong to all."""
    if is_vector(values):
        return lane(values, j)
    if not _is_tuple(values):
        return values
    found = tuple(of_lane(each, j) for each in values)
    return named(values, found) if is_record(values) else found


@inlined
def with_lanes(values, j, one):
    """The vectors `values` with the numbers `one` for particle `j`."""
    if is_vector(values):
        return with_lane(values, j, one)
    return tuple(with_lane(each, j, part) for each, part in zip(values, one, strict=False))


@inlined
def where_all(mask, a, b):
    """Vectors of `a` where the mask is true, else of `b`."""
    if is_vector(a):
        return where(mask, a, b)
    return tuple(where(mask, one, other) for one, other in zip(a, b, strict=False))


@inlined
def and_finite(mask, values):
    """The mask, also false where one of the vectors `values` is not finite."""
    for each in values:
        mask = mask & (each - each == 0.0)
    return mask


@inlined
def and_positive(mask, margin):
    """The mask, also false where a vector is not above zero; a number does not change it."""
    if is_vector(margin):
        return mask & (margin > 0.0)
    return mask


@inlined
def sum_of(vector):
    """Sum of the elements of a vector of four."""
    return (lane(vector, 0) + lane(vector, 1)) + (lane(vector, 2) + lane(vector, 3))
