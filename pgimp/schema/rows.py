"""Rows of a table over time: what is before and after an instant, and what is wrong with them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import TypeVar

from pgimp.schema.problems import Problem

V = TypeVar("V")


def neighbours(rows: Sequence[tuple[float, V]], t: float) -> tuple[tuple[float, V], ...]:
    """Return the rows before and after `t`, the same row twice beyond the ends."""
    after = bisect_right(rows, t, key=lambda row: row[0])
    return rows[max(after - 1, 0)], rows[min(after, len(rows) - 1)]


def between(t: float, t0: float, t1: float, v0: float, v1: float) -> float:
    """Return the value at `t` of a line through two points."""
    if t0 == t1:
        return v0
    return v0 + (v1 - v0) / (t1 - t0) * (t - t0)


def row_problems(rows: Sequence[tuple[float, tuple[float, ...]]]) -> Iterator[Problem]:
    """Yield problems between rows: times that do not increase, overflow between values."""
    for i in range(1, len(rows)):
        (t0, v0), (t1, v1) = rows[i - 1], rows[i]
        if t1 <= t0:
            text = f"the times of a table must increase, but {t1!r} follows {t0!r}"
            yield Problem(("table", i, 0), text)
        elif len(v0) != len(v1):
            text = f"expected {len(v0)} values as in the row before, got {len(v1)}"
            yield Problem(("table", i, 1), text)
        elif not all(math.isfinite(between(t1, t0, t1, a, b)) for a, b in zip(v0, v1, strict=True)):
            text = "the change from the row before is too large for a float64"
            yield Problem(("table", i), text)
