"""history.csv: lines of sums over the particles, at the times of the case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.linereader import read
from pgimp.storage.lines import LineFile

__all__ = ["History", "read"]


class Diagnosed(Protocol):
    """What a line is of: a simulation."""

    @property
    def step(self) -> int: ...

    comm: Communicator

    def diagnostics(self) -> Mapping[str, float] | None: ...


class History(LineFile):
    """Writes the run's diagnostics line by line."""

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
