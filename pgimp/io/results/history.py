"""history.csv: lines of sums over the particles, at the times of the case."""

from __future__ import annotations

from typing import Any

from pgimp.mpi.collective import on_root
from pgimp.storage.linereader import read
from pgimp.storage.lines import LineFile

__all__ = ["History", "read"]


class History(LineFile):
    """Writes the run's diagnostics line by line."""

    def write(self, sim: Any) -> None:
        """Write a line for the present state, unless it exists already; collective.

        Parameters
        ----------
        sim : Simulation
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
        on_root(sim.comm, lambda: self.append(values))
