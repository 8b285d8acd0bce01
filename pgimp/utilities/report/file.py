"""Writing a report, of which only an older one is replaced."""

from __future__ import annotations

from pathlib import Path

from pgimp.errors import UsageError, explain
from pgimp.storage import atomic
from pgimp.storage.plain import open_plain
from pgimp.utilities.report.html import BEGINNING


def write(path: Path, content: str) -> None:
    """Write a report, completely or not at all; only an older report is replaced.

    Raises
    ------
    UsageError
        If another file is there, or it cannot be written.
    """
    try:
        if path.is_dir():
            raise UsageError(f"{path} is a directory")
        if path.exists():
            with open_plain(path) as stream:
                beginning = stream.read(len(BEGINNING.encode()))
            if beginning and beginning != BEGINNING.encode():
                raise UsageError(
                    f"{path} exists and is no report of pgimp; it is left as it is: name another "
                    "file with -o"
                )
        atomic.write(path, content)
    except OSError as error:
        raise UsageError(
            f"cannot write {path}: {explain(error)}; name another file with -o"
        ) from error
