"""``pgimp compare DIR1 DIR2`` tells whether two runs have the same particles, bit for bit."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.output.fields import BY_RANKS, FIELDS
from pgimp.output.pairs import Pair
from pgimp.output.reader import Frame, Run

Array = np.ndarray

_BLOCK_ROWS = 1 << 17
_MOST_LINES = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line of a comparison.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser to add to.
    """
    parser.add_argument("first", metavar="DIR1", help="a run directory")
    parser.add_argument("second", metavar="DIR2", help="another run directory")
    parser.add_argument(
        "--rtol",
        type=float,
        default=0.0,
        metavar="R",
        help="let numbers differ by R times the larger of them (default: not at all)",
    )
    parser.add_argument(
        "--atol",
        type=float,
        default=0.0,
        metavar="A",
        help="let numbers differ by A besides (default: not at all)",
    )


class Tolerance(NamedTuple):
    """How far numbers may lie apart; with both zero they must have the same bits.

    Attributes
    ----------
    relative, absolute : float
        The difference may be `relative` times the larger magnitude, plus `absolute`.
    """

    relative: float = 0.0
    absolute: float = 0.0

    def differ(self, first: Array, second: Array) -> Array:
        """Tell which numbers differ; -0.0 and 0.0 have different bits, and equal NaNs are the same.

        Parameters
        ----------
        first, second : ndarray
            Of the same shape and type.

        Returns
        -------
        ndarray of bool
            Of that shape.
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
    """The largest difference of a field.

    Attributes
    ----------
    number : int
        How many rows differ.
    row, column : int
        Where the difference is largest.
    first, second : float
        The two values there.
    """

    number: int
    row: int
    column: int
    first: float
    second: float

    @property
    def difference(self) -> float:
        """Magnitude of the difference; infinite if only one of the values is a number."""
        if math.isnan(self.first) or math.isnan(self.second):
            return math.inf if math.isnan(self.first) != math.isnan(self.second) else 0.0
        return abs(self.first - self.second) if self.first != self.second else 0.0

    def __str__(self) -> str:
        """Word the two values and their difference."""
        return f"{self.first!r} and {self.second!r}, difference {self.difference:.3g}"


def execute(args: argparse.Namespace) -> int:
    """Compare two run directories.

    Parameters
    ----------
    args : argparse.Namespace
        What `add_arguments` declares.

    Returns
    -------
    int
        0 if they hold the same, 1 if not.

    Raises
    ------
    UsageError
        If a directory holds no run or no frame, or a tolerance makes no sense.
    RunError
        If a file cannot be read.
    """
    for name in ("rtol", "atol"):
        if not 0.0 <= getattr(args, name) < math.inf:
            raise UsageError(f"--{name} must be a number from 0 on.")
    tolerance = Tolerance(args.rtol, args.atol)
    first, second = Run(Path(args.first)), Run(Path(args.second))
    for run in (first, second):
        if not run.frames:
            raise UsageError(f"{run.path} holds no frame yet, so there is nothing to compare.")
    number = 0
    for number, line in enumerate(differences(first, second, tolerance), start=1):
        if number <= _MOST_LINES:
            print(line)
    if number > _MOST_LINES:
        print(f"... and {number - _MOST_LINES} further differences")
    if number:
        print(f"{args.first} and {args.second} differ")
        return 1
    exactly = "bit for bit" if tolerance == Tolerance() else f"within {_words(tolerance)}"
    print(
        f"{args.first} and {args.second} are the same {exactly}: {len(first)} frames of "
        f"{len(first.frame(-1))} particles, {len(first.history)} lines of history"
    )
    return 0


def differences(first: Run, second: Run, tolerance: Tolerance | None = None) -> Iterator[str]:
    """Find where two runs differ.

    Parameters
    ----------
    first, second : Run
        The runs.
    tolerance : Tolerance, optional
        What may differ by how much; by default nothing.

    Yields
    ------
    str
        A line about each difference: in the numbers of frames; in each common frame in the
        particles that there are, and in the fields of those that both have; in the history.

    Raises
    ------
    RunError
        If a file cannot be read.
    """
    tolerance = tolerance or Tolerance()
    frames: list[dict[int, Frame]] = [
        {frame.number: frame for frame in run.frames} for run in (first, second)
    ]
    for run, mine, others in ((first, frames[0], frames[1]), (second, frames[1], frames[0])):
        only = sorted(set(mine) - set(others))
        if only:
            yield f"{len(only)} of {len(mine)} frames are only in {run.path}: {_some(only)}"
    told = False
    for number in sorted(set(frames[0]) & set(frames[1])):
        one, two = frames[0][number], frames[1][number]
        if (kinds := _precisions(one, two)) and tolerance == Tolerance() and not told:
            told = True  # not again in each frame
            yield (
                f"frame {number} has numbers of {kinds[0]} in {first.path}, of {kinds[1]} in "
                f"{second.path} (output.precision), which have no bits in common; --rtol 1e-6 "
                "compares them"
            )
        yield from _frame(one, two, tolerance)
    yield from _history(first.history, second.history, tolerance)


def _some(numbers: Sequence[int] | Array) -> str:
    """Name the first of several numbers."""
    return ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "")


def _frame(first: Frame, second: Frame, tolerance: Tolerance) -> Iterator[str]:
    name = f"frame {first.number} (t = {first.time:.6g})"
    if first.step != second.step:
        yield f"{name}: step {first.step} and {second.step}"
    if tolerance.differ(np.array([first.time]), np.array([second.time])).any():
        yield f"{name}: time {first.time!r} and {second.time!r}"
    for one, other in ((first, second), (second, first)):
        for field in one.fields:
            if field not in other:
                yield f"{name}: only {one.path.parents[1]} has the field {field}"
    pair = Pair(first, second, _BLOCK_ROWS)
    if not pair.comparable:
        yield f"{name}: the particles have other ids or another order"
        return
    for frame, only in zip((first, second), pair.only, strict=True):
        if len(only):
            where = frame.path.parents[1]
            yield f"{name}: {len(only)} of {len(frame)} particles only in {where}: {_some(only)}"
    differ = _precisions(first, second) and tolerance == Tolerance()
    for field in first.fields:
        if field in ("id", *BY_RANKS) or field not in second:
            continue
        if not (differ and "f" in first.types[field]):
            yield from _field(name, field, pair, tolerance)


def _precisions(first: Frame, second: Frame) -> tuple[str, str] | None:
    """Return the types of position in two frames, unless they are the same."""
    kinds = [np.dtype(frame.types.get("position")).name for frame in (first, second)]
    return None if kinds[0] == kinds[1] else (kinds[0], kinds[1])


def _field(name: str, field: str, pair: Pair, tolerance: Tolerance) -> Iterator[str]:
    try:
        worst = _worst(pair, field, tolerance)
    except ValueError:
        yield f"{name}, {field}: of another shape or type"
        return
    if worst is not None:
        component = ""
        if field in FIELDS and FIELDS[field].components:
            component = f" {FIELDS[field].components.split()[worst.column]}"
        yield (
            f"{name}, {field}: {worst.number} of {len(pair)} particles differ, "
            f"worst is particle {pair.number(worst.row)}{component}: {worst}"
        )


def _worst(pair: Pair, field: str, tolerance: Tolerance) -> Worst | None:
    """Compare a field block by block; a ValueError says that the two are of different kinds."""
    number, worst = 0, None
    for start, one, two in pair.blocks(field):
        if one.shape != two.shape or one.dtype.kind != two.dtype.kind:
            raise ValueError(field)
        if one.dtype != two.dtype:
            if tolerance == Tolerance():
                raise ValueError(field)
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


def _history(first: Array, second: Array, tolerance: Tolerance) -> Iterator[str]:
    columns = [table.dtype.names or () for table in (first, second)]
    if columns[0] != columns[1]:
        odd = sorted(set(columns[0]) ^ set(columns[1]))
        yield f"history.csv: other columns ({', '.join(odd) or 'in another order'})"
    if len(first) != len(second):
        yield f"history.csv: {len(first)} and {len(second)} lines"
    lines = min(len(first), len(second))
    for column in columns[0]:
        if column not in columns[1]:
            continue
        one, two = first[column][:lines], second[column][:lines]
        rows = np.flatnonzero(tolerance.differ(one, two))
        if len(rows):
            at = rows[np.argmax(_distance(one[rows], two[rows]))]
            worst = Worst(len(rows), int(at), 0, one[at].item(), two[at].item())
            yield (
                f"history.csv, {column}: {worst.number} of {lines} lines differ, worst is line "
                f"{worst.row + 2}: {worst}"
            )


def _words(tolerance: Tolerance) -> str:
    parts = {"relative": tolerance.relative, "absolute": tolerance.absolute}
    return " and ".join(f"{value:g} {name}" for name, value in parts.items() if value)
