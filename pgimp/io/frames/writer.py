"""Interface of the formats by which other programs read all frames of a run as one series."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

from pgimp.io.frames.mesh import Mesh


class Writer(ABC):
    """A file beside the frames that lists them; used on rank 0 alone.

    Parameters
    ----------
    path : Path
        The file; its name has the suffix of the format.
    """

    suffix: ClassVar[str]

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def begin(cls, file: Any) -> None:
        """Add to a frame's own file what the format needs there.

        Parameters
        ----------
        file : h5py.File
            The frame, open for writing, with all its datasets; their values need not be there yet.
        """

    @abstractmethod
    def add(self, mesh: Mesh) -> None:
        """Add a complete frame."""

    @abstractmethod
    def finish(self, last: bool = False) -> None:
        """Rewrite the file after a frame, the `last` one so that it survives a crash.

        Raises
        ------
        OSError
            If it cannot be written; the older version then stays.
        """

    @abstractmethod
    def restart(self) -> None:
        """Rewrite the file with the frames so far, as a run goes on; an OSError as of `finish`."""

    def sync(self) -> None:
        """Ensure that the file is complete and survives a crash; an OSError as of `finish`."""

    def close(self) -> None:
        """List all frames so far; an OSError as of `finish`."""
