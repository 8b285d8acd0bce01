"""history.csv: a line of totals now and then."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np

from pgimp.errors import RunError
from pgimp.output.collective import explain, on_root


class History:
    """Writes a line of the run's diagnostics at a time, each whole and at once on disk.

    Parameters
    ----------
    path : Path
        The file; rank 0 creates it with the first line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._descriptor = -1
        self._step = -1

    def write(self, sim: Any) -> None:
        """Write a line about the present state, unless there is one already; collective.

        Parameters
        ----------
        sim : Simulation
            The run; the columns are its diagnostics.

        Raises
        ------
        RunError
            On every rank, if the line cannot be written; the lines before it stay.
        """
        if sim.step == self._step:
            return
        self._step = sim.step
        values = sim.diagnostics()
        on_root(sim.comm, lambda: self._append(values))

    def _append(self, values: dict[str, float]) -> None:
        try:
            if self._descriptor < 0:
                flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC
                self._descriptor = os.open(self.path, flags, 0o666)
                self._line(",".join(values))
            self._line(",".join(format(value, ".17g") for value in values.values()))
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


def read(path: Path) -> np.ndarray:
    """Read a history.csv, also while it grows.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    ndarray, shape (lines,)
        A structured array with a field of float64 for each column; empty if there is no file.

    Raises
    ------
    RunError
        If it cannot be read or is damaged.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        text = ""
    except OSError as error:
        raise RunError(f"cannot read {path}: {explain(error)}") from error
    lines = text.split("\n")[:-1]  # the last has no end yet, or is empty
    columns = lines[0].split(",") if lines else []
    table = np.empty(max(0, len(lines) - 1), dtype=[(name, np.float64) for name in columns])
    for row, line in enumerate(lines[1:]):
        try:
            table[row] = tuple(float(value) for value in line.split(","))
        except ValueError as error:
            raise RunError(f"{path}, line {row + 2} is damaged: {error}") from error
    return table
