"""The file ``.vtkhdf`` that shows all frames of a run to VTK and ParaView as one series in time."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from pgimp.io.frames import vtkhdf
from pgimp.io.frames.mesh import Mesh
from pgimp.io.frames.writer import Writer
from pgimp.storage.atomic import write
from pgimp.storage.hdf5 import open_file
from pgimp.storage.image import Image

Array = np.ndarray

# Rewriting takes time with the number of frames: at most this share of a run's.
_SHARE = 0.01


class VtkSeries(Writer):
    """A temporal series of frames, whose datasets it shows without a copy.

    A field that a frame does not have is not a number there, or -1. So is each field of a frame
    that is lost later.

    Parameters
    ----------
    path : Path
        The file; its name ends in ``.vtkhdf``.
    """

    suffix: ClassVar[str] = ".vtkhdf"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._meshes: list[Mesh] = []
        self._stale = False
        self._next = 0.0

    @classmethod
    def begin(cls, file: Any) -> None:
        """See `Writer.begin`."""
        vtkhdf.add_group(file)

    def add(self, mesh: Mesh) -> None:
        """See `Writer.add`."""
        self._meshes.append(mesh)
        self._stale = True

    def restart(self) -> None:
        """See `Writer.restart`; without frames the file is deleted."""
        if self._meshes:
            self.write()
        else:
            self.path.unlink(missing_ok=True)

    def finish(self, last: bool = False) -> None:
        """See `Writer.finish`: unless that would take too large a share of the run's time."""
        began = perf_counter()
        if began >= self._next:
            self.write()
            ended = perf_counter()
            self._next = ended + (ended - began) / _SHARE

    def sync(self) -> None:
        """See `Writer.sync`."""
        self.write(durable=True)

    def close(self) -> None:
        """See `Writer.close`."""
        self.write()

    def write(self, durable: bool = False) -> None:
        """Rewrite the file with all frames so far, if it does not have them yet.

        Parameters
        ----------
        durable : bool
            Whether it must survive a crash of the machine.

        Raises
        ------
        OSError
            If it cannot be written; the older version then stays.
        """
        if not self._stale:
            return
        image = Image()
        with open_file(image, "w") as file:
            _fill(vtkhdf.begin(file, (2, 0)), self._meshes)
        image.seek(0)
        write(self.path, image.read(image.size), durable)
        self._stale = False


def _fill(group: Any, meshes: list[Mesh]) -> None:
    """Describe the frames to VTK: parts, offsets of each frame, and views of its datasets."""
    cut, nodes = meshes[0].cut, meshes[0].nodes
    most = max(mesh.cells for mesh in meshes)
    period = max(min(vtkhdf.PART, most) if cut else most, 1)
    number, parts = _parts(group, meshes)
    # VTK looks for a frame's offsets in `Offsets` behind those of its cells, by as many rows as
    # there are parts before it. They are the same in all frames, and repeat with the period.
    cells = -parts % (period + 1)
    points = _before([mesh.points for mesh in meshes])
    ids = _before([0 if cut else nodes * mesh.cells for mesh in meshes])
    steps = group.create_group("Steps", track_order=True)
    steps.attrs["NSteps"] = np.int64(len(meshes))
    vtkhdf.small(steps, "Values", [mesh.time for mesh in meshes], "<f8")
    for name, values in (
        ("PartOffsets", parts),
        ("NumberOfParts", number),
        ("PointOffsets", points),
        ("CellOffsets", cells[:, None]),
        ("ConnectivityIdOffsets", ids[:, None]),
    ):
        vtkhdf.small(steps, name, values)
    files = [mesh.relative.encode() for mesh in meshes]
    of_cells = meshes[0].of_cells
    data, offsets = group.create_group("PointData"), steps.create_group("PointDataOffsets")
    if of_cells:
        cell_data = group.create_group("CellData")
        cell_offsets = steps.create_group("CellDataOffsets")
        before = _before([mesh.cells for mesh in meshes])
    for name, (columns, dtype) in _fields(meshes).items():
        fill, begin = np.nan if dtype.kind == "f" else -1, points
        where = (group, "Points") if name == "position" else (data, name)
        if name in of_cells:
            where, begin = (cell_data, name), before
            vtkhdf.small(cell_offsets, name, before)
        elif name != "position":
            offsets[name] = steps["PointOffsets"]
        rows = [mesh.rows(name) for mesh in meshes]
        views = vtkhdf.Views(*where, int(begin[-1]) + rows[-1], dtype, columns, fill)
        for start, file, mesh, count in zip(begin.tolist(), files, meshes, rows, strict=True):
            if name in mesh.fields and mesh.fields[name].columns == columns:
                shape = (count, columns) if columns else (count,)
                views.add(start, count, file, f"/{name}".encode(), shape)
        views.create()
    if cut:
        vtkhdf.repeated(group, "Connectivity", period, 1, most)
    else:
        total = sum(nodes * mesh.cells for mesh in meshes)
        views = vtkhdf.Views(group, "Connectivity", total, np.int64)
        for start, file, mesh in zip(ids.tolist(), files, meshes, strict=True):
            shape = (mesh.cells, nodes)
            views.add(start, nodes * mesh.cells, file, b"/connectivity", shape)
        views.create()
    end = int((cells + parts).max()) + most + int(number.max())
    vtkhdf.repeated(group, "Offsets", period + 1, nodes, end)
    vtkhdf.cell_types(group, int(cells.max()) + most, nodes)


def _parts(group: Any, meshes: list[Mesh]) -> tuple[Array, Array]:
    """Write the sizes of the parts; return each frame's number of parts and its first part.

    Frames of the same size have the same parts. An empty part goes with a single one where another
    frame has several: VTK 9.7 reads no more parts of any frame if the first one has only one.
    """
    several = meshes[0].cut and max(mesh.points for mesh in meshes) > vtkhdf.PART
    first: dict[tuple[int, int], int] = {}
    sizes: list[tuple[int, int]] = []
    number, parts = [], []
    for mesh in meshes:
        key = mesh.points, mesh.cells
        own = [(n, n) for n in vtkhdf.cut_in_parts(mesh.points)] if mesh.cut else [key]
        if several and len(own) == 1:
            own.append((0, 0))
        if key not in first:
            first[key] = len(sizes)
            sizes += own
        number.append(len(own))
        parts.append(first[key])
    points, cells = np.array(sizes).T
    vtkhdf.small(group, "NumberOfPoints", points)
    vtkhdf.small(group, "NumberOfCells", cells)
    vtkhdf.small(group, "NumberOfConnectivityIds", meshes[0].nodes * cells)
    return np.array(number), np.array(parts)


def _before(counts: list[int]) -> Array:
    """Sum of the counts before each."""
    return np.cumsum([0, *counts[:-1]])


def _fields(meshes: list[Mesh]) -> dict[str, tuple[int, np.dtype]]:
    """Columns and type of each field of any frame, by name; of several types, the widest."""
    found: dict[str, tuple[int, np.dtype]] = {}
    for mesh in meshes:
        for name, (columns, dtype, _) in mesh.fields.items():
            known = found.get(name, (columns, np.dtype(dtype)))
            found[name] = known[0], np.promote_types(known[1], dtype)
    return dict(sorted(found.items()))
