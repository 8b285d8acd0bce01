"""Errors from differences between runs on several cells, over time.

With an error E = C x^p, x being cells over those of the finest run, runs at 1, x1 and x2 differ by
q0 - q1 = C (1 - x1^p) and q1 - q2 = C (x1^p - x2^p). Two runs do not tell p: it is taken as 1, so
that of cells twice as large E is the whole difference. That is three times Richardson's error of a
method of second order, the factor of safety of Roache (J. Fluids Eng. 116, 1994) for two grids.
Three runs tell p, from the mean sizes of both differences over time (of squares it
would be 1/2 for a shock that is a few cells wide). It is kept within 1/2 and 2,
as methods here have no higher order, and differences that do not shrink say nothing of it (Eça and
Hoekstra, J. Comput. Phys. 262, 2014). An order above 1 counts as far as both differences go the
same way, by their correlation over time: those that do not may be small by chance. Their error has
the factor 1.25 of Roache for three grids.

Curves that oscillate cross each other, where their difference vanishes and the error does not. So
an error is the greatest in a part of the time around.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pgimp.utilities.accuracy.aligned import Curve, aligned

Array = np.ndarray

#: Bounds of the observed order, and the factor of safety on errors with it.
LEAST_ORDER, MOST_ORDER, SAFETY = 0.5, 2.0, 1.25
#: Order without an observed one.
ASSUMED = 1.0
#: Part of the whole time, on either side, of which the greatest error is taken.
AROUND = 0.05
#: Difference of runs over the mean of a curve's values, below which it is rounding.
_ROUNDING = 1e-12


class Estimate(NamedTuple):
    """The estimated errors of a column, and of functions of it."""

    curve: Curve  #: Of the finest run.
    others: tuple[Array, ...]  #: Of the other runs, at its times.
    sizes: tuple[float, ...]  #: Their cells over those of the finest run.
    order: float | None  #: The observed order, within its bounds; None if it is assumed.

    @property
    def errors(self) -> Array:
        """Errors at the times of the curve, (lines,); nan where a run has no value."""
        return _greatest_around(self.curve.times, self._of(self.curve.values, self.others))

    def of(self, function: Callable[[Array, Array], float]) -> tuple[float, float]:
        """Return a function of times and values, and its error.

        The error is not less than a tenth of the mean error over time: two runs may agree by
        chance.
        """
        times, found = self.curve.times, function(self.curve.times, self.curve.values)
        others = [np.array(function(times, values)) for values in self.others]
        error = float(self._of(np.array(found), others))
        errors = self._of(self.curve.values, self.others)
        known = errors[np.isfinite(errors)]
        least = 0.1 * float(known.mean()) if len(known) else 0.0
        return float(found), max(error, least)

    def _of(self, value: Array, others: Sequence[Array]) -> Array:
        p = ASSUMED if self.order is None else self.order
        error = np.abs(value - others[0]) / (self.sizes[0] ** p - 1.0)
        if len(others) > 1:
            span = self.sizes[1] ** p - self.sizes[0] ** p
            error = np.fmax(error, np.abs(others[0] - others[1]) / span)
        return error * (1.0 if self.order is None else SAFETY)


def estimate(curve: Curve, others: Sequence[tuple[float, Curve]]) -> Estimate:
    """Estimate the errors of a curve.

    Parameters
    ----------
    curve : Curve
        Of the finest run.
    others : sequence of (float, Curve)
        Cells over those of the finest run, above 1, and the curve. The two finest count.
    """
    known = sorted(others, key=lambda one: one[0])[:2]
    values = tuple(aligned(one, curve) for _, one in known)
    sizes = tuple(size for size, _ in known)
    return Estimate(curve, values, sizes, _order(curve, values, sizes))


def _order(curve: Curve, others: Sequence[Array], sizes: Sequence[float]) -> float | None:
    """Order from the mean sizes of the differences; None if two runs do not tell it."""
    if len(others) < 2:
        return None
    fine, coarse = curve.values - others[0], others[0] - others[1]
    both = np.isfinite(fine) & np.isfinite(coarse)
    least = _ROUNDING * np.abs(curve.values[both]).max(initial=0.0)
    first, second = (np.abs(one[both]).mean() if both.any() else 0.0 for one in (fine, coarse))
    if not (first > least and second > least):
        return MOST_ORDER if first <= least else LEAST_ORDER
    order = order_of(second / first, sizes)
    if order <= ASSUMED:
        return order
    alike = float(np.mean(fine[both] / first * (coarse[both] / second)))
    spread = np.sqrt(np.mean((fine[both] / first) ** 2) * np.mean((coarse[both] / second) ** 2))
    return min(order, ASSUMED + (MOST_ORDER - ASSUMED) * max(alike / float(spread), 0.0))


def order_of(ratio: float, sizes: Sequence[float]) -> float:
    """Return the order within its bounds from the ratio of the coarse to the fine difference."""
    (x1, x2), low, high = sizes, LEAST_ORDER, MOST_ORDER

    def excess(p: float) -> float:
        return float(ratio - (x2**p - x1**p) / (x1**p - 1.0))

    if excess(low) <= 0.0:
        return low
    for _ in range(50 if excess(high) < 0.0 else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return high


def _greatest_around(times: Array, errors: Array) -> Array:
    """Greatest value within `AROUND` of the whole time, at least of the lines beside, (lines,)."""
    if not len(times):
        return errors
    way = AROUND * (times[-1] - times[0])
    number = np.arange(len(times))
    low = np.minimum(np.searchsorted(times, times - way, "left"), np.maximum(number - 1, 0))
    high = np.maximum(np.searchsorted(times, times + way, "right"), number + 2)
    known = np.where(np.isfinite(errors), errors, -np.inf)
    found = np.array([known[i:j].max() for i, j in zip(low, high, strict=True)])
    return np.where(np.isfinite(errors), found, np.nan)


def edges(cell: Sequence[float]) -> str:
    """Edges of cells in words: one if all are the same to four digits."""
    texts = [f"{edge:.4g}" for edge in cell]
    return texts[0] if len(set(texts)) == 1 else " x ".join(texts)


def ratio_of(cell: Sequence[float], of: Sequence[float]) -> float:
    """Return the size of cells over that of others, in the direction where it is the greatest.

    Directions that keep their cells, as periodic ones of a few cells, have nothing to resolve.
    """
    return max(one / other for one, other in zip(cell, of, strict=True))
