"""history.csv: a line of totals now and then."""

from __future__ import annotations

from typing import Any

from pgimp.mpi.collective import on_root
from pgimp.storage.linereader import read
from pgimp.storage.lines import LineFile

__all__ = ["History", "read"]


class History(LineFile):
    """Writes a line of the run's diagnostics at a time."""

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
        if sim.step == self.step:
            return
        self.step = sim.step
        values = sim.diagnostics()
        on_root(sim.comm, lambda: self.append(values))
