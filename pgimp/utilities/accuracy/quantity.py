"""The quantity of `accuracy:` in a run: its value, and the error of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pgimp.case.accuracy import Accuracy
from pgimp.errors import UsageError
from pgimp.io.results import history
from pgimp.io.rundir.probefiles import probe_file
from pgimp.schema.instants import TimeMean
from pgimp.schema.messages import unknown
from pgimp.utilities.accuracy.aligned import Curve, curve_of
from pgimp.utilities.accuracy.estimate import estimate
from pgimp.utilities.accuracy.found import greatest

Array = np.ndarray


class Found(NamedTuple):
    """A quantity's value with its error."""

    value: float
    error: float
    order: float | None  #: The observed order; None if it is assumed.


def curve(entry: Accuracy, path: Path) -> Curve:
    """Return the quantity over time in a run.

    Raises
    ------
    UsageError
        If the run has no such column.
    RunError
        If its file cannot be read.
    """
    table = history.read(probe_file(path, entry.probe) if entry.probe else path / "history.csv")
    names = table.dtype.names or ()
    if entry.column not in names:
        what = f"probe {entry.probe} has" if entry.probe else "history.csv has"
        raise UsageError(f"accuracy.of: {unknown('column', entry.column, names, what)}")
    return curve_of(table, entry.column)


def found(entry: Accuracy, fine: Curve, others: Sequence[tuple[float, Curve]]) -> Found:
    """Return the value of the quantity in the finest run, and its error.

    Parameters
    ----------
    others : sequence of (float, Curve)
        As of `estimate`.
    """
    one = estimate(fine, others)
    if isinstance(entry.at, TimeMean):
        begin, end = entry.at.mean

        def mean(times: Array, values: Array) -> float:
            inside = times[(times > begin) & (times < end)]
            at = np.concatenate([[begin], inside, [end]])
            return float(np.trapezoid(np.interp(at, times, values), at)) / (end - begin)

        value, error = one.of(mean)
    elif entry.at == "max":
        value, error = one.of(greatest)
    else:
        at = fine.times[-1] if entry.at == "end" else float(entry.at)
        line = min(int(np.searchsorted(fine.times, at * (1.0 - 1e-9))), len(fine.times) - 1)
        value, error = float(fine.values[line]), float(one.errors[line])
    return Found(value, error, one.order)
