"""Cells for an accuracy, what they cost, and a second refinement where the first does not do.

A run whose own error is more than asked for runs once more, on cells of at least half of its own.
Its tables stay as a companion's, from which the cells follow: so a killed run finds them again.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pgimp.case.accuracy.rescaled import rescaled
from pgimp.errors import UsageError
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import COARSE, RUN
from pgimp.io.rundir.probefiles import PROBES, probe_files
from pgimp.running.progress import duration
from pgimp.storage import atomic
from pgimp.utilities.accuracy import quantity
from pgimp.utilities.accuracy.estimate import edges
from pgimp.utilities.accuracy.forecast import cost_of, seconds_of
from pgimp.utilities.accuracy.found import Companions

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Smallest and largest cells of a second refinement, over those of the first. At the smallest a run
#: in 2D costs 8 times as much, one in 3D 16 times. Runs on cells that are closer tell no error.
_DEEPEST, _NEXT = 0.5, 2.0 / 3.0
_ROUNDING = 1e-9
#: Seconds of a run that nobody waits for.
_ENDLESS = 1e9


class Chosen(NamedTuple):
    """The case that runs, on the cells chosen for it."""

    case: Case
    original: Case  #: With the cells that are written.
    factor: float  #: Cells over those of the original.
    left: bool  #: Whether it may run once more.
    over: bool  #: Whether it does so now, in place of the run that is in the directory.


class Again(NamedTuple):
    """Cells of a second refinement over those of the case, 0 for none, and the reason."""

    factor: float
    said: str


class Costs:
    """What a run costs on other cells, from runs that are done.

    Parameters
    ----------
    runs : sequence of (float, Path)
        Cells over those of the case, and run directory.
    left : float
        Seconds that are left.
    """

    def __init__(
        self, runs: Sequence[tuple[float, Path]], case: Case, ranks: int, left: float
    ) -> None:
        self.known = [(ratio, spent) for ratio, path in runs if (spent := cost_of(path))]
        self.dimensions, self.ranks, self.left = case.dimensions, ranks, left

    def seconds(self, factor: float) -> float | None:
        """Return the seconds of a run on cells `factor` times those of the case."""
        return seconds_of([(ratio / factor, one) for ratio, one in self.known], self.dimensions)

    def told(self, factor: float) -> str:
        """Return the same in words."""
        if (time := self.seconds(factor)) is None:
            return "of unknown cost"
        if not time < _ENDLESS:
            return "more than 30 years"
        text = f"about {duration(time)} on {self.ranks} rank{'s' * (self.ranks > 1)}"
        if time > self.left:
            text += (
                f", of which {duration(max(self.left, 0.0))} are left: it will stop with a "
                "checkpoint, and goes on with --resume"
            )
        return text


def cells_of(case: Case, factor: float) -> str:
    """Return cells of `factor` times those of a case in words, at most its own."""
    return edges([cell * min(factor, 1.0) for cell in case.grid.cell])


def factor_of(case: Case, wanted: float) -> float:
    """Return the largest 2/m up to `wanted`, and at most 1, for which the case is valid."""
    m = max(2, ceil(2.0 / (wanted * (1.0 + _ROUNDING))))
    for tried in range(m, m + 4):
        try:
            rescaled(case, 2.0 / tried)
        except UsageError:
            continue
        return 2.0 / tried
    return 2.0 / m


def deepest(case: Case, factor: float) -> float:
    """Return the smallest cells to which a run on `factor` times the case's may be refined."""
    assert case.accuracy is not None
    return max(_DEEPEST * factor, case.accuracy.finest)


def second_refinement(case: Case, first: Companions, factor: float, cost: Costs) -> Again:
    """Return the cells of a second refinement, or why there is none; on rank 0.

    Parameters
    ----------
    case : Case
        With the cells that are written.
    first : Companions
        Of the first run, which is done.
    factor : float
        Its cells over those of the case.
    """
    entry = case.accuracy
    assert entry is not None
    cost.known += [(factor, spent)] if (spent := cost_of(first.path)) else []
    known = quantity.of(first, entry)
    wanted = factor * known.shrinks(entry)
    least = deepest(case, factor)
    needs = f"it needs cells of {edges([wanted * cell for cell in case.grid.cell])}, {known.by}"
    few = least * (1.0 - _ROUNDING)
    chosen = factor_of(case, min(wanted, _NEXT * factor)) if wanted >= few else 0.0
    if chosen >= few:
        needs = f"{needs}: {cost.told(chosen)}"
        return Again(chosen, f"once more, on cells of {cells_of(case, chosen)}: {needs}")
    return Again(
        0.0,
        f"there is no second refinement: {needs}, which is finer than {cells_of(case, least)}, to "
        "which it may go (half of its cells, and accuracy.finest); for more set grid.cell",
    )


def first_run(path: Path, factor: float) -> Companions | None:
    """Return a first run whose tables have been kept, with its companions; None without one."""
    own = path / COARSE / _name(factor)
    content = runinfo.read(own / RUN)
    if content is None or not content["starts"][-1].get("refined"):
        return None
    return Companions(own, path / COARSE)


def keep_first(path: Path, factor: float) -> None:
    """Copy the tables of a run that is done to those of its companions.

    Raises
    ------
    OSError
        If that is not possible.
    """
    own = path / COARSE / _name(factor)
    (own / PROBES).mkdir(parents=True, exist_ok=True)
    last = (runinfo.read(path / RUN) or {"starts": [{}]})["starts"][-1]
    runinfo.write(own / RUN, last | {"state": "stopped"})
    for name in ("case.yaml", "history.csv"):
        atomic.write(own / name, (path / name).read_bytes())
    for file in probe_files(path):
        atomic.write(own / PROBES / file.name, file.read_bytes())
    runinfo.write(own / RUN, last | {"refined": True})


def _name(factor: float) -> str:
    return f"first-{factor:g}h"
