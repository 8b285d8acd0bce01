"""Errors without an exact solution: differences from a curve's limit as cells shrink.

Richardson's extrapolation: if a quantity q has an error c x^p, its values at three sizes x give p
and the limit, (q1 - q2)/(q2 - q3) = (x1^p - x2^p)/(x2^p - x3^p). With two sizes, or three whose
differences do not shrink like a power, p is unknown. It is set to 1, which gives the larger error
(Roache, Verification and Validation in Computational Science and Engineering, 1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

#: Bounds of a plausible order: the methods here are of second order at most. A greater order
#: means that cells are still too coarse, or that another error dominates.
MIN_ORDER, MAX_ORDER = 0.5, 2.5


class Limit(NamedTuple):
    """Limit of a curve: the value, and the observed order, None if it is assumed to be 1."""

    value: float
    order: float | None


def limit(points: Sequence[tuple[float, float]]) -> Limit | None:
    """Extrapolate the values at the three least x to x = 0.

    Parameters
    ----------
    points : sequence of (x, value)
        Cell sizes, or equivalent numbers, in any order.

    Returns
    -------
    Limit or None
        None with fewer than two different x above zero.
    """
    found = sorted({x: value for x, value in points if x > 0.0}.items())[:3]
    if len(found) < 2:
        return None
    (x, q), (x1, q1) = found[:2]
    order = _order(found) if len(found) == 3 else None
    p = 1.0 if order is None else order
    return Limit(q + (q - q1) * x**p / (x1**p - x**p), order)


def _order(found: Sequence[tuple[float, float]]) -> float | None:
    """Order of three values at ascending x; None if it is not within the bounds."""
    (x3, q3), (x2, q2), (x1, q1) = found
    fine, coarse = q2 - q3, q1 - q2
    if not fine * coarse > 0.0:
        return 2.0 if fine == coarse == 0.0 else None

    def excess(p: float) -> float:
        return coarse / fine - (x1**p - x2**p) / (x2**p - x3**p)

    low, high = MIN_ORDER, MAX_ORDER
    if not excess(low) >= 0.0 >= excess(high):
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) >= 0.0 else (low, middle)
    return low
