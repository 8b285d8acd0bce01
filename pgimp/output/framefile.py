"""One HDF5 file, written by all ranks at once, and checked.

The HDF5 library makes the file, see `pgimp.output.datasets`: each dataset lies in one piece at a
known place, with its space reserved. What the ranks then write goes straight to those places. So an
error is one of this rank's own, at once, while MPI's collective calls lose data on a full disk
without an error, and wait for ever for a rank that could not open the file.
"""

from __future__ import annotations

import math
import os
import socket
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from pgimp.output.collective import explain

Array = np.ndarray

# Rows are written, summed up and read back in blocks of so many bytes.
_BLOCK = 4 << 20


class Share(Protocol):
    """Which rows are whose: `bounds` has where each rank's rows start, and the number of rows."""

    @property
    def comm(self) -> Any:
        """Communicator of all ranks."""

    @property
    def bounds(self) -> Sequence[int]:
        """Of one more entry than there are ranks."""


class Written(NamedTuple):
    """A stretch of a file with the checksum (CRC-32) of what was written there."""

    start: int
    size: int
    checksum: int


class FrameFile:
    """A file made by `datasets.create`, open for writing on every rank.

    An error is kept, not raised, so that all ranks go on to the next collective call; the first
    one is in `error`.

    Parameters
    ----------
    path : Path
        The file.
    rows : Share
        Which rows each rank has.
    offsets : dict of str to int
        From `datasets.create`.
    most : int, optional
        A stretch with a checksum of its own gets no longer than this, in bytes, or hardly.

    Attributes
    ----------
    written : list of Written
        What this rank wrote, in the order of writing.
    error : str or None
        What went wrong first on this rank.
    """

    def __init__(
        self, path: Path, rows: Share, offsets: dict[str, int], most: float = math.inf
    ) -> None:
        self.path = path
        self.offsets = offsets
        self.error: str | None = None
        self.written: list[Written] = []
        self._first = rows.bounds[rows.comm.rank]
        self._most = max(_BLOCK, most)
        self._descriptor = -1
        try:
            # Never for reading too: a client of NFS would then write whole pages, others' rows
            # among them.
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        except OSError as error:
            self.error = explain(error)
            if rows.comm.rank > 0:
                self.error += (
                    f" on {socket.gethostname()}; the run directory must be on a file system that "
                    "all ranks share"
                )

    def write(self, name: str, block: Array) -> None:
        """Write this rank's rows of a dataset.

        Parameters
        ----------
        name : str
            The dataset.
        block : ndarray, shape (n, ...)
            The rows, of the dataset's type, in C order.
        """
        if not block.nbytes or self.error:
            return
        place = self.offsets[name] + self._first * (block.nbytes // len(block))
        data = np.ravel(block).view(np.uint8).data
        for start in range(0, len(data), _BLOCK):
            part = data[start : start + _BLOCK]
            try:
                self._put(part, place + start)
            except OSError as error:
                self.error = explain(error)
                return
            self._note(part, place + start)

    def _put(self, data: memoryview, place: int) -> None:
        while data:
            count = os.pwrite(self._descriptor, data, place)
            data, place = data[count:], place + count

    def _note(self, data: memoryview, place: int) -> None:
        """Remember what lies in the file at a place, as one stretch with that before it."""
        start, size, checksum = place, 0, 0
        if self.written:
            before = self.written[-1]
            if before.start + before.size == start and before.size + len(data) <= self._most:
                start, size, checksum = self.written.pop()
        checksum = zlib.crc32(data, checksum)
        self.written.append(Written(start, size + len(data), checksum))

    def close(self) -> None:
        """Close the file, with all that was written safe on the disk."""
        if self._descriptor < 0:
            return
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            self.error = self.error or explain(error)
        finally:
            os.close(self._descriptor)
            self._descriptor = -1

    def check(self) -> str | None:
        """Read back what this rank wrote; return what is wrong with it, or None."""
        try:
            with open(self.path, "rb", buffering=0) as stream:
                for start, size, checksum in self.written:
                    stream.seek(start)
                    if checksum != checksum_of(stream, size):
                        return "it reads back different: the disk may be full or faulty"
        except OSError as error:
            return explain(error)
        return None


def checksum_of(stream: Any, size: int) -> int:
    """CRC-32 of the next `size` bytes of a stream, or of what is left of it."""
    checksum = 0
    while size > 0:
        part = stream.read(min(size, _BLOCK))
        if not part:
            break
        checksum = zlib.crc32(part, checksum)
        size -= len(part)
    return checksum
