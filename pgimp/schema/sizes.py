"""Checks of whole numbers of cells and steps, and of vectors of one entry a direction."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator

from pgimp.schema.messages import describe
from pgimp.schema.problems import Problem

Problems = Iterator[Problem]

AXES = "xyz"

WHOLE = 1e-9
"""Relative tolerance of sizes in cells and of times in steps."""


def whole(total: float, part: float) -> tuple[int, bool]:
    """Return `total` over `part`, rounded, at least 1; and whether it is exact."""
    ratio = total / part
    if math.isinf(ratio):
        return sys.maxsize, False
    count = max(1, round(ratio))
    return count, abs(count * part - total) <= WHOLE * total


def nearest_whole(total: float, part: float) -> str:
    """Return the nearest multiple of `part`, at least one, in as few digits as possible."""
    value = whole(total, part)[0] * part
    texts = (f"{value:.{digits}g}" for digits in (6, 9, 12, 15))
    return next((text for text in texts if whole(float(text), part)[1]), repr(value))


def faces(dimensions: int) -> list[str]:
    """Return the names of the domain's faces."""
    return [f"{axis}-{side}" for axis in AXES[:dimensions] for side in ("min", "max")]


def length(path: tuple[str | int, ...], value: object, dimensions: int) -> Problems:
    """Check that a vector has one entry a direction."""
    if isinstance(value, tuple) and len(value) != dimensions:
        entries = "entry" if dimensions == 1 else "entries"
        yield Problem(
            path, f"expected {dimensions} {entries}, one a direction, got {describe(value)}"
        )
