"""A choice in place of a branch, for one particle and for several at once."""

from pgimp.jit.kernel import specialise
from pgimp.jit.vectors.kinds import is_mask
from pgimp.jit.vectors.simd import where


def choose(condition, a, b):
    """Of `a` and `b` the first where the condition is true, else the second; both are computed."""


@specialise(choose)
def _choose(condition, a, b):
    if is_mask(condition):
        return lambda condition, a, b: where(condition, a, b)
    return lambda condition, a, b: a if condition else b
