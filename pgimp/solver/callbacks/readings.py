"""The columns of the history after a step, for a function of a program that asks for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from pgimp.schema.messages import unknown
from pgimp.schema.words.renamed import new_column
from pgimp.solver.callbacks.exchange import Exchange
from pgimp.solver.history.diagnostics import column_names
from pgimp.solver.start.validate_stages import absent

if TYPE_CHECKING:
    from pgimp.solver.state.progress import SimulationProgress


class History(Mapping[str, float]):
    """The columns of ``history.csv`` by name, as after the last step; the same on all ranks.

    Sums and positions are those after the step. Mean forces, moments and fluxes are over the time
    since the function last asked for any, at first since the start. Nothing is computed before it
    asks; then all is that a line has, gauges only if one of theirs is asked for.

    The first access of a call is for all ranks together, likewise the first to a gauge.
    """

    def __init__(self, core: SimulationProgress, exchange: Exchange) -> None:
        self._core, self._exchange = core, exchange
        self._line: dict[str, float] = {}
        self._gauges = False

    @cached_property
    def _names(self) -> list[str]:
        return self._core.columns or column_names(self._core.scene)

    def __getitem__(self, name: str) -> float:
        """Return the value of a column.

        Raises
        ------
        KeyError
            If there is no such column; the message names near ones.
        """
        name = name if name in self._names else new_column(name)
        if name not in self._names:
            raise KeyError(unknown("column", str(name), self._names))
        gauge = name.startswith("gauge.")
        if not self._line or (gauge and not self._gauges):
            self._read(gauge)
        return self._line.get(name, absent(name))

    def __iter__(self) -> Iterator[str]:
        """Go through the names."""
        return iter(self._names)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self._names)

    def _read(self, gauges: bool) -> None:
        core = self._core
        self._exchange.gather("a gauge of the history" if gauges else "the history", None)
        line = core.diagnostic_sums.reading(core.rank, core.now, gauges)
        found = self._exchange.gather("its values", (line, core.diagnostic_sums.read))[0]
        self._line, core.diagnostic_sums.read = found[0] or {}, found[1]
        self._gauges = gauges
