"""What curves show of their columns: factors, sign, quotient, moving mean."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.units import labelled, scaled

Array = np.ndarray

_MOST_LINES = 1_000_000


class Changes(NamedTuple):
    """Changes of the columns of a figure."""

    #: factor, factor_x: On the columns, and on the one along the axis.
    factor: float = 1.0
    factor_x: float = 1.0
    over: str = ""  #: Column by which they are divided; empty for none.
    mean: int = 1  #: Lines over which a moving mean is taken, an odd number.

    def of(
        self, values: Mapping[str, Array], names: Sequence[str], across: str
    ) -> dict[str, Array]:
        """Return the columns as they are drawn.

        Parameters
        ----------
        values : mapping of str to ndarray
            Each of shape (lines,), also the divisor.
        names : sequence of str
            Those along the vertical axis.
        across : str
            The one along the horizontal axis, of which no mean is taken.
        """
        found = {across: self.factor_x * values[across]}
        for name in names:
            column = np.asarray(values[name], float)
            if self.over:
                below = values[self.over]
                column = column / np.where(below == 0.0, np.nan, below)
            if self.mean > 1:
                column = moving_mean(column, self.mean)
            found[name] = self.factor * column
        return found

    def label(self, text: str) -> str:
        """Return a label with what was done to its column."""
        return times(self.factor, self._changed(text))

    def labelled(self, text: str, unit: str) -> str:
        """Return the label of an axis of columns that have a unit without the changes."""
        return axis_label(self.factor, self._changed(text), "" if self.over else unit)

    def _changed(self, text: str) -> str:
        text = f"{text} / {self.over}" if self.over else text
        return f"mean {text}" if self.mean > 1 else text


def axis_label(factor: float, text: str, unit: str) -> str:
    """Return the label of an axis: with a factor in the unit if that has a prefix for it."""
    other = scaled(unit, factor) if factor != 1.0 else ""
    if other:
        return labelled(f"-{text}" if factor < 0.0 else text, other)
    return labelled(times(factor, text), unit)


def times(factor: float, text: str) -> str:
    """Return a label with a factor in front."""
    if factor == 1.0:
        return text
    return f"-{text}" if factor == -1.0 else f"{factor:g} x {text}"


def moving_mean(values: Array, lines: int) -> Array:
    """Return the mean over each value and those around it; at the ends over what is there.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The values; nan counts as none.
    lines : int
        Number of values, odd.
    """
    known = np.isfinite(values)
    half = lines // 2

    def sums(column: Array) -> Array:
        total = np.concatenate([[0.0], np.cumsum(column)])
        last = np.minimum(np.arange(len(column)) + half + 1, len(column))
        return total[last] - total[np.maximum(np.arange(len(column)) - half, 0)]

    counts = sums(known.astype(float))
    return sums(np.where(known, values, 0.0)) / np.where(counts > 0.0, counts, np.nan)


def add_arguments(group: argparse._ArgumentGroup) -> None:
    """Declare the options of changes."""
    group.add_argument("--factor", metavar="F", help="on all columns; --factor=-1 turns their sign")
    group.add_argument("--factor-x", metavar="F", help="likewise on the column along the axis")
    group.add_argument("--over", metavar="NAME", help="divide all columns by this one")
    group.add_argument(
        "--mean", metavar="LINES", help="moving means of all columns over an odd number of lines"
    )


def changes(args: argparse.Namespace) -> Changes:
    """Return the changes that the command line asks for.

    Raises
    ------
    UsageError
        If a value is wrong.
    """
    lines = args.mean or "1"
    if not lines.isdecimal() or not 1 <= int(lines) <= _MOST_LINES or int(lines) % 2 == 0:
        raise UsageError(f"--mean {lines}: an odd number of lines, such as 5")
    return Changes(
        _factor(args.factor, "--factor"),
        _factor(args.factor_x, "--factor-x"),
        args.over or "",
        int(lines),
    )


def _factor(text: str | None, option: str) -> float:
    try:
        value = 1.0 if text is None else float(text)
    except ValueError:
        value = 0.0
    if value == 0.0 or not np.isfinite(value):
        raise UsageError(f"{option} {text}: a number other than 0, such as -1 or 1e-3")
    return value
