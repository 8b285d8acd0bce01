"""A series of files in the folder of frames, with the files that list them, see `Writer`.

The run does not wait for the disk. A file is written to the kernel's memory, synced to the disk
during the next steps, and only then renamed. So a file with its final name is complete, even after
a crash of the machine. The last file appears once it is on the disk, before a checkpoint at the
latest. It is lost if the run dies before that.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from typing import Any

from pgimp.errors import RunError, explain
from pgimp.io.frames.mesh import Mesh
from pgimp.io.frames.writers import writers_of
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.atomic import sync_folder
from pgimp.storage.unfinished import Unfinished


class Series(ABC):
    """Files of a run, one at a time, and the files that list them.

    Parameters
    ----------
    path : Path
        Path of the files that list the frames, without suffix; frames are in a folder beside it.
    pattern : re.Pattern
        Pattern of the file names; its group is the number.

    Attributes
    ----------
    written : int
        Number of renamed files, counted as if all had been requested.
    latest, step : float, int
        Simulated time of the last renamed file, and step of the last file begun, -1 before the
        first.
    size : int
        Bytes of the files written by this process, on rank 0.
    """

    def __init__(self, comm: Communicator, path: Path, pattern: re.Pattern[str]) -> None:
        self.folder = path.parent / "frames"
        self.comm = comm
        self.written = self.size = 0
        self.latest = 0.0
        self.step = -1
        self._writers, self._pattern = writers_of(path), pattern
        self._pending: tuple[Unfinished, Mesh] | None = None
        self._synced = 0

    @abstractmethod
    def enter(self, case: Any, sim: Any) -> None:
        """Use the output settings of a case, or of another stage of it."""

    @abstractmethod
    def write(self, sim: Any, number: int) -> None:
        """Write the present state as a frame, and finish the previous one; collective."""

    @abstractmethod
    def _listed(self, path: Path) -> Mesh:
        """Read the content of a file; a RunError if the file is wrong."""

    def _wait_for(self, file: Unfinished, mesh: Mesh) -> None:
        """Schedule a file for renaming at the next `finish`."""
        self._pending = file, mesh
        self.step = mesh.step

    @property
    def waiting(self) -> bool:
        """Whether the last file is not yet renamed; the same on every rank."""
        return self._pending is not None

    @property
    def ready(self) -> bool:
        """Whether this rank can finish the last file without waiting for the disk."""
        return self._pending is None or self._pending[0].ready

    def finish(self, last: bool = False) -> None:
        """Rename the last file when it is on the disk, unless already renamed; collective.

        Parameters
        ----------
        last : bool
            Whether it is the last file of the run.

        Raises
        ------
        RunError
            On every rank, if it could not be written completely; it then has no final name.
        """
        if self._pending is None:
            return
        file, mesh = self._pending
        self._pending = None

        def show() -> None:
            self.size += file.path.stat().st_size
            for writer in self._writers:
                writer.add(mesh)
                writer.finish(last)

        file.end(show)
        self.written += 1
        self.latest = mesh.time

    def sync(self, last: bool = False) -> None:
        """Ensure that all files so far survive a crash of the machine; collective.

        Parameters
        ----------
        last : bool
            Whether there are no further files.

        Raises
        ------
        RunError
            On every rank, if that is not possible.
        """
        self.finish(last)
        if self._synced == self.written and not last:
            return

        def names() -> None:
            try:
                for writer in self._writers if last else ():
                    writer.sync()
                sync_folder(self.folder)
            except OSError as error:
                raise RunError(f"cannot write to {self.folder}: {explain(error)}") from error

        on_root(self.comm, names)
        self._synced = self.written

    def close(self) -> None:
        """List all frames so far, if that is possible."""
        if self.comm.rank == 0:
            for writer in self._writers:
                with suppress(OSError):
                    writer.close()

    def resume(self, number: int) -> list[str]:
        """Continue after the first `number` files; later files are deleted; collective.

        Parameters
        ----------
        number : int
            Number of files at the checkpoint from which the run resumes.

        Returns
        -------
        list of str
            Errors of files that should exist; these are no longer listed.

        Raises
        ------
        RunError
            On every rank, if the folder cannot be read or written.
        """
        self.written = number
        notes, self.latest, self.step = on_root(self.comm, lambda: self._list_again(number))
        return notes

    def _missing(self, number: int, there: int) -> list[str]:
        """Messages on missing files before a number."""
        if there >= number:
            return []
        return [f"{number - there} of the {number} earlier frames are missing"]

    def _list_again(self, number: int) -> tuple[list[str], float, int]:
        time, step = 0.0, -1
        try:
            paths = {}
            for path in self.folder.iterdir():
                # Only regular files: reading a pipe of such a name could block.
                if path.is_file() and (match := self._pattern.fullmatch(path.name)):
                    paths[int(match[1])] = path
            before = sorted(i for i in paths if i < number)
            notes = self._missing(number, len(before))
            for path in (paths[i] for i in before):
                try:
                    mesh = self._listed(path)
                except RunError as error:
                    notes.append(f"{error}; {self._writers[0].path.name} goes on without it")
                    continue
                time, step = mesh.time, mesh.step
                for writer in self._writers:
                    writer.add(mesh)
            for writer in self._writers:
                writer.restart()
            for i in paths:
                if i >= number:
                    paths[i].unlink()
        except OSError as error:
            raise RunError(f"cannot go on in {self.folder}: {explain(error)}") from error
        return notes, time, step
