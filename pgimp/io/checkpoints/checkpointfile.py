"""A checkpoint on the disk, read defensively.

It is an HDF5 file after a user block with pgimp's own header. Reading uses only that header: the
HDF5 library can crash on a damaged file.
"""

from __future__ import annotations

import os
import weakref
import zlib
from math import prod
from pathlib import Path

import numpy as np

from pgimp.errors import DamagedError
from pgimp.io.checkpoints.checkpointheader import LAYOUT, Place, parse
from pgimp.io.checkpoints.checkpointwriter import write
from pgimp.storage.checksums import Written, first_wrong, read_into
from pgimp.storage.plain import open_plain

__all__ = ["LAYOUT", "CheckpointFile", "DamagedError", "write"]

Array = np.ndarray

# Beginning of HDF5's superblock of version 0, and where it is marked as open for writing.
_SUPERBLOCK, _MARK, _OPEN = b"\x89HDF\r\n\x1a\n\0", slice(20, 24), b"\1\0\0\0"

# Bytes read at once.
_BLOCK = 4 << 20


class CheckpointFile:
    """A checkpoint open for reading, with its header checked; `verify` checks the rest.

    Every rank opens it separately, without MPI. It is closed with its last reference.

    Parameters
    ----------
    path
        path-like.

    Attributes
    ----------
    path
        As given.
    size : int
        Bytes of the file.
    about : dict
        As given to `write`, with lists in place of tuples.
    count : int
        Number of rows.
    rows : dict of str to (dtype, tuple)
        Type and shape of a row of each dataset of rows.
    whole : dict of str to (dtype, tuple)
        Type and shape of the other datasets.

    Raises
    ------
    DamagedError
        If it cannot be read, is no checkpoint, or has changed since it was written. The message is
        one line, without the name of the file.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        try:
            stream = open_plain(self.path)
        except OSError as error:
            raise DamagedError(_cannot_read(error)) from None
        except ValueError:
            raise DamagedError("its name is no name of a file") from None
        weakref.finalize(self, stream.close)
        self._descriptor = stream.fileno()
        self.size = os.fstat(self._descriptor).st_size
        header, length = parse(self._read, self.size)
        for start in range(length, header.begin, _BLOCK):
            if self._read(start, min(_BLOCK, header.begin - start)).strip(b"\0"):
                raise DamagedError("something was written between its header and its data")
        self.about = header.about
        self.count = header.count
        self.rows = _shapes(header.rows)
        self.whole = _shapes(header.whole)
        self._header = header

    def verify(self, part: int, parts: int) -> None:
        """Compare the checksums of a part of the file, so that ranks can share the work.

        HDF5's mark of a file that another program has open for writing is no change of it.

        Parameters
        ----------
        part, parts : int
            Number of the part, from 0, and number of parts, about equal in size.

        Raises
        ------
        DamagedError
            If this part has changed since it was written.
        """
        begin = self._header.begin
        mine = [
            Written(start, size, checksum)
            for start, size, checksum in self._header.pieces
            if (start - begin + size // 2) * parts // (self.size - begin) == part
        ]
        try:
            wrong = first_wrong(self._descriptor, mine, zlib.crc32)
        except OSError as error:
            raise DamagedError(_cannot_read(error)) from None
        if wrong and not self._is_only_open(wrong):
            end = wrong.start + wrong.size
            raise DamagedError(f"bytes {wrong.start} to {end} do not have their checksum")

    def read(self, name: str, first: int, last: int) -> Array:
        """Read rows of a dataset.

        Parameters
        ----------
        name : str
            One of `rows`.
        first, last : int
            First row, and end (exclusive).

        Returns
        -------
        ndarray, shape (last - first, ...)
            The rows, in the machine's byte order.

        Raises
        ------
        DamagedError
            If the file has no such rows, or cannot be read.
        """
        if name not in self.rows or not 0 <= first <= last <= self.count:
            raise DamagedError(f"it has no rows {first} to {last} of {name}")
        place = self._header.rows[name]
        array = np.empty((last - first, *place.shape), place.dtype)
        self._fill(array, place.offset + place.extent(first))
        return array.astype(array.dtype.newbyteorder("="), copy=False)

    def read_whole(self, name: str) -> Array:
        """Read one of `whole`.

        Returns
        -------
        ndarray
            In the machine's byte order.

        Raises
        ------
        DamagedError
            If the file does not have it, or cannot be read.
        """
        if name not in self.whole:
            raise DamagedError(f"it has no {name}")
        place = self._header.whole[name]
        array = np.empty(place.shape, place.dtype)
        self._fill(array, place.offset)
        return array.astype(array.dtype.newbyteorder("="), copy=False)

    def read_part(self, name: str, first: int, last: int) -> Array:
        """Read rows `first` to `last` (exclusive) of one of `whole`.

        Raises
        ------
        DamagedError
            If the file does not have them, or cannot be read.
        """
        dtype, shape = self.whole.get(name, (np.dtype(float), (0,)))
        if not 0 <= first <= last <= shape[0]:
            raise DamagedError(f"it has no rows {first} to {last} of {name}")
        place = self._header.whole[name]
        array = np.empty((last - first, *shape[1:]), place.dtype)
        self._fill(array, place.offset + first * array[:0].itemsize * prod(shape[1:]))
        return array.astype(dtype, copy=False)

    def _read(self, start: int, length: int) -> bytes:
        data = memoryview(bytearray(length))
        return bytes(data[: self._read_into(data, start)])

    def _is_only_open(self, piece: Written) -> bool:
        """Whether a piece differs by nothing but the mark of HDF5's superblock, version 0."""
        if piece.start != self._header.begin or not _MARK.stop <= piece.size <= _BLOCK:
            return False
        data = bytearray(self._read(piece.start, piece.size))
        if data[:9] != _SUPERBLOCK or data[_MARK] != _OPEN:
            return False
        data[_MARK] = bytes(4)
        return zlib.crc32(data) == piece.checksum

    def _fill(self, array: Array, start: int) -> None:
        if array.size:
            view = array.reshape(-1).view(np.uint8).data
            if self._read_into(view, start) < len(view):
                raise DamagedError("it ends before its data")

    def _read_into(self, view: memoryview, start: int) -> int:
        """See `checksums.read_into`."""
        try:
            return read_into(self._descriptor, view, start)
        except OSError as error:
            raise DamagedError(_cannot_read(error)) from None


def _shapes(places: dict[str, Place]) -> dict[str, tuple[np.dtype, tuple[int, ...]]]:
    return {
        name: (np.dtype(place.dtype).newbyteorder("="), tuple(place.shape))
        for name, place in places.items()
    }


def _cannot_read(error: OSError) -> str:
    return f"it cannot be read: {os.strerror(error.errno)}" if error.errno else str(error)
