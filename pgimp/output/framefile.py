"""One file, written by all ranks at once.

The HDF5 library says where in the file everything goes, see `pgimp.output.datasets`, and the space
is reserved. What the ranks then write goes straight to those places. So an error is one of this
rank's own, at once, while MPI's collective calls lose data on a full disk without an error, and
wait for ever for a rank that could not open the file.

Every write is checked for its length, and the sync at the end for its error: that is where a
kernel tells of what it could not bring to the disk. Reading back would add nothing, for that comes
from the kernel's memory, not from the disk.
"""

from __future__ import annotations

import os
import socket
import zlib
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple

import numpy as np

from pgimp.output.collective import explain
from pgimp.output.datasets import bytes_of, put

Array = np.ndarray

# Rows are taken together and written in blocks of so many, which stay in the core's cache.
_ROWS = 1 << 14


def blocks(count: int, size: int | None = None) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each block of so many rows; the last one may be shorter."""
    size = size or _ROWS
    for start in range(0, count, size):
        yield start, min(start + size, count)


class Written(NamedTuple):
    """A stretch of a file with the checksum (CRC-32) of what was written there."""

    start: int
    size: int
    checksum: int


class FrameFile:
    """A file that is there, open for writing on this rank.

    An error is kept, not raised, so that all ranks go on to the next collective call; the first
    one is in `error`.

    Parameters
    ----------
    path : Path
        The file.
    rank : int
        This rank.
    most : int, optional
        With it, checksums are made, and a stretch with one of its own gets no longer than this, in
        bytes, or hardly.

    Attributes
    ----------
    error : str or None
        What went wrong first on this rank.
    written : list of Written
        What this rank wrote, in the order of writing, if checksums are made.
    """

    def __init__(self, path: Path, rank: int, most: int | None = None) -> None:
        self.path = path
        self.error: str | None = None
        self.written: list[Written] = []
        self._most = most
        self._descriptor = -1
        self._thread: Thread | None = None
        try:
            # Never for reading too: a client of NFS would then write whole pages, others' rows
            # among them.
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        except OSError as error:
            self.error = explain(error)
            if rank > 0:
                self.error += (
                    f" on {socket.gethostname()}; the run directory must be on a file system that "
                    "all ranks share"
                )

    def write(self, place: int, block: Any) -> None:
        """Write to a place of the file.

        Parameters
        ----------
        place : int
            Of the first byte.
        block : ndarray or bytes
            What to write; an array in C order.
        """
        data = bytes_of(block) if isinstance(block, Array) else memoryview(block)
        if not data.nbytes or self.error:
            return
        try:
            put(self._descriptor, data, place)
        except OSError as error:
            self.error = explain(error)
            return
        if self._most is not None:
            start, size, checksum = place, 0, 0
            if self.written:
                before = self.written[-1]
                if before.start + before.size == place and before.size + len(data) <= self._most:
                    start, size, checksum = self.written.pop()
            checksum = zlib.crc32(data, checksum)
            self.written.append(Written(start, size + len(data), checksum))

    def close(self) -> None:
        """Close the file, with all that this rank wrote safe on the disk; wait until it is."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._sync()

    def close_later(self) -> None:
        """Begin to bring what this rank wrote to the disk, and do not wait; see `closed`."""
        # It needs no processor to speak of: the kernel has the data, the thread only waits.
        self._thread = Thread(target=self._sync, name=f"sync {self.path.name}", daemon=True)
        self._thread.start()

    @property
    def closed(self) -> bool:
        """Whether `close` would return at once."""
        return self._descriptor < 0

    def _sync(self) -> None:
        if self._descriptor < 0:
            return
        try:
            os.fdatasync(self._descriptor)
        except OSError as error:
            self.error = self.error or explain(error)
        finally:
            os.close(self._descriptor)
            self._descriptor = -1

    def abandon(self) -> None:
        """Close the file as it is, for it will be deleted."""
        if self._thread is None and self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
