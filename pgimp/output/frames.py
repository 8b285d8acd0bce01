"""The frames of a run: what each particle is and where, at the times that the case asks for."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from pgimp.case import fields as case_fields
from pgimp.errors import RunError
from pgimp.output.collective import agree, explain, on_root
from pgimp.output.fields import ALWAYS, FIELDS, Source
from pgimp.output.files import publish, temporary
from pgimp.output.framefile import Dataset, FrameFile, create, reachable
from pgimp.output.hdf5 import parallel
from pgimp.output.reader import Frame
from pgimp.output.rows import Rows
from pgimp.output.rundir import FRAME
from pgimp.output.xdmf import Collection

FORMAT_VERSION = 1
MEANING = case_fields.ALWAYS | case_fields.FIELDS
CONNECTIVITY = Dataset(
    "connectivity", "<i8", (), {"meaning": "the row itself, for the cells of XDMF readers"}
)


class Frames:
    """Writes the frames of a run and the XDMF file that lists them.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title, the units and the optional fields.
    sim : Simulation
        The run.

    Attributes
    ----------
    written : int
        Number of frames so far.
    latest, step : float, int
        Simulated time and step of the last of them; the step is -1 before the first.
    parallel : bool
        Whether all ranks write at once; else the frames go through rank 0.
    """

    def __init__(self, directory: Path, case: Any, sim: Any) -> None:
        self.folder = directory / "frames"
        self.comm = sim.comm
        self.written = 0
        self.latest = 0.0
        self.step = -1
        self.parallel = parallel(self.comm)
        self.fields = [*ALWAYS, *(name for name in FIELDS if name in case.output.fields)]
        scene = sim.scene
        names = {"body": list(scene.body_names), "material": list(scene.material_names)}
        self._datasets = [CONNECTIVITY] + [
            Dataset(
                name,
                field.dtype,
                (field.columns,) if field.columns else (),
                {"meaning": MEANING[name].meaning}
                | ({"components": field.components.split()} if field.components else {})
                | ({"names": names[name]} if name in names else {}),
            )
            for name, field in ((name, FIELDS[name]) for name in self.fields)
        ]
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title or ""),
            "units": str(case.units or ""),
            "dimensions": scene.dimension,
            "bodies": names["body"],
            "materials": names["material"],
        }
        self._collection = Collection(directory / "particles.xdmf")

    def write(self, sim: Any) -> None:
        """Write the present state as the next frame; collective.

        Parameters
        ----------
        sim : Simulation
            The run.

        Raises
        ------
        RunError
            On every rank, if the frame could not be written whole; then there is no file of its
            name, and the frames before it are as they were.
        """
        path = self.folder / f"particles-{self.written:06d}.h5"
        what = f"write the frame {path} at step {sim.step}"
        part = temporary(path)
        storage = sim.live()
        rows = Rows(self.comm, sim.particles.id[storage], storage, sim.count)
        try:
            offsets = on_root(self.comm, lambda: self._create(part, sim, what))
            if self.parallel:
                agree(self.comm, what, reachable(part))
            self._fill(part, sim, rows, offsets, what)
            on_root(self.comm, lambda: self._publish(part, path, sim, what))
        except BaseException:
            if self.comm.rank == 0:
                with suppress(OSError):
                    part.unlink(missing_ok=True)
            raise
        self.written += 1
        self.latest, self.step = float(sim.time), int(sim.step)

    def resume(self, number: int) -> list[str]:
        """Go on after the first `number` frames; later ones are deleted; collective.

        Parameters
        ----------
        number : int
            How many there were when the state was kept from which the run goes on.

        Returns
        -------
        list of str
            What is wrong with frames that should be there; those are not listed any more.

        Raises
        ------
        RunError
            On every rank, if the folder cannot be read or written.
        """
        self.written = number
        notes, self.latest, self.step = on_root(self.comm, lambda: self._list_again(number))
        return notes

    def _list_again(self, number: int) -> tuple[list[str], float, int]:
        notes, time, step = [], 0.0, -1
        try:
            paths = {}
            for path in self.folder.iterdir():
                if match := FRAME.fullmatch(path.name):
                    paths[int(match[1])] = path
            before = sorted(i for i in paths if i < number)
            if len(before) < number:
                notes.append(f"{number - len(before)} of the {number} earlier frames are missing")
            for path in (paths[i] for i in before):
                try:
                    frame = Frame(path)
                except RunError as error:
                    notes.append(f"{error}; particles.xdmf goes on without it")
                    continue
                time, step = frame.time, frame.step
                fields = [name for name in FIELDS if name in frame]
                self._collection.add(path, time, len(frame), fields)
            self._collection.write()
            for i in paths:
                if i >= number:
                    paths[i].unlink()
        except OSError as error:
            raise RunError(f"cannot go on in {self.folder}: {explain(error)}") from error
        return notes, time, step

    def _create(self, part: Path, sim: Any, what: str) -> dict[str, int]:
        state = {"time": float(sim.time), "step": np.int64(sim.step)}
        try:
            return create(part, self._datasets, sim.count, state | self._attributes)
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error

    def _fill(self, part: Path, sim: Any, rows: Rows, offsets: dict[str, int], what: str) -> None:
        scene = sim.scene
        source = Source(sim.particles, rows.storage, scene.dimension, tuple(scene.body_material))
        file = FrameFile(part, rows, self.parallel, offsets)
        agree(self.comm, what, file.error)
        file.write(CONNECTIVITY.name, np.arange(rows.first, rows.last, dtype=CONNECTIVITY.dtype))
        for name in self.fields:
            field = FIELDS[name]
            values = np.asarray(field.values(source), dtype=field.dtype)
            file.write(name, rows.collect(values))
        file.close()
        agree(self.comm, what, file.error)
        agree(self.comm, what, file.check())

    def _publish(self, part: Path, path: Path, sim: Any, what: str) -> None:
        try:
            publish(part, path)
            self._collection.add(path, float(sim.time), sim.count, self.fields)
            self._collection.write()
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error
