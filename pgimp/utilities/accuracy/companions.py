"""Companion runs: the case on larger cells, in `coarse/` of its run directory, before it runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.case.accuracy.rescaled import companion
from pgimp.errors import UsageError
from pgimp.io.rundir.ownfiles import COARSE
from pgimp.running.accuracy.find import boxes_of, of_case
from pgimp.utilities.accuracy.estimate import edges, ratio_of

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Cells across the thinnest body for a companion to be worth its cost.
FEWEST = 2.0
#: Least factor between the cells of runs that tell anything.
_LEAST = 1.25


class Companion:
    """A companion run to be: its case, its folder, and its cells over those of the case."""

    def __init__(self, case: Case, level: float, directory: Path) -> None:
        self.case = companion(case, level)
        self.ratio = ratio_of(self.case.grid.cell, case.grid.cell)
        self.path = directory / COARSE / f"{level:g}h"

    @property
    def cells(self) -> str:
        """Its cells, for messages."""
        return edges(self.case.grid.cell)


def thinnest(case: Case) -> tuple[float, str]:
    """Return the cells across the thinnest body of a case, and its name; inf without any."""
    found = [
        (one.value, one.where)
        for one in of_case(case.stages[0], boxes_of(case))
        if one.name == "cells"
    ]
    return min(found, default=(float("inf"), ""))


def companions(case: Case, levels: Sequence[float], directory: Path) -> list[Companion]:
    """Return the companions of a case, from the largest cells on.

    Parameters
    ----------
    levels : sequence of float
        Their cells over those of the case, at most. Only the smallest must be possible.

    Raises
    ------
    UsageError
        If not even it is.
    """
    found: list[Companion] = []
    for level in sorted(levels):
        try:
            one = Companion(case, level, directory)
        except UsageError:
            if not found:
                raise
            break
        if one.ratio < _LEAST * (found[-1].ratio if found else 1.0) and level > 1.0:
            if found:
                break
            raise UsageError(
                f"grid.cell: the domain has {' x '.join(map(str, case.grid.cells))} cells, too few "
                "for a companion run on larger ones (--error, accuracy)"
            )
        found.append(one)
    return found[::-1]


def levels_of(case: Case) -> list[float]:
    """Return the levels of the companions that give a run's errors: 2, and 4 if bodies are thick.

    The second costs little, and shows the order.
    """
    return [2.0, 4.0] if thinnest(case)[0] >= 4.0 * FEWEST else [2.0]


def notes(case: Case, planned: Sequence[Companion]) -> Iterator[str]:
    """Yield remarks on bodies that are too thin for companions."""
    across, name = thinnest(case)
    for one in planned:
        if across / one.ratio < FEWEST:
            yield (
                f"body '{name}' is {across / one.ratio:.2g} cells across on the companion's cells "
                f"of {one.cells}: the errors that follow may mean little"
            )
            return
