"""A run with companions: they run first, choose its cells if so asked, and give its errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.case.accuracy.rescaled import rescaled
from pgimp.errors import RunError, UsageError, explain
from pgimp.io.rundir.ownfiles import ERRORS
from pgimp.io.rundir.runinfo import describe_start
from pgimp.mpi.collective import on_root
from pgimp.running.how import How
from pgimp.running.log import Log
from pgimp.running.progress import duration
from pgimp.scene.scene import Scene
from pgimp.schema.messages import unknown
from pgimp.solver.history.diagnostics import column_names
from pgimp.storage import atomic
from pgimp.utilities.accuracy import quantity
from pgimp.utilities.accuracy.companions import (
    FEWEST,
    Companion,
    companions,
    levels_of,
    notes,
    thinnest,
)
from pgimp.utilities.accuracy.estimate import edges
from pgimp.utilities.accuracy.forecast import cost_of, seconds_of
from pgimp.utilities.accuracy.found import Companions, as_csv, told, with_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.rundir.rundir import RunDirectory
    from pgimp.running.stop import Stop

#: Part of the allowed error for which cells are chosen.
_MARGIN = 0.9


def begin(
    case: Case, directory: RunDirectory, how: How, log: Log, stop: Stop, run: Callable[..., bool]
) -> Case | None:
    """Do the companion runs of a case, or those that are missing; collective.

    Parameters
    ----------
    run : callable
        `pgimp.commands.run._run`, which runs a case in a directory.

    Returns
    -------
    Case or None
        The case to run, with the chosen cells; None if it was stopped before, or for a forecast.

    Raises
    ------
    UsageError
        If the case can have no companions, or the accuracy that it asks for is not reached.
    RunError
        If a companion fails.
    """
    comm = directory.comm
    planned = _planned(case, directory.path)
    directory.accompany(describe_start(comm, 0))
    fresh = directory.overwrite or not (directory.before or {}).get("steps")
    for note in notes(case, planned):
        log.say(f"warning: {note}")

    for one in planned:
        log.say(f"companion run on cells of {one.cells}, in {one.path}")
        quiet = Log(comm.rank == 0, True)
        try:
            ended = run(one.case, None, comm, one.path, How(resume=True), quiet, stop)
        except RunError as error:
            text = (
                f"the companion run in {one.path} failed: {error}\n"
                "The run itself has not begun. Smaller cells (grid.cell) may help; without "
                "--error, or `accuracy`, there are no companions"
            )
            if fresh:
                directory.record_failure("failed", 0, 0.0, text)
            raise type(error)(text) from error
        if ended:
            continue
        if fresh:
            directory.finish("stopped", 0, 0.0, 0.0, f"stopped {stop}, in a companion run")
        log.say(f"stopped {stop} in a companion run; the same command with --resume goes on")
        return None
    chosen, forecast, said = on_root(comm, lambda: _chosen(case, planned, comm.size, stop))
    for text in said:
        log.say(text)
    if how.forecast:
        directory.finish("stopped", 0, 0.0, 0.0, "only a forecast", {"forecast": forecast})
        log.say("the same command with --resume in place of --forecast goes on")
        return None
    return rescaled(case, chosen) if chosen != 1.0 else case


def _planned(case: Case, path: Path) -> list[Companion]:
    """The companions of a case; those that choose cells are three, if bodies are thick enough.

    Raises
    ------
    UsageError
        If there can be none, or the history will not have what the case asks for.
    """
    if (entry := case.accuracy) is None:
        return companions(case, levels_of(case), path)
    if not entry.probe and entry.column not in (names := column_names(Scene(case))):
        text = unknown("column", entry.column, names, "history.csv will have")
        raise UsageError(f"accuracy.of: {text}")
    across = thinnest(case)[0]
    most = next((level for level in (8.0, 4.0) if across >= FEWEST * level), 2.0)
    return companions(case, [most / 4.0, most / 2.0, most] if most > 2.0 else [1.0, 2.0], path)


def _chosen(
    case: Case, planned: list[Companion], ranks: int, stop: Stop
) -> tuple[float, dict[str, object], list[str]]:
    """Cells of the run over those of the case, its forecast, and what to say; on rank 0."""
    costs = [(one.ratio, spent) for one in planned if (spent := cost_of(one.path))]

    def seconds(factor: float) -> float | None:
        return seconds_of([(ratio / factor, spent) for ratio, spent in costs], case.dimensions)

    def cost(factor: float) -> str:
        if (time := seconds(factor)) is None:
            return "of unknown cost"
        text = f"about {duration(time)} on {ranks} rank{'s' * (ranks > 1)}"
        if time > stop.left:
            text += (
                f", of which {duration(max(stop.left, 0.0))} are left: it will stop with a "
                "checkpoint, and goes on with --resume"
            )
        return text

    factor, said = (1.0, "") if case.accuracy is None else _factor_for(case, planned, cost)
    known: dict[str, object] = {"seconds": seconds(factor), "ranks": ranks}
    known["cell"] = list(case.grid.cell if factor == 1.0 else rescaled(case, factor).grid.cell)
    itself = f"the run itself, on cells of {_cells(case, factor)}: {cost(factor)}"
    return factor, known, [*([said] if said else []), itself]


def _factor_for(
    case: Case, planned: list[Companion], cost: Callable[[float], str]
) -> tuple[float, str]:
    """Cells that the accuracy needs, over those of the case, and the reason.

    Raises
    ------
    UsageError
        If they are smaller than the case allows, or nothing is known of the error.
    """
    entry = case.accuracy
    assert entry is not None
    curves = [(one.ratio, quantity.curve(entry, one.path)) for one in planned]
    finest, fine = curves[-1]
    known = quantity.found(entry, fine, [(ratio / finest, one) for ratio, one in curves[:-1]])
    allowed = _MARGIN * entry.allowed(known.value)
    on = f"{entry.label} is {with_error(known.value, known.error)} on cells of {planned[-1].cells}"
    if not isfinite(known.error) or not allowed > 0.0:
        why = "its error is not known" if allowed > 0.0 else "of zero there are no per cent"
        raise UsageError(
            f"accuracy: {on}: {why}; take another quantity or time, or `within` as a number"
        )
    order = 1.0 if known.order is None else known.order
    told = f"by the order {order:.2g}" if known.order else "if the order is 1, which is not known"
    wanted = finest * (allowed / known.error) ** (1.0 / order) if known.error else inf
    factor = _factor(case, wanted)
    needs = f"within {entry.asked} needs cells of {_cells(case, wanted)}, {told}"
    if factor < entry.finest * (1.0 - 1e-9):
        raise UsageError(
            f"accuracy: {on}; {needs}: {cost(factor)}.\n"
            f"That is finer than accuracy.finest allows, {entry.finest:g} of grid.cell: set it to "
            f"{0.99 * factor:.2g}, or ask for less. What has run is kept: --resume goes on with it"
        )
    if wanted >= 1.0:
        needs = f"the case's cells are small enough for {entry.asked}, {told}"
    return factor, f"{on}; {needs}"


def _factor(case: Case, wanted: float) -> float:
    """The largest 2/m up to `wanted`, and at most 1, for which the case is valid."""
    m = 2
    while 2.0 / m > wanted * (1.0 + 1e-9):
        m += 1
    for tried in range(m, m + 4):
        try:
            rescaled(case, 2.0 / tried)
        except UsageError:
            continue
        return 2.0 / tried
    return 2.0 / m


def _cells(case: Case, factor: float) -> str:
    return edges([cell * min(factor, 1.0) for cell in case.grid.cell])


def conclude(case: Case, directory: RunDirectory, log: Log) -> None:
    """Write errors.csv of a run that is done, and tell of the errors; collective.

    Raises
    ------
    RunError
        On every rank, if a file cannot be read or written.
    """

    def write() -> list[str]:
        known = Companions(directory.path)
        lines = list(known.lines())
        if not lines:
            return []
        path = directory.path / ERRORS
        try:
            atomic.write(path, as_csv(lines))
        except OSError as error:
            raise RunError(f"cannot write {path}: {explain(error)}") from error
        text = f"{path} has the estimated errors of all {len(lines)} columns"
        if asked := quantity.of_run(known, case):
            return [asked, text]
        return [f"{told(lines)}; {text}"]

    for text in on_root(directory.comm, write):
        log.say(text)


def foreseen(case: Case) -> Iterator[str]:
    """Yield what a check says of a case that asks for an accuracy.

    Raises
    ------
    UsageError
        If it can have no companions.
    """
    if case.accuracy is None:
        return
    planned = _planned(case, Path())
    cells = ", ".join(one.cells for one in planned)
    yield (
        f"accuracy: runs on cells of {cells} come first, and choose cells between those of the "
        f"case, of which all is said here, and {case.accuracy.finest:g} of them; with --forecast "
        "pgimp does only that, and says what the run will cost"
    )
    yield from notes(case, planned)
