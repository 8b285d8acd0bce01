"""Results for users: run directories whose tables know units and errors of their columns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from pgimp.io.results.reader import Run
from pgimp.utilities.accuracy.found import errors_of


def open(directory: str | Path) -> Run:
    """Open a run directory, also of a run that is in progress or has failed.

    Returns
    -------
    Run
        The results, with later additions by the run.

    Raises
    ------
    UsageError
        If the directory has no run.
    """
    return Run(Path(directory), units_of, errors_of)


def units_of(run: Run, columns: Sequence[str]) -> dict[str, str]:
    """Return the unit of each column of a history or a probe.

    It is in the case's `units` where these name length, mass and time (``m, kg, s``), otherwise in
    these words; empty for a column without a unit, and for one that pgimp does not know.
    """
    # The columns' definitions need Numba, which reading results does not.
    from pgimp.utilities.plot.units import kind_of_column, unit

    rings = run.case.geometry == "axisymmetric"
    label, dimension = str(run.case.units), 3 if rings else run.case.dimensions
    found = {}
    for name in columns:
        kind = kind_of_column(name)
        text = unit(kind, label, dimension)
        found[name] = re.sub(r"\$\^(\d)\$", r"^\1", text) or ("" if kind == "1" else kind)
    return found
