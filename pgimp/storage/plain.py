"""Reading foreign files without blocking or endless input.

Opening a named pipe waits for a writer, and a device may never end. In a folder from elsewhere any
file may be a pipe or a device.
"""

from __future__ import annotations

import os
import stat
import time
from typing import BinaryIO

#: Longest wait for data from a pipe [s].
PATIENCE = 5.0
_PAUSE = 0.02


def require_plain(name: str | os.PathLike[str]) -> None:
    """Raise an error for anything but a plain file.

    Raises
    ------
    OSError
        If there is no such file, or it is a directory, a pipe or a device.
    """
    _check(os.stat(name))


def _check(about: os.stat_result) -> None:
    if stat.S_ISDIR(about.st_mode):
        raise OSError("it is a folder")
    if not stat.S_ISREG(about.st_mode):
        raise OSError("it is no regular file")


def open_plain(name: str | os.PathLike[str]) -> BinaryIO:
    """Open a plain file for reading.

    Raises
    ------
    OSError
        As from `require_plain`, or if it cannot be read.
    """
    descriptor = os.open(name, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        _check(os.fstat(descriptor))
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


def read_plain(name: str | os.PathLike[str], most: int) -> bytes:
    """Return the content of a plain file.

    Parameters
    ----------
    name : path-like
        The file.
    most : int
        Most bytes of such a file.

    Raises
    ------
    OSError
        As from `open_plain`, or if it has more bytes.
    """
    with open_plain(name) as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise OSError(f"it is too large (at most {most:,} bytes)")
    return content


def read_some(name: str | os.PathLike[str], most: int) -> bytes:
    """Return the content of a file or pipe, at most `most` bytes.

    Raises
    ------
    OSError
        If it cannot be read, or sends nothing for `PATIENCE` seconds.
    """
    parts: list[bytes] = []
    left, until = most, time.monotonic() + PATIENCE
    descriptor = os.open(name, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        waits = stat.S_ISFIFO(os.fstat(descriptor).st_mode)
        while left > 0:
            try:
                part = os.read(descriptor, left)
            except BlockingIOError:  # open for writing elsewhere, but without data so far
                part = None
            if part:
                parts.append(part)
                left, until = left - len(part), time.monotonic() + PATIENCE
            elif part is not None and (parts or not waits):
                break
            elif time.monotonic() > until:
                raise OSError(f"nothing has come out of this pipe for {PATIENCE:g} s")
            else:
                time.sleep(_PAUSE)
    finally:
        os.close(descriptor)
    return b"".join(parts)
