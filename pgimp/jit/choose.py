"""A choice in place of a branch, for one particle and for several at once."""

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.kinds import is_mask
from pgimp.jit.vectors.simd import where


@inlined
def choose(condition, a, b):
    """Of `a` and `b` the first where the condition is true, else the second; both are computed."""
    if is_mask(condition):
        return where(condition, a, b)
    return a if condition else b
