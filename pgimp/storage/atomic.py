"""Atomic writing of small files: always the old or the new version, never a part."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from pgimp.storage.plain import require_plain

TEMPORARY = ".part"


def temporary(path: Path) -> Path:
    """Return the temporary name of `path`, before renaming."""
    return path.with_name(f".{path.name}{TEMPORARY}")


def write(path: Path, content: str | bytes, durable: bool = True) -> None:
    """Write a file through a temporary one.

    Parameters
    ----------
    content : str or bytes
        The whole content; text becomes UTF-8.
    durable : bool
        Whether it must survive a crash of the machine, which takes longer.

    Raises
    ------
    OSError
        If it cannot be written, or is no regular file; an older version then stays. A pipe or a
        device would be replaced, not written to.
    """
    with suppress(FileNotFoundError):
        require_plain(path)
    part = temporary(path)
    try:
        part.write_bytes(content.encode() if isinstance(content, str) else content)
        if durable:
            publish(part, path)
        else:
            part.rename(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def sync_folder(folder: Path) -> None:
    """Make the names in a folder survive a crash of the machine; an OSError if that fails."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def publish(part: Path, path: Path) -> None:
    """Rename a finished temporary file so that it survives a crash of the machine.

    Raises
    ------
    OSError
        If that fails, almost always before renaming.
    """
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        descriptor = os.open(part, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        part.rename(path)
        os.fsync(folder)
    finally:
        os.close(folder)
