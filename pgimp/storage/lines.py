"""Files of comma-separated values that grow line by line: history.csv, the probes'."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pgimp.errors import RunError, explain
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.atomic import sync_folder, write
from pgimp.storage.linereader import numbered
from pgimp.storage.plain import open_plain


class LineFile:
    """Lines under a header line, each written completely, without buffering.

    Parameters
    ----------
    path : Path
        The file; rank 0 creates it with the first line.

    Attributes
    ----------
    step : int
        Step of the last line; -1 before the first.
    count : int
        Number of lines.
    """

    #: Returns the name of a column now, for one by which an older file may have it.
    renamed: Callable[[str], str] = staticmethod(str)

    def __init__(self, path: Path) -> None:
        self.path = path
        self.step = -1
        self.count = 0
        self._descriptor = -1
        self._columns = ""
        self._filled: dict[str, float] = {}
        self._unlisted = False  # whether a crash may lose its name in the folder

    def resume(self, comm: Communicator, step: int) -> None:
        """Continue after the line of a step, or the last line before; later lines are cut off.

        Parameters
        ----------
        comm : communicator
            Of all ranks; the call is collective.
        step : int
            Step of the last line before the point from which the run resumes.

        Raises
        ------
        RunError
            On every rank, if the file cannot be read or written, or has no such lines.
        """
        self.step, self.count = on_root(comm, lambda: self._cut(step))

    def _cut(self, step: int) -> tuple[int, int]:
        last, count = -1, 0
        try:
            if step < 0:  # there was no line, so any line comes after
                os.truncate(self.path, 0)
                return -1, 0
            with open_plain(self.path) as stream:
                header, lines = numbered(stream)
                place = len(header)
                # After the line of that step, anything may follow.
                for number, line in lines:
                    if number > step:
                        break
                    last, place, count = number, place + len(line), count + 1
                    if number == step:
                        break
            os.truncate(self.path, place if last >= 0 else 0)
            self._columns = header.decode().rstrip("\n") if last >= 0 else ""
            names = ",".join(map(self.renamed, self._columns.split(",")))
            if names != self._columns:
                lines_so_far = self.path.read_text().partition("\n")[2]
                write(self.path, f"{names}\n{lines_so_far}")
                self._columns = names
        except FileNotFoundError:
            return -1, 0
        except (ValueError, IndexError):
            raise RunError(
                f"cannot go on with {self.path}: it is damaged before the line of step {step}; "
                "move it away, and the run goes on with a new one"
            ) from None
        except OSError as error:
            raise RunError(f"cannot go on with {self.path}: {explain(error)}") from error
        return last, count

    def widen(self, columns: Sequence[str], absent: Callable[[str], float]) -> None:
        """Add columns to a continued file; on rank 0.

        Existing columns stay, even if they are not in `columns`.

        Parameters
        ----------
        columns : sequence of str
            Columns of further lines.
        absent : callable
            Value of a column, by its name, in existing lines without it.

        Raises
        ------
        RunError
            If that is not possible; the file is then unchanged.
        """
        had = self._columns.split(",") if self._columns else []
        self._filled = {name: absent(name) for name in had if name not in columns}
        if not had or all(name in had for name in columns):
            return
        wide = list(columns) if not self._filled else [*had, *(c for c in columns if c not in had)]
        try:
            rows = self.path.read_text().splitlines()[1:]
            lines = [",".join(wide)]
            for row in rows:
                values = dict(zip(had, row.split(","), strict=True))
                lines.append(",".join(values.get(c, _text(absent(c))) for c in wide))
            write(self.path, "".join(f"{line}\n" for line in lines))
        except (OSError, ValueError) as error:
            cause = explain(error) if isinstance(error, OSError) else "a line is damaged"
            raise RunError(f"cannot go on with {self.path}: {cause}") from error
        self._columns = lines[0]

    def sync(self) -> None:
        """Ensure that the lines so far survive a crash of the machine; on rank 0.

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
            Values by column name; None becomes an empty entry.

        Raises
        ------
        RunError
            If that is not possible; previous lines stay.
        """
        if self._filled:
            values = {**values, **self._filled}
            if {*values} == {*(names := self._columns.split(","))}:
                values = {name: values[name] for name in names}
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
            self.count += 1
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
