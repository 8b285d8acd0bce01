"""A written file, not yet synced to the disk and renamed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pgimp.errors import RunError, explain
from pgimp.mpi.collective import agree, on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.framefile import FrameFile


class Unfinished:
    """A file written by all ranks, to be synced to the disk and renamed.

    Parameters
    ----------
    part, path : Path
        Its temporary and its final name.
    file : FrameFile
        The file on this rank.
    comm : communicator
        Of all ranks; creation is collective.
    what : str
        The action, for messages.
    """

    def __init__(
        self, part: Path, path: Path, file: FrameFile, comm: Communicator, what: str
    ) -> None:
        self.path = path
        self._part, self._file, self._comm, self._what = part, file, comm, what
        file.flush()
        file.close_later()

    @property
    def ready(self) -> bool:
        """Whether this rank's data are on the disk, so that `end` does not wait."""
        return self._file.closed

    def end(self, done: Callable[[], None]) -> None:
        """Wait for the disk and rename the file; collective.

        Parameters
        ----------
        done : callable
            Called on rank 0 after renaming.

        Raises
        ------
        RunError
            On every rank, if the file could not be written completely; it then does not exist.
        """

        def publish() -> None:
            with explained_errors(self._what):
                self._part.rename(self.path)
                done()

        with removed_on_error(self._part, self._comm):
            self._file.close()
            agree(self._comm, self._what, self._file.error)
            self._file.verify()
            agree(self._comm, self._what, self._file.error)
            on_root(self._comm, publish)


@contextmanager
def explained_errors(what: str) -> Iterator[None]:
    """Explain errors of the disk."""
    try:
        yield
    except OSError as error:
        raise RunError(f"cannot {what}: {explain(error)}") from error


@contextmanager
def removed_on_error(part: Path, comm: Communicator) -> Iterator[None]:
    """Delete an unfinished file after an error, on rank 0."""
    try:
        yield
    except BaseException:
        if comm.rank == 0:
            with suppress(OSError):
                part.unlink(missing_ok=True)
        raise
