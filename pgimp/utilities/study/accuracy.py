"""The study of a case's error: three cell sizes, a short time, no exact solution."""

from __future__ import annotations

import os
from pathlib import Path

from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.errors import UsageError

#: Cells of the runs over the case's cells. Finer cells would cost 2^(D + 1) times as much.
FACTORS = (4.0, 2.0, 1.0)
#: Simulated fraction of the case's time.
SHORT = 0.1

_TEXT = """\
# How large the error of {file} is, and its order: three cell sizes, a short time.
#
# The error is the difference from what the runs tend to as cells shrink. With fewer than about four
# cells across what matters nothing can be said of it.

format: 1
title: The error of {file} from three cell sizes
case: {case}

set:                                  # for all runs, as --set takes it
  time.end: {end!r:<25} # of {whole!r}; what is measured must have happened
  output.every: null
{stops}
sweep:                                # the last has the cells of the case
  - grid.cell: {cells}
{steps}
error: {{column: strain-energy, reference: limit, relative: true}}    # any column of history.csv
"""


def study_of(name: str | Path, path: Path) -> str:
    """Return the text of a study of a case.

    Parameters
    ----------
    name : str or Path
        The case file.
    path : Path
        Path of the study.

    Raises
    ------
    UsageError, CaseError
        If the case cannot be read, or is wrong.
    """
    case = load(name)
    if case.time.stages:
        raise UsageError(
            f"{name}: has stages (time.stages), each with steps and an end of its own; write the "
            "study of it yourself, from that of `pgimp init study`"
        )
    sizes = _cells(case)
    steps = ""
    end = float(f"{SHORT * case.time.end:.3g}")
    if case.time.steps is not None:
        # Whole numbers of steps, in proportion to the cells.
        fewest = max(1, round(case.time.steps * SHORT / FACTORS[0]))
        numbers = [round(fewest * FACTORS[0] / factor) for factor in FACTORS]
        steps = f"    time.step: {[end / number for number in numbers]}\n"
    names = {"file": Path(name).name, "case": os.path.relpath(name, path.parent)}
    stops = "  output.at: []\n" if case.output.at else ""
    whole = float(case.time.end)
    return _TEXT.format(**names, end=end, whole=whole, cells=sizes, steps=steps, stops=stops)


def _cells(case: Case) -> list[list[float]]:
    """Cells of the runs, each a whole fraction of the domain."""
    grid = case.grid
    return [
        [
            size if factor == 1.0 else extent / max(1, round(number / factor))
            for size, extent, number in zip(grid.cell, grid.size, grid.cells, strict=True)
        ]
        for factor in FACTORS
    ]
