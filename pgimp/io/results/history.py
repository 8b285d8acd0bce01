"""history.csv: lines of sums over the particles, at the times of the case."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from pgimp.errors import RunError
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.schema.words.renamed import new_column
from pgimp.storage import linereader
from pgimp.storage.lines import LineFile

__all__ = ["History", "read", "read_sums"]

#: Columns of every history that sums are made of.
SUMS = (
    "time", "step", "mass", "momentum-x", "kinetic-energy", "strain-energy", "dissipated-energy",
    "external-work",
)  # fmt: skip
#: Sizes of numbers from which on sums of them may overflow.
_HUGE = 1e300


def read(path: Path) -> np.ndarray:
    """Read a file of lines, also an older one, with the new names of columns.

    See `pgimp.storage.linereader.read`.
    """
    found = linereader.read(path)
    found.dtype.names = tuple(map(new_column, found.dtype.names or ()))
    return found


def read_sums(path: Path, dimensions: int = 1) -> np.ndarray:
    """Read a history for sums over its columns; without lines it may have no columns.

    Parameters
    ----------
    dimensions : int
        Directions in which there is a momentum.

    Returns
    -------
    ndarray, shape (lines,)
        See `pgimp.storage.linereader.read`.

    Raises
    ------
    RunError
        If it cannot be read or is damaged: columns are missing, or numbers are out of range.
    """
    found = read(path)
    names = found.dtype.names or ()
    needed = [*SUMS, *(f"momentum-{axis}" for axis in "yz"[: dimensions - 1])]
    if missing := [name for name in needed if name not in names and len(found)]:
        raise RunError(f"{path} is damaged: it has no column {', '.join(missing)}")
    for name in names:
        if (np.abs(found[name][np.isfinite(found[name])]) > _HUGE).any():
            raise RunError(f"{path} is damaged: numbers of {name} are out of range")
    return found


class Diagnosed(Protocol):
    """What a line is of: a simulation."""

    @property
    def step(self) -> int: ...

    comm: Communicator

    def diagnostics(self) -> Mapping[str, float] | None: ...


class History(LineFile):
    """Writes the run's diagnostics line by line."""

    renamed = staticmethod(new_column)

    def write(self, sim: Diagnosed) -> None:
        """Write a line for the present state, unless it exists already; collective.

        Parameters
        ----------
        sim : Diagnosed
            The run; the columns are its diagnostics.

        Raises
        ------
        RunError
            On every rank, if the line cannot be written; previous lines stay.
        """
        if sim.step == self.step:
            return
        self.step = sim.step
        values = sim.diagnostics()
        on_root(sim.comm, lambda: self.append(values or {}))
