"""The frames of a run: what each particle is and where, at the times that the case asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pgimp.errors import RunError
from pgimp.output.collective import explain, on_root
from pgimp.output.fields import ALWAYS, FIELDS
from pgimp.output.particlefile import ParticleFile
from pgimp.output.reader import Frame
from pgimp.output.rows import Rows
from pgimp.output.rundir import FRAME
from pgimp.output.xdmf import Collection


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
    file : ParticleFile
        How they are written.
    """

    def __init__(self, directory: Path, case: Any, sim: Any) -> None:
        self.folder = directory / "frames"
        self.comm = sim.comm
        self.written = 0
        self.latest = 0.0
        self.step = -1
        self.fields = [*ALWAYS, *(name for name in FIELDS if name in case.output.fields)]
        self.file = ParticleFile(case, sim.scene, self.fields)
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
        storage = sim.live()
        complete = not sim.scene.exits
        rows = Rows(self.comm, sim.particles.id[storage], storage, sim.count, complete)
        time, step = float(sim.time), int(sim.step)

        def show() -> None:
            self._collection.add(path, time, rows.count, self.fields)
            self._collection.write(durable=sim.finished)

        what = f"write the frame {path} at step {step}"
        self.file.write(path, sim.particles, rows, (time, step), what, show)
        self.written += 1
        self.latest, self.step = time, step

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
                # Anything else of such a name, as a pipe, could not be read without waiting.
                if path.is_file() and (match := FRAME.fullmatch(path.name)):
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
