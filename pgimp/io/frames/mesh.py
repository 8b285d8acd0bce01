"""Content of a frame, as the writers of all formats take it: points, cells and fields."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from pgimp.io.results.frame import FOR_READERS, Reading, cell_fields

#: Kinds of fields by their number of columns; of others, a matrix.
_KINDS = {0: "Scalar", 3: "Vector"}


class Column(NamedTuple):
    """A field of a frame: columns (0 for a scalar), type in the file, and kind.

    Kinds are those of `Field.kind`: ``Scalar``, ``Vector``, ``Matrix``, ``GlobalId``.
    """

    columns: int
    dtype: str
    kind: str


class Mesh(NamedTuple):
    """Points and cells of a frame, and its fields."""

    path: Path
    time: float
    step: int
    points: int
    cells: int
    nodes: int
    """Vertices of a cell."""
    fields: Mapping[str, Column]
    """By name, including `position`."""
    of_cells: frozenset[str] = frozenset()
    """Fields of cells; the others are of points."""

    def rows(self, name: str) -> int:
        """Return the number of rows of a field."""
        return self.cells if name in self.of_cells else self.points

    @property
    def cut(self) -> bool:
        """Whether it is cut in parts: particles are, as their cells do not share vertices."""
        return "id" in self.fields

    @property
    def series(self) -> str:
        """Name of the frame's series: particles, grid, rigid or surface."""
        return self.path.stem.partition("-")[0]

    @property
    def relative(self) -> str:
        """Name of the frame in the files that list all of them, which are above or beside it."""
        path = self.path
        return f"{path.parent.name}/{path.name}" if path.parent.name == "frames" else path.name


def columns(shapes: Mapping[str, tuple[int, str]]) -> dict[str, Column]:
    """Return fields by name, given columns and type of each."""
    return {
        name: Column(n, dtype, "GlobalId" if name == "id" else _KINDS.get(n, "Matrix"))
        for name, (n, dtype) in shapes.items()
    }


def described(path: Path, first: Iterable[str] = ()) -> Mesh:
    """Read the content of a frame; a RunError if the file is wrong.

    Fields named `first` come first, in this order.
    """
    with Reading(path) as file:
        there = [name for name in file.names if name not in FOR_READERS]
        names = [*(name for name in first if name in there), *there]
        shapes = {
            name: (file[name].shape[1] if file[name].ndim == 2 else 0, file[name].dtype.str)
            for name in dict.fromkeys(names)
        }
        cells = file["connectivity"].shape
        nodes = cells[1] if len(cells) == 2 else 1
        time, step = float(file.attrs["time"]), int(file.attrs["step"])
        points, of_cells = len(file["position"]), frozenset(cell_fields(file.attrs))
        return Mesh(path, time, step, points, cells[0], nodes, columns(shapes), of_cells)
