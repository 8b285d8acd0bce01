"""The errors of a run directory with companions: of each column of its history and its probes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pgimp.errors import CaseError, PgimpError
from pgimp.io.results import history
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import COARSE, RUN
from pgimp.io.rundir.probefiles import probe_file, probe_files
from pgimp.schema.document import LARGEST_FILE, parse
from pgimp.storage.plain import read_plain
from pgimp.utilities.accuracy.aligned import UNSEEN, curve_of
from pgimp.utilities.accuracy.estimate import Estimate, estimate

Array = np.ndarray


class Companions:
    """The companions of a run that are done.

    Parameters
    ----------
    path : Path
        The run directory.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        own = _cell(path)
        #: list of (float, Path): Cells over those of the run, ascending, and directory.
        self.runs: list[tuple[float, Path]] = []
        for folder in sorted((path / COARSE).glob("*h")):
            info, cell = runinfo.read(folder / RUN), _cell(folder)
            if info and own and cell and info["starts"][-1]["state"] == "done":
                ratio = float(np.prod([a / b for a, b in zip(cell, own, strict=False)]))
                ratio **= 1.0 / len(own)
                if ratio > 1.0 + 1e-9:
                    self.runs.append((ratio, folder))
        self.runs.sort()

    def estimates(self, probe: str = "") -> dict[str, Estimate]:
        """Return the errors of the columns of the history, or of a probe, by name.

        Raises
        ------
        PgimpError
            If a file cannot be read.
        """
        fine = self._table(self.path, probe)
        tables = [(ratio, self._table(folder, probe)) for ratio, folder in self.runs[:2]]
        tables = [(ratio, table) for ratio, table in tables if len(table)]
        if not tables or not len(fine):
            return {}
        found = {}
        for name in fine.dtype.names or ():
            others = [
                (ratio, curve_of(table, name))
                for ratio, table in tables
                if name in (table.dtype.names or ())
            ]
            if name not in UNSEEN and others:
                found[name] = estimate(curve_of(fine, name), others)
        return found

    def _table(self, path: Path, probe: str) -> Array:
        return history.read(probe_file(path, probe) if probe else path / "history.csv")

    def lines(self) -> Iterator[Line]:
        """Yield the line of each column of errors.csv; without companions there is none."""
        if self.runs:
            yield from _lines("", self.estimates())
            for file in sorted(probe_files(self.path)):
                yield from _lines(f"probe.{file.stem}.", self.estimates(file.stem))


class Line(NamedTuple):
    """A line of errors.csv: a quantity in the end and at its greatest, each with its error."""

    quantity: str  #: A column of the history, or ``probe.NAME.COLUMN``.
    last: float
    last_error: float
    greatest: float  #: Of the greatest absolute value.
    greatest_time: float
    greatest_error: float
    order: float  #: nan if it is assumed.

    @property
    def part(self) -> float:
        """Error of the greatest value over it; nan of what is zero."""
        return self.greatest_error / abs(self.greatest) if self.greatest else np.nan


#: The head of errors.csv.
HEAD = ",".join(name.replace("_", "-") for name in Line._fields)


def greatest(_: Array, values: Array) -> float:
    """Return the value of the greatest size; nan without any."""
    known = np.where(np.isfinite(values), np.abs(values), -1.0)
    return float(values[known.argmax()]) if len(values) and known.max() >= 0.0 else np.nan


def _lines(before: str, estimates: dict[str, Estimate]) -> Iterator[Line]:
    for name, one in estimates.items():
        most, error = one.of(greatest)
        values = np.where(np.isfinite(one.curve.values), np.abs(one.curve.values), -1.0)
        yield Line(
            before + name,
            float(one.curve.values[-1]),
            float(one.errors[-1]),
            most,
            float(one.curve.times[values.argmax()]),
            error,
            np.nan if one.order is None else one.order,
        )


def as_csv(lines: list[Line]) -> str:
    """Return the text of errors.csv; empty entries are not known."""
    rows = [
        ",".join([one.quantity, *(f"{x:.6g}" if np.isfinite(x) else "" for x in one[1:])])
        for one in lines
    ]
    return "".join(f"{row}\n" for row in [HEAD, *rows])


def with_error(value: float, error: float) -> str:
    """Return a value and its error with as many digits as the error tells: ``12.3 +- 0.2``."""
    if not np.isfinite([value, error]).all():
        return f"{value:.4g}, of unknown error"
    if error <= 1e-9 * abs(value):
        return f"{value:.9g} +- {error:.1g}"
    place = int(np.floor(np.log10(error)))
    place -= error / 10.0**place < 3.0  # two digits of errors that begin with 1 or 2
    size = max(int(np.floor(np.log10(max(abs(value), error)))), place)
    if -6 <= place and size < 6:
        digits = max(0, -place)
        return f"{value:.{digits}f} +- {error:.{digits}f}"
    scale = 10.0**size
    digits = size - place
    power = f"e{size:+03d}"
    return f"({value / scale:.{digits}f} +- {error / scale:.{digits}f}){power}"


def _cell(path: Path) -> list[float] | None:
    """Return the cells of the case of a run directory; None if they are not known."""
    with suppress(OSError, ValueError, KeyError, TypeError, CaseError, PgimpError):
        data = parse(read_plain(path / "case.yaml", LARGEST_FILE).decode(), "case.yaml").data
        return [float(cell) for cell in data["grid"]["cell"]]
    return None
