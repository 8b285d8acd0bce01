"""The errors of a run directory with companions: of each column of its history and its probes."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pgimp.errors import CaseError, PgimpError
from pgimp.io.results import history
from pgimp.io.results.reader import Run
from pgimp.io.results.tables import Table
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import COARSE, RUN
from pgimp.io.rundir.probefiles import probe_file, probe_files
from pgimp.schema.document import LARGEST_FILE, parse
from pgimp.storage.plain import read_plain
from pgimp.utilities.accuracy.aligned import curve_of, has_error
from pgimp.utilities.accuracy.estimate import Estimate, estimate, ratio_of

Array = np.ndarray

#: Least factor between the cells of two runs that tell anything.
_APART = 1.05
#: Quantities that the line about the errors of a run names, at most, and of which kinds they are.
_NAMED = 6
_ENERGIES = ("kinetic-energy", "strain-energy", "external-work")
_TELLING = re.compile(r"(reaction|constraint|contact)\..*|rigid\..*\.force|probe\..*\.displacement")


class Companions:
    """The companions of a run that are done.

    Parameters
    ----------
    path : Path
        The run directory.
    coarse : Path, optional
        The folder of its companions, if it is not in it.
    """

    def __init__(self, path: Path, coarse: Path | None = None) -> None:
        self.path = path
        own = cells_in(path)
        #: list of (float, Path): Cells over those of the run, ascending, and directory.
        self.runs: list[tuple[float, Path]] = []
        for folder in sorted((coarse or path / COARSE).glob("*h")):
            info, cell = runinfo.read(folder / RUN), cells_in(folder)
            if info and own and cell and info["starts"][-1]["state"] == "done":
                ratio = ratio_of(cell, own)
                if ratio > 1.0 + 1e-9:
                    self.runs.append((ratio, folder))
        self.runs.sort()
        # A first run may have the cells of a companion: there is nothing between them.
        near = zip(self.runs[1:], self.runs, strict=False)
        self.runs = self.runs[:1] + [one for one, last in near if one[0] > _APART * last[0]]

    def estimates(
        self, probe: str = "", names: Collection[str] | None = None
    ) -> dict[str, Estimate]:
        """Return the errors of columns of the history, or of a probe, by name; of all if None.

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
            if has_error(name) and others and (names is None or name in names):
                found[name] = estimate(curve_of(fine, name), others)
        return found

    def errors(
        self, times: Array, probe: str = "", names: Collection[str] | None = None
    ) -> dict[str, Array]:
        """Return the errors at some times, (lines,) each, by column; the rest as of `estimates`."""
        return {
            name: np.interp(times, one.curve.times, one.errors)
            for name, one in self.estimates(probe, names).items()
        }

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
    """Return the greatest size of values; nan without any."""
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if len(known) else np.nan


def _lines(before: str, estimates: dict[str, Estimate]) -> Iterator[Line]:
    for name, one in estimates.items():
        curve = one.curve
        most = int(np.where(np.isfinite(curve.values), np.abs(curve.values), -1.0).argmax())
        yield Line(
            before + name,
            float(curve.values[-1]),
            float(one.errors[-1]),
            float(curve.values[most]),
            float(curve.times[most]),
            one.of(greatest)[1],
            np.nan if one.order is None else one.order,
        )


def as_csv(lines: list[Line]) -> str:
    """Return the text of errors.csv; empty entries are not known."""
    rows = [
        ",".join([one.quantity, *(f"{x:.6g}" if np.isfinite(x) else "" for x in one[1:])])
        for one in lines
    ]
    return "".join(f"{row}\n" for row in [HEAD, *rows])


def told(lines: Sequence[Line]) -> str:
    """Return the errors of the greatest values of the most telling quantities, for messages."""
    shown = [line for line in lines if tells(line, lines) and np.isfinite(line.part)][:_NAMED]
    parts = [f"{line.quantity} {100.0 * line.part:.2g} %" for line in shown]
    return (
        f"estimated errors, of the greatest values: {'; '.join(parts) or 'of nothing that moves'}"
    )


def tells(line: Line, lines: Sequence[Line]) -> bool:
    """Whether it is an energy, or the greatest component of a force or a displacement."""
    stem, _, axis = line.quantity.rpartition("-")
    if not abs(line.greatest) > 0.0 or line.quantity in _ENERGIES or axis not in ("x", "y", "z"):
        return abs(line.greatest) > 0.0 and line.quantity in _ENERGIES
    same = [abs(one.greatest) for one in lines if one.quantity.rpartition("-")[0] == stem]
    return bool(_TELLING.fullmatch(stem)) and abs(line.greatest) >= max(same)


def with_error(value: float, error: float) -> str:
    """Return a value and its error with as many digits as the error tells: ``12.3 +- 0.2``."""
    if not np.isfinite([value, error]).all():
        return f"{value:.4g}, of unknown error"
    if error <= 1e-9 * abs(value):
        return f"{value:.9g} +- {error:.1g}"
    place = int(np.floor(np.log10(error)))
    place -= error / 10.0**place < 3.0  # two digits of errors that begin with 1 or 2
    if place > 0:
        value, error = (10.0**place * round(x / 10.0**place) for x in (value, error))
    size = max(int(np.floor(np.log10(max(abs(value), error)))), place)
    if -6 <= place and size < 6:
        digits = max(0, -place)
        return f"{value:.{digits}f} +- {error:.{digits}f}"
    scale = 10.0**size
    digits = size - place
    power = f"e{size:+03d}"
    return f"({value / scale:.{digits}f} +- {error / scale:.{digits}f}){power}"


def cells_in(path: Path) -> list[float] | None:
    """Return the cells of the case of a run directory; None if they are not known."""
    with suppress(OSError, ValueError, KeyError, TypeError, CaseError, PgimpError):
        data = parse(read_plain(path / "case.yaml", LARGEST_FILE).decode(), "case.yaml").data
        return [float(cell) for cell in data["grid"]["cell"]]
    return None


def errors_of(run: Run, probe: str, table: Table) -> dict[str, Array]:
    """Return the estimated errors of a table's columns at its lines; none without companions.

    Raises
    ------
    RunError
        If a file cannot be read.
    """
    return Companions(run.path).errors(np.asarray(table["time"]), probe) if len(table) else {}
