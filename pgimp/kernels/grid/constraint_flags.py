"""Codes of held velocity components at a vertex, by faces and constraints."""

from pgimp.jit.kernel import inner_kernel

#: The code of component d is this to the power d: so far apart that a weighted sum of codes gives
#: the greatest.
_APART = 1e12

#: Code of several components, and of constraints, which need not lie along a wall.
SEVERAL = _APART**3

#: Least weight of a vertex that counts as in a particle's support; less is rounding.
LEAST_WEIGHT = 1e-9


@inner_kernel
def also_held(code, d):
    """Code of the held components with component d added; `code` is the code so far, 0 for none."""
    one = (1.0, _APART, _APART * _APART)[d]
    return one if code == 0.0 or code == one else SEVERAL


@inner_kernel
def held_codes(d):
    """Bounds of a weighted sum of codes with the greatest at component d; 3: several.

    The next code at a weight below `LEAST_WEIGHT` counts as this one, which may then be missed.
    """
    one = (1.0, _APART, _APART * _APART, SEVERAL)[d]
    return LEAST_WEIGHT * one, LEAST_WEIGHT * _APART * one
