"""Stress invariants in the laws of soils and fluids."""

from math import sqrt

from pgimp.jit.algebra import contract
from pgimp.jit.kernel import inlined

#: A number negligible beside any stress, for quotients of numbers that may both be zero.
TINY = 1e-300


@inlined
def mean(S):
    """A third of the trace of a symmetric tensor."""
    return (S[0] + S[1] + S[2]) * (1.0 / 3.0)


@inlined
def shear_stress(s):
    """The root of J2, sqrt(s : s/2), of a deviator s: the shear stress in simple shear."""
    return sqrt(0.5 * contract(s, s))
