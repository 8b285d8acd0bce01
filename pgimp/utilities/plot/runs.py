"""Runs and frames of a figure."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from pgimp.case.reader import read_document
from pgimp.errors import RunError, UsageError, explain
from pgimp.io.results.reader import Frame, Run
from pgimp.schema.document import LARGEST_FILE
from pgimp.storage.plain import read_plain
from pgimp.utilities.plot.units import labelled, unit

AXES = "xyz"
_MOST_PANELS = 12
_LATE = 1.0e-6


class PlotRun:
    """A run in a figure.

    Parameters
    ----------
    path : Path
        Its directory.
    name : str
        Its name in legends.

    Raises
    ------
    UsageError
        If the directory has no run.
    """

    def __init__(self, path: Path, name: str) -> None:
        if not path.is_dir():
            raise UsageError(f"there is no run directory {path}")
        self.run = Run(path)
        self.path = path
        self.name = name

    @cached_property
    def case(self) -> dict[str, Any]:
        """The case as resolved, as plain data, so that external materials are not needed."""
        path = self.path / "case.yaml"
        try:
            content = read_plain(path, LARGEST_FILE)
        except OSError as error:
            raise RunError(f"cannot read {path}: {explain(error)}") from error
        case = read_document(content, str(path)).data
        if case.get("dimensions") not in (1, 2, 3):
            raise RunError(f"{path} is damaged: it says no dimensions")
        return case

    @property
    def dimension(self) -> int:
        """Dimensions of the case: 1, 2 or 3."""
        return self.case["dimensions"]

    @cached_property
    def spacing(self) -> tuple[float, ...]:
        """Initial distance of the particles by axis; empty if the case does not tell it."""
        try:
            each = zip(
                self.case["grid"]["cell"], self.case["method"]["particles-per-cell"], strict=True
            )
            found = tuple(float(cell) / float(count) for cell, count in each)
        except (KeyError, TypeError, ValueError, ZeroDivisionError):
            return ()
        return found if len(found) == self.dimension else ()

    @property
    def corners(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners of the domain."""
        grid = self.case["grid"]
        origin = tuple(float(x) for x in grid["origin"])
        size = (float(x) for x in grid["size"])
        return origin, tuple(a + b for a, b in zip(origin, size, strict=True))

    @property
    def units(self) -> str:
        """Label of the case's units."""
        return str(self.case.get("units", ""))

    def unit(self, kind: str) -> str:
        """Return the unit of a kind of quantity; of rings totals are all round."""
        rings = self.case.get("geometry") == "axisymmetric"
        return unit(kind, self.units, 3 if rings else self.dimension)

    def label(self, text: str, kind: str) -> str:
        """Return the label of an axis for a kind of quantity, with its unit."""
        return labelled(text, self.unit(kind))

    def instant(self, time: float) -> str:
        """Return a time as in a title: ``t = 0.32 s``."""
        second = self.unit("time")
        return f"t = {time:.4g} {second}".rstrip()


def open_runs(directories: Sequence[str]) -> list[PlotRun]:
    """Open the runs, each with a unique name.

    Raises
    ------
    UsageError
        If one is no run, or named twice.
    """
    paths = [Path(os.path.normpath(name)) for name in directories]
    for path in paths:
        if paths.count(path) > 1:
            raise UsageError(f"{path} is named twice")
    short = [_short(path) for path in paths]
    unique = len(set(short)) == len(short)
    return [
        PlotRun(path, name if unique else str(path))
        for path, name in zip(paths, short, strict=True)
    ]


def _short(path: Path) -> str:
    return path.resolve().name.removesuffix(".out") or str(path)


class PlotFrame:
    """A frame in a figure."""

    def __init__(self, shown: PlotRun, frame: Frame) -> None:
        self.shown = shown
        self.frame = frame

    @property
    def title(self) -> str:
        """Title: the time."""
        return self.shown.instant(self.frame.time)


def _ended(shown: PlotRun) -> str:
    """Describe the progress of an unfinished run, for messages."""
    state = shown.run.state
    if state == "running":  # progress is written at the end
        return "; the run goes on, or was killed"
    return "" if state == "done" else f"; the run {state} at t = {shown.run.info['time']:g}"


def every_snapshot(shown: PlotRun) -> list[PlotFrame]:
    """Return all frames of a run with particles, for a movie.

    Raises
    ------
    UsageError
        If there is none.
    """
    found = [PlotFrame(shown, frame) for frame in shown.run.frames if len(frame)]
    if not found:
        raise UsageError(f"{shown.path} has no frame with particles")
    return found


def frames_of(shown: PlotRun, frames: Sequence[int], times: Sequence[float]) -> list[Frame]:
    """Find frames of a run by their numbers, else by times; parameters as for `snapshots`.

    Raises
    ------
    UsageError
        If the run has no such frame.
    """
    every = shown.run.frames
    if not every:
        more = " yet" if shown.run.state == "running" else "; output.every makes them"
        raise UsageError(f"{shown.path} has no frames{more}")
    found = []
    for number in frames:
        if not -len(every) <= number < len(every):
            raise UsageError(
                f"{shown.path} has no frame {number}: it has {len(every)}, "
                f"0 to {len(every) - 1} (or -1, the last)"
            )
        found.append(every[number])
    for time in times if not frames else ():
        first, last = every[0].time, every[-1].time
        slack = _LATE * max(abs(last), abs(first), 1e-300)
        if not first - slack <= time <= last + slack:
            raise UsageError(
                f"{shown.path} has no frame at time {time:g}: its frames go from "
                f"{first:g} to {last:g}{_ended(shown)}"
            )
        found.append(min(every, key=lambda frame: abs(frame.time - time)))
    return found


def snapshots(
    runs: Sequence[PlotRun], frames: Sequence[int], times: Sequence[float]
) -> list[PlotFrame]:
    """Find the frames to draw.

    Parameters
    ----------
    frames : sequence of int
        Numbers among the frames of each run; -1 is the last.
    times : sequence of float
        Simulated times: the nearest frame of each run. Used if `frames` is empty.

    Returns
    -------
    list of PlotFrame
        Run by run.

    Raises
    ------
    UsageError
        If a run has no such frame.
    """
    found = []
    for shown in runs:
        found += [PlotFrame(shown, frame) for frame in frames_of(shown, frames, times)]
    if len(found) > _MOST_PANELS:
        raise UsageError(f"{len(found)} frames in one figure; {_MOST_PANELS} is the most")
    dimensions = {snapshot.shown.dimension for snapshot in found}
    if len(dimensions) > 1:
        raise UsageError("the runs have different dimensions; draw them one at a time")
    return found
