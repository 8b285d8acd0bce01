"""A run with companions: they run first, choose its cells if so asked, and give its errors."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.case.rescaled import rescaled
from pgimp.errors import RunError, UsageError, explain
from pgimp.io.rundir.ownfiles import COARSE, ERRORS
from pgimp.io.rundir.runinfo import describe_start
from pgimp.mpi.collective import on_root
from pgimp.running.log import Log
from pgimp.running.progress import duration
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
from pgimp.utilities.accuracy.forecast import cost_of, seconds_of
from pgimp.utilities.accuracy.found import Companions, Line, as_csv, with_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.rundir.rundir import RunDirectory
    from pgimp.running.stop import Stop

#: Part of the allowed error for which cells are chosen.
_MARGIN = 0.9
#: Quantities that the line about the errors of a run names, at most.
_NAMED = 6


def wanted(case: Case, directory: RunDirectory, error: bool) -> bool:
    """Whether companions run first; those of a run that is resumed go on; collective."""
    begun = directory.before is not None and not directory.overwrite
    begun = directory.comm.bcast(begun and (directory.path / COARSE).is_dir())
    return error or case.accuracy is not None or begun


def begin(
    case: Case, directory: RunDirectory, log: Log, stop: Stop, run: Callable[..., bool]
) -> Case | None:
    """Do the companion runs of a case, or those that are missing; collective.

    Parameters
    ----------
    run : callable
        `pgimp.commands.run._run`, which runs a case in a directory.

    Returns
    -------
    Case or None
        The case to run, with the chosen cells; None if it was stopped before.

    Raises
    ------
    UsageError
        If the case can have no companions, or the accuracy that it asks for is not reached.
    RunError
        If a companion fails.
    """
    comm = directory.comm
    levels = levels_of(case) if case.accuracy is None else _levels(case)
    planned = companions(case, levels, directory.path)
    directory.accompany(describe_start(comm, 0))
    for note in notes(case, planned):
        log.say(f"warning: {note}")

    for one in planned:
        log.say(f"companion run on cells of {one.cells}, in {one.path}")
        quiet = Log(comm.rank == 0, True)
        try:
            ended = run(one.case, None, comm, one.path, (False, True, False), quiet, stop)
        except RunError as error:
            text = f"the companion run in {one.path} failed: {error}"
            directory.record_failure("failed", 0, 0.0, text)
            raise type(error)(text) from error
        if ended:
            continue
        directory.finish("stopped", 0, 0.0, 0.0, f"stopped {stop}, in a companion run")
        log.say(f"stopped {stop} in a companion run; the same command with --resume goes on")
        return None
    chosen, said = on_root(comm, lambda: _chosen(case, planned, comm.size, stop))
    for text in said:
        log.say(text)
    return rescaled(case, chosen) if chosen != 1.0 else case


def _levels(case: Case) -> list[float]:
    """Levels of the companions that choose the cells: three, if bodies are thick enough."""
    across = thinnest(case)[0]
    for levels in ([8.0, 4.0, 2.0], [4.0, 2.0, 1.0], [4.0, 2.0]):
        if across >= FEWEST * levels[0]:
            return levels
    return [2.0, 1.0]


def _chosen(
    case: Case, planned: list[Companion], ranks: int, stop: Stop
) -> tuple[float, list[str]]:
    """Cells of the run over those of the case, and what to say; on rank 0."""
    costs = [(one.ratio, spent) for one in planned if (spent := cost_of(one.path))]

    def cost(factor: float) -> str:
        of = [(ratio / factor, spent) for ratio, spent in costs]
        seconds = seconds_of(of, case.dimensions)
        if seconds is None:
            return "of unknown cost"
        text = f"about {duration(seconds)} on {ranks} rank{'s' * (ranks > 1)}"
        if seconds > stop.left:
            text += (
                f", of which {duration(max(stop.left, 0.0))} are left: it will stop with a "
                "checkpoint, and goes on with --resume"
            )
        return text

    entry = case.accuracy
    if entry is None:
        return 1.0, [f"the run itself: {cost(1.0)}"]
    curves = [(one.ratio, quantity.curve(entry, one.path)) for one in planned]
    finest = curves[-1][0]
    fine = curves[-1][1]
    known = quantity.found(entry, fine, [(ratio / finest, one) for ratio, one in curves[:-1]])
    allowed = _MARGIN * entry.allowed(known.value)
    on = f"{entry.label} is {with_error(known.value, known.error)} on cells of {planned[-1].cells}"
    if not isfinite(known.error) or not allowed > 0.0:
        why = "its error is not known" if allowed > 0.0 else "of zero there are no per cent"
        raise UsageError(
            f"accuracy: {on}: {why}; take another quantity or time, or `within` as a number"
        )
    order = 1.0 if known.order is None else known.order
    wanted = finest * (allowed / known.error) ** (1.0 / order) if known.error else inf
    told = f"by the order {order:.2g}" if known.order else "if the order is 1, which is not known"
    factor = _factor(case, wanted)
    if factor < entry.finest * (1.0 - 1e-9):
        raise UsageError(
            f"accuracy: {on}; within {entry.asked} needs cells of {_cells(case, factor)}, {told}: "
            f"{cost(factor)}.\nThat is finer than accuracy.finest allows, {entry.finest:g} of "
            f"grid.cell: set it to {0.99 * factor:.2g}, or ask for less. The companion runs are "
            "kept: --resume goes on with them"
        )
    said = (
        f"{on}; within {entry.asked} needs cells of {_cells(case, wanted)}, {told}"
        if wanted < 1.0
        else f"{on}: the case's cells are small enough for {entry.asked}, {told}"
    )
    return factor, [said, f"the run itself, on cells of {_cells(case, factor)}: {cost(factor)}"]


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
    return " x ".join(f"{cell * min(factor, 1.0):.3g}" for cell in dict.fromkeys(case.grid.cell))


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
        if case.accuracy is None:
            return [told(lines, path)]
        return [_reached(case, known), f"{path} has the estimated errors of all columns"]

    for text in on_root(directory.comm, write):
        log.say(text)


def _reached(case: Case, known: Companions) -> str:
    """The quantity with its error, and whether that is small enough."""
    entry = case.accuracy
    assert entry is not None
    others = [(ratio, quantity.curve(entry, path)) for ratio, path in known.runs]
    one = quantity.found(entry, quantity.curve(entry, known.path), others)
    part = f" ({100.0 * one.error / abs(one.value):.2g} %)" if one.value else ""
    text = f"{entry.label}: {with_error(one.value, one.error)}{part}"
    if one.error <= entry.allowed(one.value) * (1.0 + 1e-9):
        return f"{text}, within {entry.asked} as asked"
    return (
        f"warning: {text}: more than the {entry.asked} asked for, as these cells show an error "
        "that shrinks less than the larger ones promised; smaller cells (grid.cell) are needed"
    )


def told(lines: list[Line], path: Path) -> str:
    """Return the line about the errors of the most telling quantities, of greatest values."""
    names = [line.quantity for line in lines]
    shown = [line for line in lines if _tells(line, lines)][:_NAMED]
    parts = [f"{line.quantity} {100.0 * line.part:.2g} %" for line in shown if isfinite(line.part)]
    some = "; ".join(parts) or "nothing that moves"
    return f"estimated errors, of the greatest values: {some}; {path} has all {len(names)} columns"


def _tells(line: Line, lines: list[Line]) -> bool:
    """Whether a quantity is an energy, or the greatest component of a force or a displacement."""
    name, greatest = line.quantity, abs(line.greatest)
    if not greatest > 0.0:
        return False
    if name in ("kinetic-energy", "strain-energy", "external-work"):
        return True
    stem, _, axis = name.rpartition("-")
    if axis not in ("x", "y", "z"):
        return False
    if not stem.startswith(("reaction.", "constraint.", "contact.")) and not stem.endswith(
        (".force", ".displacement")
    ):
        return False
    same = [abs(one.greatest) for one in lines if one.quantity.rpartition("-")[0] == stem]
    return greatest >= max(same)
