"""Tolerances for the numbers of two runs, and their largest differences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol

import numpy as np

Array = np.ndarray


class Tolerance(NamedTuple):
    """Tolerance of numbers; with both zero they must have the same bits."""

    #: relative, absolute: Greatest difference: `relative` times the larger magnitude, plus
    #: `absolute`.
    relative: float = 0.0
    absolute: float = 0.0

    def differ(self, first: Array, second: Array) -> Array:
        """Mask of the numbers that differ; -0.0 and 0.0 have different bits, equal NaNs are equal.

        Parameters
        ----------
        first, second : ndarray
            Numbers of the same shape and type.

        Returns
        -------
        ndarray of bool
            Mask of that shape.
        """
        if first.dtype.kind != "f":
            return first != second
        bits = f"u{first.dtype.itemsize}"
        unequal = np.ascontiguousarray(first).view(bits) != np.ascontiguousarray(second).view(bits)
        if self.relative == self.absolute == 0.0 or not unequal.any():
            return unequal
        with np.errstate(invalid="ignore", over="ignore"):
            allowed = self.absolute + self.relative * np.maximum(np.abs(first), np.abs(second))
            near = (np.abs(first - second) <= allowed) & np.isfinite(first) & np.isfinite(second)
        same = near | (first == second) | (np.isnan(first) & np.isnan(second))
        return unequal & ~same


class Worst(NamedTuple):
    """The largest difference of a field."""

    number: int  #: Number of rows that differ.
    #: row, column: Row and column of the largest difference.
    row: int
    column: int
    #: first, second: The two values there.
    first: float
    second: float

    @property
    def difference(self) -> float:
        """Magnitude of the difference; infinite if only one of the values is a number."""
        if math.isnan(self.first) or math.isnan(self.second):
            return math.inf if math.isnan(self.first) != math.isnan(self.second) else 0.0
        return abs(self.first - self.second) if self.first != self.second else 0.0

    def __str__(self) -> str:
        """Format the two values and their difference."""
        return f"{self.first!r} and {self.second!r}, difference {self.difference:.3g}"


class Moment(Protocol):
    """Anything with a step and a time, such as a frame."""

    step: int
    time: float


def moments(name: str, first: Moment, second: Moment, tolerance: Tolerance) -> Iterator[str]:
    """Yield a line each if the steps or the times of two frames called `name` differ."""
    if first.step != second.step:
        yield f"{name}: step {first.step} and {second.step}"
    if tolerance.differ(np.array([first.time]), np.array([second.time])).any():
        yield f"{name}: time {first.time!r} and {second.time!r}"


def worst_of(blocks: Iterable[tuple[int, Array, Array]], tolerance: Tolerance) -> Worst | None:
    """Compare values block by block.

    Parameters
    ----------
    blocks : iterable of (int, ndarray, ndarray)
        Number of the first row, and (n,) or (n, k) values of each side.
    tolerance : Tolerance
        Allowed differences.

    Returns
    -------
    Worst or None
        None if nothing differs.

    Raises
    ------
    ValueError
        If the two are of different kinds.
    """
    number, worst = 0, None
    for start, one, two in blocks:
        if one.shape != two.shape or one.dtype.kind != two.dtype.kind:
            raise ValueError("other shapes or types")
        if one.dtype != two.dtype:
            if tolerance == Tolerance():
                raise ValueError("other types")
            one, two = one.astype(float), two.astype(float)
        one, two = one.reshape(len(one), -1), two.reshape(len(two), -1)
        different = tolerance.differ(one, two)
        rows, columns = np.nonzero(different)
        number += len(np.unique(rows))
        if len(rows):
            distance = _distance(one[rows, columns], two[rows, columns])
            at = int(np.argmax(distance))
            row, column = int(rows[at]), int(columns[at])
            found = Worst(0, start + row, column, one[row, column].item(), two[row, column].item())
            if worst is None or found.difference > worst.difference:
                worst = found
    return worst._replace(number=number) if worst else None


def _distance(first: Array, second: Array) -> Array:
    with np.errstate(invalid="ignore", over="ignore"):
        distance = np.abs(first.astype(float) - second.astype(float))
    return np.where(np.isnan(first) != np.isnan(second), np.inf, np.nan_to_num(distance, nan=0.0))


def tables(name: str, first: Array, second: Array, tolerance: Tolerance) -> Iterator[str]:
    """Find the differences of two tables.

    Parameters
    ----------
    name : str
        The file's, for messages.
    first, second : ndarray
        From `pgimp.storage.lines.read`.
    tolerance : Tolerance
        Allowed differences.

    Yields
    ------
    str
        A line per difference.
    """
    columns = [table.dtype.names or () for table in (first, second)]
    if columns[0] != columns[1]:
        odd = sorted(set(columns[0]) ^ set(columns[1]))
        yield f"{name}: other columns ({', '.join(odd) or 'in another order'})"
    if len(first) != len(second):
        yield f"{name}: {len(first)} and {len(second)} lines"
    lines = min(len(first), len(second))
    for column in columns[0]:
        if column not in columns[1]:
            continue
        worst = worst_of([(0, first[column][:lines], second[column][:lines])], tolerance)
        if worst:
            yield (
                f"{name}, {column}: {worst.number} of {lines} lines differ, worst is line "
                f"{worst.row + 2}: {worst}"
            )
