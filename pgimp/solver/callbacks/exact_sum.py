"""Sums of float64 of all ranks, as of numbers without rounding, rounded once.

Such a sum depends neither on the order nor on who has which number: a number is a whole number of
at most 53 bits times a power of two, and those of each power are added as whole numbers.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

#: Whole numbers by the power of two that they are multiplied with.
Parts = dict[int, int]

#: Bits of the lower half of a significand; sums of 2^36 halves fit 64 bits.
_HALF = 26


def parts_of(values: np.ndarray) -> Parts:
    """Return the sum of finite numbers, (n,), in parts."""
    significand, exponent = np.frexp(values)
    whole = np.ldexp(significand, 53).astype(np.int64)
    powers, which = np.unique(exponent.astype(np.int64) - 53, return_inverse=True)
    high, low = np.zeros((2, len(powers)), np.int64)
    np.add.at(high, which, whole >> _HALF)
    np.add.at(low, which, whole & ((1 << _HALF) - 1))
    each = zip(powers.tolist(), high.tolist(), low.tolist(), strict=True)
    return {power: (a << _HALF) + b for power, a, b in each}


def rounded(every: Iterable[Parts]) -> float:
    """Return the sum of parts, rounded once; infinite where no float64 is as large."""
    total: Parts = {}
    for parts in every:
        for power, whole in parts.items():
            total[power] = total.get(power, 0) + whole
    if not total:
        return 0.0
    least = min(total)
    whole = sum(value << (power - least) for power, value in total.items())
    try:
        return float(whole << least) if least >= 0 else whole / (1 << -least)
    except OverflowError:
        return float("inf") if whole > 0 else float("-inf")
