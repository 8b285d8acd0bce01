"""Reading the frames of the grid and of surfaces, and comparing them between two runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pgimp.io.results.frame import FOR_READERS, Reading, cell_fields
from pgimp.io.results.tolerance import Tolerance, moments, worst_of
from pgimp.io.rundir.ownfiles import GRID_FRAME, SURFACE_FRAME

Array = np.ndarray

_BLOCK_ROWS = 1 << 17
_AXES = "xyz"


class GridFrame:
    """The active part of the grid, or surfaces, at one time.

    Parameters
    ----------
    path : Path
        The frame's file.

    Attributes
    ----------
    number, time, step : int, float, int
        Number among the frames, simulated time, step after which it was written.
    types : dict of str to str
        Types of the quantities of vertices and cells, including `position`.
    of_cells : list of str
        Quantities of cells.
    bodies : list of str
        Names, by the index in the quantity ``body``, if there is one.
    vertices, cells : int
        Their numbers.

    Raises
    ------
    RunError
        If the file cannot be read; later on, when a part of it cannot.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        match = GRID_FRAME.fullmatch(path.name) or SURFACE_FRAME.fullmatch(path.name)
        self.number = int(match[1]) if match else 0
        with Reading(path) as file:
            self.time, self.step = float(file.attrs["time"]), int(file.attrs["step"])
            self.of_cells = cell_fields(file.attrs)
            self.bodies = [str(name) for name in file.attrs["bodies"]] if self.of_cells else []
            names = [name for name in file.names if name not in FOR_READERS]
            self.types = {name: file[name].dtype.newbyteorder("<").str for name in names}
            self.vertices, self.cells = len(file["position"]), len(file["connectivity"])

    def rows(self, name: str, first: int, last: int) -> Array:
        """Read rows of a dataset, from `first` to `last` (exclusive)."""
        with Reading(self.path) as file:
            return file[name][first:last]

    def __getitem__(self, name: str) -> Array:
        """Read a dataset."""
        return self.rows(name, 0, max(self.vertices, self.cells))

    def places(self, name: str, row: int) -> Array:
        """Return where a vertex is, or the middle of a cell."""
        if name not in self.of_cells:
            return self.rows("position", row, row + 1)[0]
        points = self.rows("connectivity", row, row + 1)[0]
        return np.mean([self.rows("position", int(p), int(p) + 1)[0] for p in points], axis=0)


def grid_frames(directory: Path) -> dict[int, GridFrame]:
    """Return the frames of the grid in a run directory by their numbers."""
    return _frames(directory, "grid")


def surface_frames(directory: Path) -> dict[int, GridFrame]:
    """Return the frames of surfaces in a run directory by their numbers."""
    return _frames(directory, "surface")


def _frames(directory: Path, series: str) -> dict[int, GridFrame]:
    pattern = {"grid": GRID_FRAME, "surface": SURFACE_FRAME}[series]
    paths = (directory / "frames").glob(f"{series}-*.h5")
    found = (GridFrame(path) for path in paths if pattern.fullmatch(path.name))
    return {frame.number: frame for frame in sorted(found, key=lambda frame: frame.number)}


def grid_differences(first: GridFrame, second: GridFrame, tolerance: Tolerance) -> Iterator[str]:
    """Find the differences of two frames of the grid, or of surfaces.

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
    series = "surface" if first.of_cells else "grid"
    name = f"{series} frame {first.number} (t = {first.time:.6g})"
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
            count = first.cells if field in first.of_cells else first.vertices
            worst = worst_of(_blocks(first, second, field, count), tolerance)
        except ValueError:
            yield f"{name}, {field}: of another shape or type"
            continue
        if worst:
            axis = f" {_AXES[worst.column]}" if first.rows(field, 0, 1).ndim > 1 else ""
            at, what = first.places(field, worst.row), "cells" if first.of_cells else "vertices"
            yield (
                f"{name}, {field}: {worst.number} of {count} {what} differ, worst is "
                f"that at ({', '.join(f'{x:.6g}' for x in at)}){axis}: {worst}"
            )


def _blocks(
    first: GridFrame, second: GridFrame, name: str, count: int
) -> Iterator[tuple[int, Array, Array]]:
    for begin in range(0, count, _BLOCK_ROWS):
        end = min(begin + _BLOCK_ROWS, count)
        yield begin, first.rows(name, begin, end), second.rows(name, begin, end)
