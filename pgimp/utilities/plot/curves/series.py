"""Time series of a figure: a run's history, or a probe."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from pgimp.errors import UsageError
from pgimp.schema.messages import unknown
from pgimp.utilities.plot.runs import PlotRun

Array = np.ndarray


class Series:
    """The history of a run, or the lines of a probe together with the history.

    Parameters
    ----------
    probe : str
        The probe; empty for only the history.
    label : str
        Name in legends.

    Raises
    ------
    UsageError
        If there is no such probe, or no line yet.
    """

    def __init__(self, shown: PlotRun, probe: str, label: str) -> None:
        self.shown, self.probe, self.label = shown, probe, label
        history = shown.run.history
        self._files = [_lines(shown, probe), history] if probe else [history]
        if not len(self._files[0]):
            what = f"line of probe {probe}" if probe else "line of history"
            more = "" if probe else "; history.every makes one"
            more = " yet" if shown.run.state == "running" else more
            raise UsageError(f"{shown.path} has no {what}{more}")

    @property
    def own(self) -> tuple[str, ...]:
        """Columns of the probe, or of the history."""
        return _columns(self._files[0])

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns, first the probe's, then the history's."""
        return tuple(dict.fromkeys(name for file in self._files for name in _columns(file)))

    def take(self, names: Sequence[str]) -> tuple[dict[str, Array], int]:
        """Return columns, each of shape (lines,), and the number of omitted lines.

        Columns of probe and history together have only the lines of common steps.

        Raises
        ------
        UsageError
            If there are no lines.
        """
        source = {
            name: next((file for file in self._files if name in _columns(file)), None)
            for name in names
        }
        used = [file for file in self._files if any(file is one for one in source.values())]
        rows = {id(file): np.arange(len(file)) for file in used}
        if len(used) > 1:
            steps = reduce(np.intersect1d, [file["step"] for file in used])
            if not len(steps):
                raise UsageError(
                    f"{self.shown.path}: probe {self.probe} and the history have no step in "
                    "common; give them the same `every`"
                )
            for file in used:
                rows[id(file)] = np.intersect1d(file["step"], steps, return_indices=True)[1]
        count = len(next(iter(rows.values())))
        values = {
            name: np.full(count, np.nan) if file is None else np.asarray(file[name])[rows[id(file)]]
            for name, file in source.items()
        }
        return values, max(len(file) for file in used) - count


def open_series(runs: Sequence[PlotRun], probes: Sequence[str]) -> list[Series]:
    """Return the series of the curves: the probes of all runs, or their histories."""
    found = []
    for shown in runs:
        for probe in dict.fromkeys(probes) or ("",):
            parts = [shown.name] if len(runs) > 1 or not probe else []
            parts += [probe] if len(probes) > 1 or not parts else []
            found.append(Series(shown, probe, ", ".join(parts)))
    return found


def _columns(lines: Array) -> tuple[str, ...]:
    return lines.dtype.names or ()


def _lines(shown: PlotRun, probe: str) -> Array:
    there = shown.run.probes
    if not there:
        raise UsageError(f"{shown.path} has no probes; the case's probes makes them")
    if probe not in there:
        raise UsageError(f"{shown.path}: --probe: {unknown('probe', probe, there, 'it has')}")
    return there[probe]
