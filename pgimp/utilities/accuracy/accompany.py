"""A run with companions: they run first, choose its cells if so asked, and give its errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.case.accuracy.rescaled import rescaled
from pgimp.errors import PgimpError, RunError, UsageError, explain
from pgimp.io.rundir.ownfiles import ERRORS
from pgimp.io.rundir.runinfo import describe_start
from pgimp.mpi.collective import on_root
from pgimp.running.how import How
from pgimp.running.log import Log
from pgimp.scene.scene import Scene
from pgimp.schema.messages import unknown
from pgimp.solver.history.diagnostics import column_names
from pgimp.storage import atomic
from pgimp.utilities.accuracy import quantity
from pgimp.utilities.accuracy.again import (
    Chosen,
    Costs,
    cells_of,
    deepest,
    factor_of,
    first_run,
    keep_first,
    second_refinement,
)
from pgimp.utilities.accuracy.aligned import has_error
from pgimp.utilities.accuracy.companions import (
    FEWEST,
    Companion,
    companions,
    levels_of,
    notes,
    thinnest,
)
from pgimp.utilities.accuracy.found import Companions, as_csv, cells_in, told, with_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.rundir.rundir import RunDirectory
    from pgimp.running.stop import Stop


def begin(
    case: Case,
    directory: RunDirectory,
    how: How,
    log: Log,
    stop: Stop,
    run: Callable[[Case, Path], bool],
) -> Chosen | None:
    """Do the companion runs of a case, or those that are missing; collective.

    Parameters
    ----------
    run : callable
        Runs a companion in its directory, or what is left of it; whether it reached its end.

    Returns
    -------
    Chosen or None
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
        try:
            ended = run(one.case, one.path)
        except PgimpError as error:
            text = (
                f"the companion run in {one.path} failed: {error}\n"
                "The run itself has not begun. Smaller cells (grid.cell) may help; without "
                "--error, or `accuracy`, there are no companions"
            )
            if fresh:
                directory.record_failure("failed", 0, 0.0, text)
            kind = type(error) if isinstance(error, RunError) else UsageError
            raise kind(text) from error
        if ended:
            continue
        if fresh:
            directory.finish("stopped", 0, 0.0, 0.0, f"stopped {stop}, in a companion run")
        log.say(f"stopped {stop} in a companion run; the same command with --resume goes on")
        return None
    factor, left, over, forecast, said = on_root(
        comm, lambda: _chosen(case, planned, directory.path, comm.size, stop)
    )
    for text in said:
        log.say(text)
    if how.forecast:
        directory.finish("stopped", 0, 0.0, 0.0, "only a forecast", {"forecast": forecast})
        log.say("the same command with --resume in place of --forecast goes on")
        return None
    return Chosen(rescaled(case, factor) if factor != 1.0 else case, case, factor, left, over)


def _planned(case: Case, path: Path) -> list[Companion]:
    """The companions of a case; those that choose cells are three, if bodies are thick enough.

    Raises
    ------
    UsageError
        If there can be none, or the history will not have what the case asks for.
    """
    if (entry := case.accuracy) is None:
        return companions(case, levels_of(case), path)
    if not has_error(entry.column):
        raise UsageError(f"accuracy.of: {entry.of} has no error of its own; take another column")
    if not entry.probe and entry.column not in (names := column_names(Scene(case))):
        text = unknown("column", entry.column, names, "history.csv will have")
        raise UsageError(f"accuracy.of: {text}")
    across = thinnest(case)[0]
    most = next((level for level in (8.0, 4.0) if across >= FEWEST * level), 2.0)
    return companions(case, [most / 4.0, most / 2.0, most] if most > 2.0 else [1.0, 2.0], path)


