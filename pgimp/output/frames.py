"""The frames of a run: what each particle is and where, at the times that the case asks for.

The run does not wait for the disk: a frame is written to the kernel's memory, brought to the disk
while the next steps go on, and only then gets its name. So what has a name is whole, also after a
crash of the machine; the last frame appears as soon as the disk has it, before a checkpoint at the
latest, and is lost if the run dies before that.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pgimp.errors import RunError
from pgimp.output.collective import explain, on_root
from pgimp.output.fields import ALWAYS, FIELDS
from pgimp.output.particlefile import ParticleFile
from pgimp.output.reader import Frame
from pgimp.output.rundir import FRAME
from pgimp.output.unfinished import Unfinished
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
        Number of frames that have their names.
    latest, step : float, int
        Simulated time of the last of these, and step of the last frame that was begun; the step
        is -1 before the first.
    size : int
        Bytes of the frames that this process wrote, on rank 0.
    """

    def __init__(self, directory: Path, case: Any, sim: Any) -> None:
        self.folder = directory / "frames"
        self.comm = sim.comm
        self.written = self.size = 0
        self.latest = 0.0
        self.step = -1
        self.fields = [*ALWAYS, *(name for name in FIELDS if name in case.output.fields)]
        compressed = case.output.compression != "none"
        self._file = ParticleFile(case, sim.scene, self.fields, case.output.precision, compressed)
        self._collection = Collection(directory / "particles.xdmf")
        self._pending: tuple[Unfinished, float, int] | None = None
        self._synced = 0

    def write(self, sim: Any) -> None:
        """Write the present state as the next frame, and finish the one before; collective.

        Parameters
        ----------
        sim : Simulation
            The run; it may go on at once.

        Raises
        ------
        RunError
            On every rank, if there is no room for the frame, or if the one before could not be
            written whole; then there is no file of its name, and the frames before it are as they
            were.
        """
        self.finish()
        path = self.folder / f"particles-{self.written:06d}.h5"
        storage = sim.live()
        rows = self._file.rows(
            self.comm, sim.particles.id[storage], storage, sim.count, not sim.scene.exits
        )
        time, step = float(sim.time), int(sim.step)
        what = f"write the frame {path} at step {step}"
        file = self._file.write(path, sim.particles, rows, (time, step), what)
        self._pending = file, time, rows.count
        self.step = step

    @property
    def waiting(self) -> bool:
        """Whether the last frame has no name yet; the same on every rank."""
        return self._pending is not None

    @property
    def ready(self) -> bool:
        """Whether this rank would not have to wait for the disk to finish the last frame."""
        return self._pending is None or self._pending[0].ready

    def finish(self, last: bool = False) -> None:
        """Give the last frame its name when it is on the disk, unless it has it; collective.

        Parameters
        ----------
        last : bool
            Whether it is the last one of the run.

        Raises
        ------
        RunError
            On every rank, if it could not be written whole; there is then no file of its name.
        """
        if self._pending is None:
            return
        file, time, count = self._pending
        self._pending = None

        def show() -> None:
            self.size += file.path.stat().st_size
            self._collection.add(file.path, time, count, self._file.types)
            self._collection.write(durable=last)

        file.end(show)
        self.written += 1
        self.latest = time

    def sync(self, last: bool = False) -> None:
        """See to it that all frames so far outlast a crash of the machine; collective.

        Parameters
        ----------
        last : bool
            Whether there will be no other.

        Raises
        ------
        RunError
            On every rank, if that is not possible.
        """
        self.finish(last)
        if self._synced == self.written:
            return

        def names() -> None:
            try:
                folder = os.open(self.folder, os.O_RDONLY)
                try:
                    os.fsync(folder)
                finally:
                    os.close(folder)
            except OSError as error:
                raise RunError(f"cannot write to {self.folder}: {explain(error)}") from error

        on_root(self.comm, names)
        self._synced = self.written

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
                types = {name: frame.types[name] for name in FIELDS if name in frame}
                self._collection.add(path, time, len(frame), types)
            self._collection.write()
            for i in paths:
                if i >= number:
                    paths[i].unlink()
        except OSError as error:
            raise RunError(f"cannot go on in {self.folder}: {explain(error)}") from error
        return notes, time, step
