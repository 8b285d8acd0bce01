"""The quantity of `accuracy:` in a run: its value, and the error of it."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.case.accuracy.entry import Accuracy
from pgimp.errors import UsageError
from pgimp.io.results import history
from pgimp.io.rundir.probefiles import probe_file
from pgimp.schema.instants import TimeMean
from pgimp.schema.messages import unknown
from pgimp.utilities.accuracy.aligned import Curve, curve_of
from pgimp.utilities.accuracy.estimate import ASSUMED, estimate
from pgimp.utilities.accuracy.found import Companions, greatest, with_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case

Array = np.ndarray

#: Part of the allowed error for which cells are chosen.
MARGIN = 0.9


class Found(NamedTuple):
    """A quantity's value with its error."""

    value: float
    error: float
    order: float | None  #: The observed order; None if it is assumed.

    @property
    def by(self) -> str:
        """How cells follow from it, in words."""
        return (
            "if the order is 1, which is not known"
            if self.order is None
            else (f"by the order {self.order:.2g}")
        )

    def shrinks(self, entry: Accuracy) -> float:
        """Return the factor on the cells that lets the error become what is asked for, or less."""
        allowed = MARGIN * entry.allowed(self.value)
        return (allowed / self.error) ** (1.0 / (self.order or ASSUMED)) if self.error else inf


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
        size, error = one.of(greatest)
        value = size if size in fine.values else -size
    else:
        at = fine.times[-1] if entry.at == "end" else float(entry.at)
        line = min(int(np.searchsorted(fine.times, at * (1.0 - 1e-9))), len(fine.times) - 1)
        value, error = float(fine.values[line]), float(one.errors[line])
    return Found(value, error, one.order)


def of(known: Companions, entry: Accuracy) -> Found:
    """Return the value of the quantity in a run with companions, and its error.

    Raises
    ------
    PgimpError
        If a file cannot be read, or has no such column.
    """
    others = [(ratio, curve(entry, path)) for ratio, path in known.runs]
    return found(entry, curve(entry, known.path), others)


def of_run(known: Companions, case: Case) -> str:
    """Return the quantity that a case asks for with its error; empty if it asks for none.

    It begins with ``warning:`` where the error is greater than asked for.

    Raises
    ------
    PgimpError
        If a file cannot be read, or has no such column.
    """
    if (entry := case.accuracy) is None:
        return ""
    value, error, _ = of(known, entry)
    part = f" ({100.0 * error / abs(value):.2g} %)" if value else ""
    text = f"{entry.label}: {with_error(value, error)}{part}"
    if error <= entry.allowed(value) * (1.0 + 1e-9):
        return f"{text}, within {entry.asked} as asked"
    return (
        f"warning: {text}, more than the {entry.asked} asked for: on these cells the error "
        "shrinks less than the larger ones promised"
    )
