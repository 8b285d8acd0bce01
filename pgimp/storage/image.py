"""HDF5's metadata of a file, in memory until its space on the disk is reserved."""

from __future__ import annotations

import io
from typing import Any


class Image(io.RawIOBase):
    """A file in memory for HDF5 that stores only written bytes.

    libhdf5 may crash after a disk ran full; an image in memory cannot run full. HDF5 writes only
    metadata to it; the data between have addresses, but no bytes.

    Attributes
    ----------
    parts : dict of (int, int) to bytes
        Written data, by offset and length, in the order of writing.
    size : int
        Bytes of the file.
    """

    def __init__(self) -> None:
        self.parts: dict[tuple[int, int], bytes] = {}
        self.size = 0
        self._place = 0

    def stretches(self) -> dict[int, bytes]:
        """Return the written data, by offset, in parts that neither overlap nor touch."""
        stretches: dict[int, bytes] = {}
        start = end = -1
        for begin, length in [*sorted(self.parts), (self.size + 1, 0)]:
            if begin > end:
                if start >= 0:
                    self.seek(start)
                    stretches[start] = self.read(end - start)
                start = begin
            end = max(end, begin + length)
        return stretches

    def readable(self) -> bool:
        """Return True: the file is readable."""
        return True

    def writable(self) -> bool:
        """Return True: the file is writable."""
        return True

    def seekable(self) -> bool:
        """Return True: the file is seekable."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Set the offset."""
        begin = {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: self.size}[whence]
        self._place = begin + offset
        return self._place

    def truncate(self, size: int | None = None) -> int:
        """Change the size."""
        self.size = self._place if size is None else size
        return self.size

    def write(self, data: Any) -> int:
        """Store the data at the offset."""
        key = (self._place, len(data))
        self.parts.pop(key, None)
        self.parts[key] = bytes(data)
        self._place += len(data)
        self.size = max(self.size, self._place)
        return len(data)

    def readinto(self, buffer: Any) -> int:
        """Read written data, and zeros between."""
        begin, end = self._place, max(self._place, min(self._place + len(buffer), self.size))
        view = memoryview(buffer).cast("B")
        view[: end - begin] = bytes(end - begin)
        for (start, length), data in self.parts.items():
            low, high = max(start, begin), min(start + length, end)
            if low < high:
                view[low - begin : high - begin] = data[low - start : high - start]
        self._place = end
        return end - begin
