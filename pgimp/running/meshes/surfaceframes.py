"""Frames of the surfaces of bodies that meet by them: pressure, slip and more, for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.frames.mesh import Mesh, columns, described
from pgimp.io.frames.particlefile import FORMAT_VERSION
from pgimp.io.frames.series import Series
from pgimp.io.frames.writers import begin_frame
from pgimp.io.results.frame import OF_CELLS
from pgimp.io.rundir.ownfiles import SURFACE_FRAME
from pgimp.mpi.collective import on_root
from pgimp.physics.columns import SURFACE
from pgimp.storage.atomic import temporary
from pgimp.storage.datasets import Dataset, lay_out
from pgimp.storage.framefile import FrameFile
from pgimp.storage.unfinished import Unfinished, explained_errors, removed_on_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.contact.surfaces.sheet import Sheets
    from pgimp.solver.simulation import Simulation

#: Fields that all of them have, and meanings.
_ALWAYS = {
    "body": "number of the body, rigid ones after the others",
    "normal": "unit normal, out of the body",
    "area": "area [length^(dimensions - 1)]",
}
_VECTORS = ("normal", "traction")


class SurfaceFrames(Series):
    """Writes the surfaces of bodies, if the case asks for them, and the files that list them.

    They have the numbers of the particles' frames. Rank 0 has all surfaces, and writes them.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title, the units and the quantities.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        super().__init__(sim.comm, directory / "surface", SURFACE_FRAME)
        self._sheets: Sheets | None = None
        self.enter(case, sim)

    def enter(self, case: Case, sim: Simulation) -> None:
        """Use the output settings of a case, or of another stage of it."""
        self.fields = [*_ALWAYS, *(name for name in SURFACE if name in case.output.surface)]
        self._asked, self._dimension = bool(case.output.surface), case.dimensions
        self._type = np.dtype(case.output.precision).newbyteorder("<").str
        self._names = [*sim.scene.body_names, *case.rigid_bodies]
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title),
            "units": str(case.units),
            "dimensions": case.dimensions,
            "bodies": self._names,
            OF_CELLS: self.fields,
        }

    def write(self, sim: Simulation, number: int) -> None:
        """Write the surfaces as the next frame, and finish the previous one; collective.

        Raises
        ------
        RunError
            On every rank, if there is no space for it, or if the previous frame could not be
            written completely.
        """
        if not self._asked:
            return
        if self._sheets is None:
            from pgimp.solver.contact.surfaces.sheet import Sheets

            self._sheets = Sheets()
        self.finish()
        path = self.folder / f"surface-{number:06d}.h5"
        part, what = temporary(path), f"write the frame {path} at step {sim.step}"
        time, step = float(sim.time), int(sim.step)
        sheet = self._sheets.sheet(sim.rank, time)
        counts = (len(sheet.position), len(sheet.cells)) if sheet else (0, 0)
        points, cells = self.comm.bcast(counts)
        attributes = self._attributes | {"time": time, "step": np.int64(step)}
        shapes = {name: self._shape(name) for name in ("position", *self.fields)}
        meaning = {"position": "position [length]"} | _ALWAYS | SURFACE
        datasets = [
            Dataset(name, kind, (3,) if n else (), {"meaning": meaning[name]})
            for name, (n, kind) in shapes.items()
        ]
        nodes = 2 ** (self._dimension - 1)

        def create() -> tuple[dict[str, int], dict[int, bytes]]:
            whole = {"connectivity": np.broadcast_to(np.int64(0), (cells, nodes))}
            layout = lay_out(datasets[:1], points, attributes, whole, 0, begin_frame, datasets[1:])
            with explained_errors(what):
                layout.create(part)
            return layout.offsets, layout.parts

        with removed_on_error(part, self.comm):
            offsets, says = on_root(self.comm, create)
            file = FrameFile(part, self.comm)
            if self.comm.rank == 0:
                for place, data in says.items():
                    file.write(place, data)
            if sheet:
                file.write(offsets["connectivity"], sheet.cells)
                for name, (_, kind) in shapes.items():
                    values = sheet.position if name == "position" else sheet.fields[name]
                    file.write(offsets[name], np.ascontiguousarray(values, kind))
            unfinished = Unfinished(part, path, file, self.comm, what)
        fields, of_cells = columns(shapes), frozenset(self.fields)
        mesh = Mesh(path, time, step, points, cells, nodes, fields, of_cells)
        self._wait_for(unfinished, mesh)

    def _shape(self, name: str) -> tuple[int, str]:
        """Columns, 0 for scalars, and type of a field."""
        if name == "body":
            return 0, "<i8"
        return 3 if name == "position" or name in _VECTORS else 0, self._type

    def resume(self, number: int) -> list[str]:
        """See `Series.resume`; nothing is done if there have never been frames of surfaces."""
        there = on_root(self.comm, self._writers[0].path.exists)
        return super().resume(number) if self._asked or there else []

    def _missing(self, number: int, there: int) -> list[str]:
        """No messages: frames of surfaces may have been requested only later."""
        return []

    def _listed(self, path: Path) -> Mesh:
        return described(path, ("position", *self.fields))
