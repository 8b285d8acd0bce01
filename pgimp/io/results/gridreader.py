"""Reading the frames of the grid, and comparing them between two runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pgimp.io.results.frame import Reading
from pgimp.io.results.tolerance import Tolerance, moments, worst_of
from pgimp.io.rundir.ownfiles import GRID_FRAME
from pgimp.physics.columns import GRID

Array = np.ndarray

_BLOCK_ROWS = 1 << 17
_AXES = "xyz"


class GridFrame:
    """The active part of the grid at one time.

    Parameters
    ----------
    path : Path
        The frame's file.

    Attributes
    ----------
    number, time, step : int, float, int
        Number among the frames, simulated time, step after which it was written.
    types : dict of str to str
        Types of the vertices' quantities, including `position`.
    vertices, cells : int
        Their numbers.

    Raises
    ------
    RunError
        If the file cannot be read; later on, when a part of it cannot.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        match = GRID_FRAME.fullmatch(path.name)
        self.number = int(match[1]) if match else 0
        with Reading(path) as file:
            self.time, self.step = float(file.attrs["time"]), int(file.attrs["step"])
            names = ["position", *(name for name in GRID if name in file.names)]
            self.types = {name: file[name].dtype.newbyteorder("<").str for name in names}
            self.vertices, self.cells = len(file["position"]), len(file["connectivity"])

    def rows(self, name: str, first: int, last: int) -> Array:
        """Read rows of a dataset, from `first` to `last` (exclusive)."""
        with Reading(self.path) as file:
            return file[name][first:last]


def grid_frames(directory: Path) -> dict[int, GridFrame]:
    """Return the frames of the grid in a run directory by their numbers."""
    paths = (directory / "frames").glob("grid-*.h5")
    found = (GridFrame(path) for path in paths if GRID_FRAME.fullmatch(path.name))
    return {frame.number: frame for frame in sorted(found, key=lambda frame: frame.number)}


def grid_differences(first: GridFrame, second: GridFrame, tolerance: Tolerance) -> Iterator[str]:
    """Find the differences of two frames of the grid.

    Yields
    ------
    str
        A line per difference: in time and step, in cells and vertices. If these are equal, also in
        the vertex quantities that both have.

    Raises
    ------
    RunError
        If a file cannot be read.
    """
    name = f"grid frame {first.number} (t = {first.time:.6g})"
    yield from moments(name, first, second, tolerance)
    for one, other in ((first, second), (second, first)):
        for field in sorted(set(one.types) - set(other.types)):
            yield f"{name}: only {one.path.parents[1]} has {field}"
    for what in ("cells", "vertices"):
        counts = getattr(first, what), getattr(second, what)
        if counts[0] != counts[1]:
            yield f"{name}: {counts[0]} and {counts[1]} {what}"
            return
    kinds = [np.dtype(frame.types["position"]).name for frame in (first, second)]
    if kinds[0] != kinds[1] and tolerance == Tolerance():
        yield f"{name}: numbers of {kinds[0]} and of {kinds[1]}, which have no bits in common"
        return
    for field, count in (("connectivity", first.cells), ("position", first.vertices)):
        worst = worst_of(_blocks(first, second, field, count), tolerance)
        if worst:
            what = "cells" if field == "connectivity" else "vertices"
            yield f"{name}: {worst.number} of {count} {what} are in other places"
            return
    for field in first.types:
        if field == "position" or field not in second.types:
            continue
        try:
            worst = worst_of(_blocks(first, second, field, first.vertices), tolerance)
        except ValueError:
            yield f"{name}, {field}: of another shape or type"
            continue
        if worst:
            axis = "" if field == "mass" else f" {_AXES[worst.column]}"
            at = first.rows("position", worst.row, worst.row + 1)[0]
            yield (
                f"{name}, {field}: {worst.number} of {first.vertices} vertices differ, worst is "
                f"that at ({', '.join(f'{x:.6g}' for x in at)}){axis}: {worst}"
            )


def _blocks(
    first: GridFrame, second: GridFrame, name: str, count: int
) -> Iterator[tuple[int, Array, Array]]:
    for begin in range(0, count, _BLOCK_ROWS):
        end = min(begin + _BLOCK_ROWS, count)
        yield begin, first.rows(name, begin, end), second.rows(name, begin, end)
