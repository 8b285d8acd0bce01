"""Files of comma-separated values that grow by a line now and then: history.csv, the probes'."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pgimp.errors import RunError
from pgimp.output.collective import explain, on_root
from pgimp.output.files import sync_folder


class LineFile:
    """Lines under a line of names, each of them written whole, and at once to the kernel.

    Parameters
    ----------
    path : Path
        The file; rank 0 creates it with the first line.

    Attributes
    ----------
    step : int
        Step of the last line; -1 before the first.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.step = -1
        self._descriptor = -1
        self._columns = ""
        self._unlisted = False  # in its folder, as far as a crash of the machine is concerned

    def resume(self, comm: Any, step: int) -> None:
        """Go on after the line of a step, or the last one before it; what follows is cut off.

        Parameters
        ----------
        comm : communicator
            Of all ranks; the call is collective.
        step : int
            Of the last line that belongs to what the run goes on from.

        Raises
        ------
        RunError
            On every rank, if the file cannot be read or written, or has no such lines.
        """
        self.step = on_root(comm, lambda: self._cut(step))

    def _cut(self, step: int) -> int:
        last = -1
        try:
            if step < 0:  # there was no line yet, so whatever there is comes after
                os.truncate(self.path, 0)
                return -1
            with open(self.path, "r+b") as stream:
                header = stream.readline()
                place = stream.tell()
                column = header.rstrip(b"\n").split(b",").index(b"step")
                for line in stream:
                    # Behind the line that is looked for, anything may follow.
                    number = int(line.split(b",")[column]) if line.endswith(b"\n") else step + 1
                    if number > step:
                        break
                    last, place = number, place + len(line)
                    if number == step:
                        break
                stream.truncate(place if last >= 0 else 0)
                self._columns = header.decode().rstrip("\n") if last >= 0 else ""
        except FileNotFoundError:
            return -1
        except (ValueError, IndexError):
            raise RunError(
                f"cannot go on with {self.path}: it is damaged before the line of step {step}; "
                "move it away, and the run goes on with a new one"
            ) from None
        except OSError as error:
            raise RunError(f"cannot go on with {self.path}: {explain(error)}") from error
        return last

    def sync(self) -> None:
        """See to it that the lines so far outlast a crash of the machine; on rank 0.

        Raises
        ------
        RunError
            If that is not possible, or the file has been deleted or moved away.
        """
        if self._descriptor >= 0:
            try:
                os.fsync(self._descriptor)
                if self._unlisted:
                    sync_folder(self.path.parent)
                    self._unlisted = False
                if not os.path.samestat(os.fstat(self._descriptor), os.stat(self.path)):
                    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
            except OSError as error:
                raise RunError(f"cannot write {self.path}: {explain(error)}") from error

    def append(self, values: Mapping[str, float | None]) -> None:
        """Write a line; on rank 0.

        Parameters
        ----------
        values : mapping of str to float or None
            By the names of the columns; nothing is written for None.

        Raises
        ------
        RunError
            If that is not possible; the lines before it stay.
        """
        columns = ",".join(values)
        if self._columns not in ("", columns):
            raise RunError(
                f"cannot go on with {self.path}: its columns are not those that it would have "
                "now; move it away, and the run goes on with a new one"
            )
        try:
            if self._descriptor < 0:
                start = 0 if self._columns else os.O_TRUNC
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | start
                self._descriptor = os.open(self.path, flags, 0o666)
            if not self._columns:
                self._unlisted = True
                self._line(columns)
                self._columns = columns
            self._line(",".join(map(_text, values.values())))
        except OSError as error:
            raise RunError(f"cannot write {self.path}: {explain(error)}") from error

    def _line(self, text: str) -> None:
        data = f"{text}\n".encode()
        written = os.write(self._descriptor, data)
        if written < len(data):
            end = os.lseek(self._descriptor, -written, os.SEEK_CUR)
            os.ftruncate(self._descriptor, end)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def close(self) -> None:
        """Close the file."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _text(value: float | None) -> str:
    return "" if value is None else format(value, ".17g")


def read(path: Path) -> np.ndarray:
    """Read such a file, also while it grows.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    ndarray, shape (lines,)
        A structured array with a field of float64 for each column, nan where nothing is written;
        empty if there is no file.

    Raises
    ------
    RunError
        If it cannot be read or is damaged.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        text = ""
    except OSError as error:
        raise RunError(f"cannot read {path}: {explain(error)}") from error
    lines = text.split("\n")[:-1]  # the last has no end yet, or is empty
    columns = lines[0].split(",") if lines else []
    table = np.empty(max(0, len(lines) - 1), dtype=[(name, np.float64) for name in columns])
    for row, line in enumerate(lines[1:]):
        try:
            table[row] = tuple(float(value or "nan") for value in line.split(","))
        except ValueError as error:
            raise RunError(f"{path}, line {row + 2} is damaged: {str(error)[:80]!r}") from error
    return table
