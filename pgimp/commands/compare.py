"""``pgimp compare DIR1 DIR2``: tests whether two runs have the same particles, bit for bit."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.gridreader import grid_differences, grid_frames, surface_frames
from pgimp.io.results.pairs import Pair
from pgimp.io.results.reader import Frame, Run
from pgimp.io.results.tolerance import Tolerance, moments, tables, worst_of
from pgimp.io.rundir.probefiles import PROBES
from pgimp.physics.fields import BY_RANKS

Array = np.ndarray

_BLOCK_ROWS = 1 << 17
_MOST_LINES = 20
_MESHES = {"frames of the grid": grid_frames, "frames of surfaces": surface_frames}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line of a comparison."""
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


def execute(args: argparse.Namespace) -> int:
    """Compare two run directories.

    Returns
    -------
    int
        0 if the results are the same, 1 if not.

    Raises
    ------
    UsageError
        If a directory has no run or no frame, or a tolerance is invalid.
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
    for note in only_in_one(first, second):
        print(f"note: {note}")
    number = 0
    for number, line in enumerate(differences(first, second, tolerance), start=1):
        if number <= _MOST_LINES:
            print(line)
    if number > _MOST_LINES:
        print(f"... and {number - _MOST_LINES} further differences")
    if number:
        print(f"{args.first} and {args.second} differ")
        return 1
    probes = len(first.probes.keys() & second.probes.keys())
    grids = len(grid_frames(first.path)) if grid_frames(second.path) else 0
    more = f", {probes} probe{'s' if probes > 1 else ''}" if probes else ""
    more += f", {grids} frames of the grid" if grids else ""
    surfaces = len(surface_frames(first.path)) if surface_frames(second.path) else 0
    more += f", {surfaces} frames of surfaces" if surfaces else ""
    exactly = "bit for bit" if tolerance == Tolerance() else f"within {_words(tolerance)}"
    print(
        f"{args.first} and {args.second} are the same {exactly}: {len(first)} frames of "
        f"{len(first.frame(-1))} particles, {len(first.history)} lines of history{more}"
    )
    return 0


def differences(first: Run, second: Run, tolerance: Tolerance | None = None) -> Iterator[str]:
    """Find the differences of two runs.

    Parameters
    ----------
    first, second : Run
        The runs.
    tolerance : Tolerance, optional
        Allowed differences; by default none.

    Yields
    ------
    str
        A line per difference: in the numbers of frames; in each common frame in the ids, and in
        the fields of common particles; in the history; in common probes, and frames of the grid
        and of surfaces.

    Raises
    ------
    RunError
        If a file cannot be read.
    """
    tolerance = tolerance or Tolerance()
    frames: list[dict[int, Frame]] = [
        {frame.number: frame for frame in run.frames} for run in (first, second)
    ]
    yield from _missing("frames", (first, second), frames)
    noted = False
    for number in sorted(set(frames[0]) & set(frames[1])):
        one, two = frames[0][number], frames[1][number]
        if (kinds := _precisions(one, two)) and tolerance == Tolerance() and not noted:
            noted = True  # only once, not in each frame
            yield (
                f"frame {number} has numbers of {kinds[0]} in {first.path}, of {kinds[1]} in "
                f"{second.path} (output.precision), which have no bits in common; --rtol 1e-6 "
                "compares them"
            )
        yield from _frame(one, two, tolerance)
    yield from tables("history.csv", first.history, second.history, tolerance)
    probes = first.probes, second.probes
    for name in sorted(probes[0].keys() & probes[1].keys()):
        yield from tables(f"{PROBES}/{name}.csv", probes[0][name], probes[1][name], tolerance)
    for what, found in _MESHES.items():
        meshes = found(first.path), found(second.path)
        if all(meshes):
            yield from _missing(what, (first, second), meshes)
        for number in sorted(meshes[0].keys() & meshes[1].keys()):
            yield from grid_differences(meshes[0][number], meshes[1][number], tolerance)


def only_in_one(first: Run, second: Run) -> Iterator[str]:
    """Yield parts of only one run, which are not compared: probes, frames of grid and surfaces.

    The particles may nevertheless be the same.
    """
    for one, other in ((first, second), (second, first)):
        names = sorted(one.probes.keys() - other.probes.keys())
        if names:
            what = "probe" if len(names) == 1 else "probes"
            yield f"only {one.path} has the {what} {', '.join(names)}"
        for what, found in _MESHES.items():
            if found(one.path) and not found(other.path):
                yield f"only {one.path} has {what}"


def _missing(
    what: str, runs: tuple[Run, Run], frames: Sequence[Mapping[int, object]]
) -> Iterator[str]:
    """Return the frames that are in only one run."""
    for run, mine, others in zip(runs, frames, frames[::-1], strict=True):
        only = sorted(set(mine) - set(others))
        if only:
            yield f"{len(only)} of {len(mine)} {what} are only in {run.path}: {_some(only)}"


def _some(numbers: Sequence[int] | Array) -> str:
    """Name the first of several numbers."""
    return ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "")


def _frame(first: Frame, second: Frame, tolerance: Tolerance) -> Iterator[str]:
    name = f"frame {first.number} (t = {first.time:.6g})"
    yield from moments(name, first, second, tolerance)
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
    """Return the types of position in two frames; None if they are the same."""
    kinds = [np.dtype(frame.types.get("position")).name for frame in (first, second)]
    return None if kinds[0] == kinds[1] else (kinds[0], kinds[1])


def _field(name: str, field: str, pair: Pair, tolerance: Tolerance) -> Iterator[str]:
    try:
        worst = worst_of(pair.blocks(field), tolerance)
    except ValueError:
        yield f"{name}, {field}: of another shape or type"
        return
    if worst is not None:
        names = pair.components(field)
        component = f" {names[worst.column]}" if names else ""
        yield (
            f"{name}, {field}: {worst.number} of {len(pair)} particles differ, "
            f"worst is particle {pair.number(worst.row)}{component}: {worst}"
        )


def _words(tolerance: Tolerance) -> str:
    parts = {"relative": tolerance.relative, "absolute": tolerance.absolute}
    return " and ".join(f"{value:g} {name}" for name, value in parts.items() if value)