def _chosen(
    case: Case, planned: list[Companion], path: Path, ranks: int, stop: Stop
) -> tuple[float, bool, bool, dict[str, object], list[str]]:
    """Cells of the run over those of the case, and what goes with them; on rank 0.

    Returns
    -------
    factor, left, over : float, bool, bool
        See `Chosen`.
    known : dict
        The forecast.
    said : list of str
        What to say.
    """
    over = False
    cost = Costs([(one.ratio, one.path) for one in planned], case, ranks, stop.left)
    if case.accuracy is None:
        factor, said, left = 1.0, [], False
    else:
        factor, text = _factor_for(case, planned, cost)
        said, left = [text], True
        if (first := first_run(path, factor)) is not None:
            again = second_refinement(case, first, factor, cost)
            if again.factor:
                factor, said, left = again.factor, [*said, again.said], False
                over = cells_in(path) != list(rescaled(case, factor).grid.cell)
    known: dict[str, object] = {"seconds": cost.seconds(factor), "ranks": ranks}
    known["cell"] = list((rescaled(case, factor) if factor != 1.0 else case).grid.cell)
    itself = f"the run itself, on cells of {cells_of(case, factor)}: {cost.told(factor)}"
    if case.accuracy and left and (least := deepest(case, factor)) < factor * (1.0 - 1e-9):
        known["most"] = cost.seconds(least)
        itself += (
            f"; if its own error is more than {case.accuracy.asked}, once more, on cells of no "
            f"less than {cells_of(case, least)}: at most {cost.told(least)}"
        )
    return factor, left, over, known, [*said, itself]


def _factor_for(case: Case, planned: list[Companion], cost: Costs) -> tuple[float, str]:
    """Cells that the accuracy needs, over those of the case, and the reason.

    Raises
    ------
    UsageError
        If they are smaller than the case allows, or nothing is known of the error.
    """
    entry = case.accuracy
    assert entry is not None
    finest = planned[-1].ratio
    curves = [(one.ratio / finest, quantity.curve(entry, one.path)) for one in planned]
    known = quantity.found(entry, curves[-1][1], curves[:-1])
    on = f"{entry.label} is {with_error(known.value, known.error)} on cells of {planned[-1].cells}"
    if not isfinite(known.error) or not entry.allowed(known.value) > 0.0:
        unknown_error = "its error is not known" if entry.allowed(known.value) > 0.0 else ""
        raise UsageError(
            f"accuracy: {on}: {unknown_error or 'of zero there are no per cent'}; take another "
            "quantity or time, or `within` as a number"
        )
    wanted = finest * known.shrinks(entry)
    factor = factor_of(case, wanted)
    needs = f"within {entry.asked} needs cells of {cells_of(case, wanted)}, {known.by}"
    if factor < entry.finest * (1.0 - 1e-9):
        raise UsageError(
            f"accuracy: {on}; {needs}: {cost.told(factor)}.\n"
            f"That is finer than accuracy.finest allows, {entry.finest:g} of grid.cell: set it to "
            f"{0.99 * factor:.3g}, or ask for less. What has run is kept: --resume goes on with it"
        )
    if wanted >= 1.0:
        needs = f"the case's cells are small enough for {entry.asked}, {known.by}"
    return factor, f"{on}; {needs}"


def conclude(chosen: Chosen, directory: RunDirectory, log: Log, stop: Stop) -> bool:
    """Write errors.csv of a run that is done, and tell of the errors; collective.

    Returns
    -------
    bool
        Whether it is to run once more, on smaller cells. Its tables are then kept as a companion's.

    Raises
    ------
    RunError
        On every rank, if a file cannot be read or written.
    """

    def write() -> tuple[list[str], bool]:
        known = Companions(directory.path)
        lines = list(known.lines())
        if not lines:
            return [], False
        path = directory.path / ERRORS
        try:
            atomic.write(path, as_csv(lines))
            text = f"{path} has the estimated errors of all {len(lines)} columns"
            if not (asked := quantity.of_run(known, chosen.case)):
                return [f"{told(lines)}; {text}"], False
            if not chosen.left or not asked.startswith("warning: "):
                return [asked, text], False
            runs = [(chosen.factor * ratio, run) for ratio, run in known.runs]
            cost = Costs(runs, chosen.original, directory.comm.size, stop.left)
            again = second_refinement(chosen.original, known, chosen.factor, cost)
            if again.factor:
                keep_first(directory.path, chosen.factor)
            return [asked, again.said, text], bool(again.factor)
        except OSError as error:
            raise RunError(f"cannot write {path}: {explain(error)}") from error

    said, again = on_root(directory.comm, write)
    for text in said:
        log.say(text)
    return again


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
        "pgimp does only that, and says what the run will cost. If its own error is more than "
        "asked for, it runs once more, on cells of no less than half of the chosen ones"
    )
    yield from notes(case, planned)
