"""Resuming a run: choice of the checkpoint, and comparison of the case."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pgimp.case.choices.kept import kept
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.case.writer import flow
from pgimp.errors import CaseError, DamagedError, RunError, UsageError, explain
from pgimp.io.rundir.probefiles import probe_file
from pgimp.io.rundir.rundir import STARTING, RunDirectory
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.running.checkpoints import About, intact, made_by, number_of, present
from pgimp.running.log import Log
from pgimp.running.probes import require_known
from pgimp.schema.document import LARGEST_FILE
from pgimp.solver.callbacks.callback import Each
from pgimp.solver.simulation import Simulation
from pgimp.solver.state.state import State
from pgimp.solver.time.clock import clock_of
from pgimp.storage.linereader import require_whole
from pgimp.storage.plain import read_plain

#: Keys that may change when a run is resumed: they affect no particle, or only the run's end.
MAY_CHANGE = ("title", "time.end", "output", "history", "probes", "checkpoint", "accuracy")


class Resumed(NamedTuple):
    """A simulation in the state of a checkpoint, and the checkpoint's header."""

    sim: Simulation
    about: About


def resume(
    case: Case, comm: Communicator, directory: RunDirectory, log: Log, each: Each | None = None
) -> Resumed | str:
    """Find the newest intact checkpoint of a run and restore its state; collective.

    Parameters
    ----------
    case : Case
        The present case.
    directory : RunDirectory
        Claimed for this run.
    log : Log
        Receives the messages.
    each : Each, optional
        A function that is called after steps.

    Returns
    -------
    Resumed or str
        "afresh" without a checkpoint; "done" if the run has ended.

    Raises
    ------
    UsageError, CaseError
        On every rank, if the case differs from the run's.
    RunError
        On every rank, if no checkpoint is intact.
    """
    folder = directory.path / "checkpoints"
    before = directory.before or {}
    paths = on_root(comm, lambda: present(folder))
    if before.get("state") == STARTING:
        log.say(f"the run in {directory.path} was ended while it started: starting afresh")
        return "afresh"
    reasons: list[str] = []
    for path, file in intact(paths, comm):
        try:
            if isinstance(file, DamagedError):
                raise file
            about, state = About.of(file), State.of(file)
            if state.step != number_of(path):
                raise DamagedError(f"it is of step {state.step}, which is not that of its name")
            began_as = _compare(about.case, case, f"{path}", log, state.stage)
            require_known(case, about.probes)
            on_root(comm, partial(_require_lines, directory.path, case, about))
            clock = clock_of(began_as, before=state.counted)
            expected = clock.time(clock.after(state.step, state.time, state.dt))
            if state.settling and not state.stage:
                expected = 0.0
            if state.time > clock.end * (1.0 + 1e-12) or expected != state.time:
                raise DamagedError("its time is not that of its step, or past the end of its case")
            if _ended(case, state) and before.get("state") == "done":
                return "done"
            sim = Simulation(case, comm, file, each)
        except DamagedError as error:
            reasons.append(f"{error}")
            log.say(f"warning: {path} cannot be used: {error}; looking for an earlier one")
            continue
        for line in _made_otherwise(about):
            log.say(f"warning: {line}")
        log.say(f"resuming from {path}: step {state.step}, t = {state.time:.6g}")
        return Resumed(sim, about)
    if paths:
        raise RunError(
            f"none of the {len(paths)} checkpoints in {folder} can be used (the newest is "
            f"{paths[0].name}: {reasons[0]}); --overwrite starts over"
        )
    if before:
        text = on_root(comm, lambda: _case_of(directory.path))
        if text is not None:
            _compare(text, case, f"{directory.path / 'case.yaml'}", log)
        if before["state"] == "done" or before["checkpoint"] is not None:
            raise RunError(
                f"the run in {directory.path} has written checkpoints (the last one of step "
                f"{before['checkpoint']}), but they have gone; --overwrite starts over"
            )
    log.say(f"no checkpoint in {directory.path} yet: starting afresh")
    return "afresh"


def as_begun(case: Case, comm: Communicator, directory: RunDirectory) -> Case:
    """Return the case with what was chosen for its run when that began; collective."""
    text = on_root(comm, lambda: _case_of(directory.path))
    if text is None:
        return case
    try:
        return kept(case, read_case(text, f"{directory.path / 'case.yaml'}"))
    except CaseError:  # one that this version does not read: `resume` says so
        return case


def _require_lines(directory: Path, case: Case, about: About) -> None:
    """Refuse to resume with history or probe files that have lost lines."""
    require_whole(directory / "history.csv", about.history, about.lines)
    for name in case.probes:
        if record := about.probes.get(name):
            require_whole(probe_file(directory, name), record.line, record.lines)


def _case_of(directory: Path) -> str | None:
    try:
        return read_plain(directory / "case.yaml", LARGEST_FILE).decode()
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        cause = explain(error) if isinstance(error, OSError) else "it is no text"
        raise RunError(f"cannot read {directory / 'case.yaml'}: {cause}") from error


