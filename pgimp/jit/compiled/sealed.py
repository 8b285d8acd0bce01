"""Trusted files: complete ones that only this user may have written.

Compiled kernels are pickles and machine code: one flipped bit may crash the process that loads
them, and another user's data would be executed. So each file starts with the checksum of the rest,
which is verified before the data are used.
"""

import os
import stat
import tempfile
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

_MAGIC = b"pgimp kernel 1\n"
_START = len(_MAGIC) + sha256().digest_size


class UntrustedError(Exception):
    """A file is damaged, or others may have written it; the reason in a few words."""


def unsafe(about: os.stat_result, sticky: bool = False) -> str:
    """Return why users other than this one and root may change a file or folder; empty if none can.

    Parameters
    ----------
    about : os.stat_result
        Of the file or folder.
    sticky : bool
        Whether a folder like ``/tmp`` is accepted, in which nobody can replace another's files.
    """
    if about.st_uid not in (os.geteuid(), 0):
        return f"it belongs to another user (uid {about.st_uid})"
    others = about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    if others and not (sticky and about.st_mode & stat.S_ISVTX):
        return f"others may write to it (mode {stat.S_IMODE(about.st_mode):04o})"
    return ""


def read(path: Path) -> bytes:
    """Return the data written by `write`.

    Raises
    ------
    UntrustedError
        If it cannot be trusted.
    OSError
        If it cannot be read.
    """
    with open(path, "rb") as file:
        if why := unsafe(os.fstat(file.fileno())):
            raise UntrustedError(why)
        data = file.read()
    content = data[_START:]
    if data[:_START] != _MAGIC + sha256(content).digest():
        raise UntrustedError("its checksum is not that of its content")
    return content


def write(path: Path, content: bytes) -> None:
    """Write a file atomically; the last of several writers prevails.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    path.parent.mkdir(mode=0o700, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f"{path.name}.", dir=path.parent)
    try:
        with open(handle, "wb") as file:
            file.write(_MAGIC + sha256(content).digest())
            file.write(content)
        os.replace(name, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise
