"""One file, written by all ranks at once.

The HDF5 library lays out the file, see `pgimp.storage.datasets`, and its space is reserved. The
ranks then write directly to their offsets, so errors appear at once on their rank. MPI's collective
calls lose data on a full disk without an error, and wait for ever for a rank that could not open
the file.

A client of NFS caches pages and may write a whole page, with zeros where another node has written
meanwhile. So no two ranks write to the same block of the file. A rank writes the blocks that it
fills entirely. It sends its parts of other blocks, a few bytes at the edges of its rows, to the
rank that writes them.

Every write is checked for its length. The sync at the end is checked for errors: there a kernel
reports data that it could not write to the disk. When all ranks have closed the file, each opens it
again and verifies the checksums of another rank's data.
"""

from __future__ import annotations

import os
import socket
import zlib
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np

from pgimp.errors import explain
from pgimp.mpi.communicator import Communicator
from pgimp.storage.checksums import Written, first_wrong, word_sum
from pgimp.storage.datasets import bytes_of, put

Array = np.ndarray

#: Bytes of a block, counted from the file's first byte, that only one rank writes. It is a kernel's
#: largest page, so a block has whole pages on every machine.
BLOCK = 1 << 16
# Rows of a block that is collected and written; it fits into the core's cache.
_ROWS = 1 << 14


def blocks(count: int, size: int | None = None) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each block of `size` rows; the last may be shorter."""
    size = size or _ROWS
    for start in range(0, count, size):
        yield start, min(start + size, count)


class FrameFile:
    """An existing file, open for writing on this rank.

    Errors are stored, not raised, so that all ranks reach the next collective call; the first
    is in `error`.

    Parameters
    ----------
    comm : communicator
        Of all ranks; each opens the file. Creation is not collective.
    most : int, optional
        If given, checksums are stored, each for a part of about this many bytes at most.

    Attributes
    ----------
    error : str or None
        The first error on this rank.
    written : list of Written
        Data given to this rank, in this order, with CRC-32, if checksums are stored.
    """

    def __init__(self, path: Path, comm: Communicator, most: int | None = None) -> None:
        self.path = path
        self.error: str | None = None
        self.written: list[Written] = []
        self._ends: dict[int, int] = {}  # by where a piece ends its number
        self._comm = comm
        self._most = most
        # Checksums of this rank's data, for another rank; later, checksums to verify here.
        self._given: list[Written] = []
        self._to_verify: list[Written] = []
        self._several_nodes = False
        # Offsets and bytes of each block that this rank has only partly filled so far.
        self._parts: dict[int, list[tuple[int, bytes]]] = {}
        self._descriptor = -1
        self._thread: Thread | None = None
        try:
            # Write only: opened for reading too, a client of NFS would read each page first.
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        except OSError as error:
            self.error = explain(error)
            if comm.rank > 0:
                self.error += (
                    f" on {socket.gethostname()}; the run directory must be on a file system that "
                    "all ranks share"
                )

    def write(self, place: int, block: Any) -> None:
        """Write at an offset of the file; no byte may be written twice.

        Partial blocks are stored until `flush`.

        Parameters
        ----------
        place : int
            Offset of the first byte.
        block : ndarray or bytes
            Data; an array in C order.
        """
        data = bytes_of(block) if isinstance(block, Array) else memoryview(block)
        if not data.nbytes or self.error:
            return
        if self._comm.size == 1:
            self._put(place, data)
        else:
            self._given.append(Written(place, len(data), word_sum(data)))
            for start, part in self._whole_blocks(place, data):
                self._put(start, part)
        if self._most is not None:
            self._note(place, data, self._most)

    def _whole_blocks(self, place: int, data: memoryview) -> Iterator[tuple[int, memoryview]]:
        """Yield the blocks that these data complete; store the rest."""
        end = place + len(data)
        first = min(-(-place // BLOCK) * BLOCK, end)
        last = max(end // BLOCK * BLOCK, first)
        if first < last:
            yield first, data[first - place : last - place]
        for start, stop in ((place, first), (last, end)):
            if start == stop:
                continue
            part, number = data[start - place : stop - place], start // BLOCK
            kept = self._parts.setdefault(number, [])
            if len(part) + sum(len(old) for _, old in kept) < BLOCK:
                kept.append((start, bytes(part)))
            else:
                yield start, part
                yield from ((begin, memoryview(old)) for begin, old in self._parts.pop(number))

    def _put(self, place: int, data: memoryview) -> None:
        if not self.error:
            try:
                put(self._descriptor, data, place)
            except OSError as error:
                self.error = explain(error)

    def _note(self, place: int, data: memoryview, most: int) -> None:
        piece, number = Written(place, 0, 0), self._ends.pop(place, len(self.written))
        if number < len(self.written) and self.written[number].size + len(data) <= most:
            piece = self.written[number]
        else:
            number = len(self.written)
            self.written.append(piece)
        checksum = zlib.crc32(data, piece.checksum)
        self.written[number] = Written(piece.start, piece.size + len(data), checksum)
        self._ends[place + len(data)] = number

    def flush(self) -> None:
        """Write the partial blocks, each on one rank; collective, after all calls of `write`."""
        if self._comm.size == 1:
            return
        size, host = self._comm.size, socket.gethostname()
        leaving: list[tuple[str, list[tuple[int, bytes]], list[Written]]]
        leaving = [(host, [], []) for _ in range(size)]
        for number, parts in self._parts.items():
            leaving[number % size][1].extend(parts)
        self._parts.clear()
        # To a rank that is most likely on another node.
        leaving[(self._comm.rank + size // 2) % size][2].extend(self._given)
        hosts, parts_of, given = zip(*self._comm.alltoall(leaving), strict=True)
        for place, part in sorted(chain(*parts_of)):
            self._put(place, memoryview(part))
        self._to_verify = list(chain(*given))
        self._several_nodes = len(set(hosts)) > 1

    def close(self) -> None:
        """Close the file once all data of this rank are on the disk; waits for it."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._sync()

    def close_later(self) -> None:
        """Start the sync of this rank's data to the disk, without waiting; see `closed`."""
        # Hardly any CPU time: the kernel has the data, the thread only waits.
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

    def verify(self) -> None:
        """Compare the file with the written data, when all ranks have closed it.

        Each rank checks another rank's data. On one rank nothing is done: a kernel returns the
        written data.
        """
        if self._comm.size == 1:
            return
        try:
            descriptor = os.open(self.path, os.O_RDONLY | os.O_CLOEXEC)
            try:
                if self._several_nodes:
                    # Read from the server, not from the node's cache.
                    os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
                wrong = first_wrong(descriptor, self._to_verify, word_sum)
            finally:
                os.close(descriptor)
        except OSError as error:
            self.error = self.error or explain(error)
            return
        if wrong:
            self.error = self.error or (
                f"bytes {wrong.start} to {wrong.start + wrong.size} of {self.path} are not those "
                f"that were written there, read again on {socket.gethostname()}; the file system "
                "has lost some. Choose another place with -o."
            )

    def abandon(self) -> None:
        """Close the unfinished file, which is to be deleted."""
        if self._thread is None and self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