def _ended(case: Case, state: State) -> bool:
    """Return whether the run has ended; a checkpoint after the end is refused."""
    stage = case.stages[state.stage]
    clock = clock_of(stage, before=state.counted)
    if state.time > clock.end * (1.0 + 1e-12):
        key = f"time.stages.{state.stage - 1}.end" if state.stage else "time.end"
        raise UsageError(
            f"{key}: {clock.end:.6g} has passed, the run is at t = {state.time:.6g} already; "
            "--overwrite starts over"
        )
    last = state.stage == len(case.stages) - 1 and not state.settling
    return last and clock.finished(clock.after(state.step, state.time, state.dt))


def _compare(text: str, case: Case, source: str, log: Log, stage: int = 0) -> Case:
    """Refuse a case that differs from a run's in more than `MAY_CHANGE`; log the changes.

    Stages that have not begun may differ, also in number. Returns the case of the run's present
    stage.
    """
    try:
        before = read_case(text, source)
    except CaseError as error:
        raise UsageError(
            f"this version of pgimp does not read the case of the run:\n{error}"
        ) from None
    if stage >= len(before.stages):
        raise DamagedError(f"it is of stage {stage + 1}, of {len(before.stages)}")
    if stage >= len(case.stages):
        raise UsageError(
            f"time.stages: the run is in stage {stage + 1} already, '"
            f"{before.stages[stage].staged.name}', which the case does not have; --overwrite "
            "starts over"
        )
    accepted, refused = _differences(before, case, stage)
    if refused:
        most = 20
        lines = [f"  {line}" for line in refused[:most]]
        if len(refused) > most:
            lines.append(f"  and {len(refused) - most} more")
        raise UsageError(
            "a resumed run must be the same case; only title, time.end, output, history, "
            "probes, checkpoint and stages that have not begun may change, but\n"
            + "\n".join(lines)
            + "\nUndo these changes, or choose another directory with -o. To go on with changes "
            "where the run ends, add a stage with them (time.stages)."
        )
    for key, then, now in accepted:
        if then != now:
            log.say(f"note: {key} is now {_short(now)}, was {_short(then)}")
    before, case = before.stages[stage], case.stages[stage]
    ends = [(each.time.end, each.output.at) for each in (before, case)]
    if not isinstance(case.time.step, float | int) and ends[0] != ends[1]:
        log.say(
            "note: under Courant control time.end and output.at shorten steps; the steps from here "
            "on are not those of a run that had them from the start"
        )
    return before


def _differences(
    before: Case, case: Case, stage: int
) -> tuple[list[tuple[str, object, object]], list[str]]:
    """Return the allowed differences, with both values, and the forbidden ones, as text."""
    accepted, refused = [], []
    for number in range(stage + 1):
        old, new = (
            each.stages[number].model_dump(by_alias=True, exclude={"time": {"stages"}})
            for each in (before, case)
        )
        label = case.stages[number].staged.title
        ends = [each.stages[number].time.end for each in (before, case)]
        changed = [(key, _taken(old, key), _taken(new, key)) for key in MAY_CHANGE]
        found = [f"{key} is {now}, was {then}" for key, then, now in _changes(old, new)]
        gone = [each.stages[number].staged.removed for each in (before, case)]
        if gone[0] != gone[1]:
            found.append(f"remove: without {_short(gone[1])}, was without {_short(gone[0])}")
        for key in ("added", "awaited"):
            came = [tuple(getattr(each.stages[number].staged, key)) for each in (before, case)]
            if key == "awaited":  # when they come is still open
                came = [tuple(sorted(names)) for names in came]
            if came[0] != came[1]:
                found.append(f"add: {key} {_short(came[1])}, was {_short(came[0])}")
        if number < stage and ends[0] != ends[1]:
            found.append(f"time.end is {ends[1]!r}, was {ends[0]!r}")
        if number:
            found = [f"{label}: {text}" for text in found]
        refused += found
        if number == stage:
            accepted = changed
        if found:
            break  # the following keys are derived from it
    return accepted, refused


def _taken(case: dict[str, Any], key: str) -> Any:
    """Remove a key from a case, and return its value."""
    *path, name = key.split(".")
    for part in path:
        case = case[part]
    return case.pop(name)


def _changes(old: object, new: object, key: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield the keys whose values differ, with both values as short text."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in dict.fromkeys((*old, *new)):
            below = f"{key}.{name}" if key else str(name)
            if name in old and name in new:
                yield from _changes(old[name], new[name], below)
            elif name in new:
                yield below, "absent", _short(new[name])
            else:
                yield below, _short(old[name]), "absent"
    elif old != new:
        yield key, _short(old), _short(new)


def _short(value: object) -> str:
    text = flow(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _made_otherwise(about: About) -> Iterator[str]:
    """Yield differences of software and CPU that may change bits, as text."""
    for name, now in made_by().items():
        then = about.made_by.get(name)
        if then != now:
            yield (
                f"the checkpoint was written with {name} {then or '(unknown)'}, this is "
                f"{now or '(unknown)'}: the last bits of the results may differ"
            )
