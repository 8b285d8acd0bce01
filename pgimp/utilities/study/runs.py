"""Runs of a study: started in turn, or found finished."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

from pgimp.errors import NO_REST, PgimpError
from pgimp.io.results import history
from pgimp.io.results.reader import Run
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import RUN
from pgimp.jit.outside import unchanged
from pgimp.physics.materials.registry import imported
from pgimp.schema.document import LARGEST_FILE
from pgimp.storage.plain import read_plain
from pgimp.utilities.study import sliding
from pgimp.utilities.study.cases import Planned
from pgimp.utilities.study.measure_entry import LIMIT, measure_of
from pgimp.utilities.study.measures import MeasureError, costs, measure
from pgimp.utilities.study.schema import Study

DONE, FAILED, ABSENT = sliding.DONE, "failed", "not run"

# Signals that end a run, first with a checkpoint, then at once; with waiting times in seconds.
_PATIENCE = (
    (signal.SIGINT, 10.0),
    (signal.SIGINT, 2.0),
    (signal.SIGTERM, 5.0),
    (signal.SIGKILL, None),
)
_LINES_OF_TRACEBACK = 2
_REST = re.compile(r"  (try: |.* holds (no|\d+) frames?)")
_LONGEST_MESSAGE = 600
_LOOK_SECONDS = 0.2
_TAIL_BYTES = 20_000


@dataclass
class Outcome:
    """Outcome of a run."""

    plan: Planned
    state: str = ABSENT
    reused: bool = False
    message: str = ""
    info: dict[str, Any] = field(default_factory=dict)
    """Its run.json, if it is done."""
    error: float | None = None
    value: float | None = None
    """The column itself, where the error is its difference from a limit."""
    moved: float | None = None
    """Of a bisection: the greatest displacement in a stage that settles; None if there is none."""
    slid: float | None = None
    """The limit that `moved` is above, though the run has come to rest."""
    columns: dict[str, float] = field(default_factory=dict)
    costs: dict[str, float] = field(default_factory=dict)
    order: float | None = None
    """Observed between the next coarser run of the curve and this one."""
    fronts: list[str] = field(default_factory=list)
    """The measures of cost on whose Pareto front it is."""


def command(study: Study, run: Planned, output: Path) -> list[str]:
    """Return the command of a run, word by word."""
    words = [*study.words, sys.executable, "-m", "pgimp", run.file]
    words += [word for option in run.options for word in ("--set", option)]
    words += [word for name in imported for word in ("--import", name)]
    return [*words, "-o", str(output), "--overwrite", "--quiet"]


def perform(
    study: Study,
    run: Planned,
    output: Path,
    again: bool = False,
    check: Callable[[], None] = lambda: None,
) -> Outcome:
    """Run a case, unless the same run exists already, and measure it.

    Parameters
    ----------
    study : Study
        The study, with the launcher of runs and the measures.
    output : Path
        Its directory.
    again : bool
        Whether a finished run is run again.
    check : callable
        Called repeatedly; its exceptions end the run, and are then passed on.
    """
    check()
    outcome = Outcome(run)
    outcome.reused = not again and _is_done(study, run, output, _last_start(output))
    if not outcome.reused and (why := _execute(study, run, output, check)):
        outcome.state, outcome.message = FAILED, why
        return outcome
    outcome.info = _last_start(output)
    _measure(study, output, outcome)
    return outcome


def rests(
    study: Study,
    run: Planned,
    output: Path,
    again: bool = False,
    check: Callable[[], None] = lambda: None,
) -> Outcome:
    """Run a case that settles, unless the same run exists already.

    The parameters are those of `perform`. The outcome is done with the value 1 if it has come to
    rest without sliding, with 0 if it has not; any other end is a failure.
    """
    check()
    assert study.bisect is not None
    outcome = Outcome(run)
    info = _last_start(output)
    state = DONE if _has_no_rest(info) else info.get("state")
    outcome.reused = not again and _is_done(study, run, output, {**info, "state": state})
    if outcome.reused:
        outcome.reused = sliding.known(study.bisect, Run(output).case, info)
    why = "" if outcome.reused else _execute(study, run, output, check)
    outcome.info = info = _last_start(output)
    if why and not _has_no_rest(info):
        outcome.state, outcome.message = FAILED, why
        return outcome
    outcome.costs = costs(info["particles"], info["steps"], info["ranks"], info["seconds"])
    try:
        ended = Run(output)
        outcome.moved = sliding.moved(study.bisect, ended)
        outcome.slid = sliding.slid(study.bisect, ended, outcome.moved)
    except PgimpError as error:
        outcome.state, outcome.message = FAILED, str(error)
        return outcome
    outcome.state, outcome.value = DONE, float(info["state"] == DONE and outcome.slid is None)
    return outcome


def _has_no_rest(info: dict[str, Any]) -> bool:
    """Whether a run has ended because it has not come to rest."""
    return info.get("state") == FAILED and NO_REST in str(info.get("message"))


def _last_start(output: Path) -> dict[str, Any]:
    content = runinfo.read(output / RUN)
    return content["starts"][-1] if content else {}


def _is_done(study: Study, run: Planned, output: Path, info: dict[str, Any]) -> bool:
    """Return whether the directory has this run, finished by this version on as many ranks."""
    if info.get("state") != DONE or info.get("seconds") is None:
        return False
    version = info.get("versions", {}).get(runinfo.PROGRAM)
    if info.get("ranks") != study.ranks or version != runinfo.installed(runinfo.PROGRAM):
        return False
    if not unchanged(info.get("materials", {}) | info.get("functions", {})):
        return False
    with suppress(OSError, ValueError):
        return read_plain(output / "case.yaml", LARGEST_FILE).decode() == run.resolved
    return False


def _execute(study: Study, run: Planned, output: Path, check: Callable[[], None]) -> str:
    """Run the case; return the reason for a failure, empty if successful."""
    words = command(study, run, output)
    with tempfile.TemporaryFile() as said:
        try:
            process = subprocess.Popen(
                words,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C reaches it only through _end
            )
        except OSError as error:
            return f"cannot start {shlex.quote(words[0])}: {error.strerror or error}"
        try:
            status = _wait(process, study.timeout, check)
        except subprocess.TimeoutExpired:
            _end(process)
            return f"stopped after {study.timeout:g} s, the study's timeout"
        except BaseException:
            _end(process)
            raise
        said.seek(max(0, said.seek(0, os.SEEK_END) - _TAIL_BYTES))
        text = said.read().decode(errors="replace")
    if status == os.EX_TEMPFAIL:
        return str(_last_start(output).get("message"))
    if status != 0:
        return last_words(text, status)
    info = _last_start(output)
    if info.get("state") != DONE:
        return f"ended without a finished run in {output}"
    if info["ranks"] != study.ranks:
        return f"the launcher started {info['ranks']} ranks instead of {study.ranks}"
    return ""


def _wait(
    process: subprocess.Popen[bytes], seconds: float | None, check: Callable[[], None]
) -> int:
    """Wait until a run has ended, or the time is over; return its exit status."""
    until = time.monotonic() + (inf if seconds is None else seconds)
    while True:
        left = until - time.monotonic()
        try:
            return process.wait(min(_LOOK_SECONDS, max(left, 0.0)))
        except subprocess.TimeoutExpired:
            if left <= 0.0:
                raise
        check()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a run with all its children, by force after a while."""
    for number, seconds in _PATIENCE:
        if signal.getsignal(number) == signal.SIG_IGN:
            continue  # the run inherits that, for example from a job script's ``&``
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with suppress(subprocess.TimeoutExpired, KeyboardInterrupt):
            process.wait(seconds)
            break
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # its children


def last_words(text: str, status: int) -> str:
    """Return the reason of a run's failure in one line, from its output and exit status.

    Parameters
    ----------
    text : str
        Output: pgimp's own message starts with ``pgimp:``, a launcher's remarks may follow.
    status : int
        Exit status, negative for a signal.
    """
    lines = [line.rstrip() for line in text.splitlines()]
    starts = [i for i, line in enumerate(lines) if line.startswith("pgimp: ")]
    if starts:
        # Advice and the intact files follow; the launcher's text comes after dashes.
        kept = [lines[starts[-1]].removeprefix("pgimp: ")]
        for line in lines[starts[-1] + 1 :]:
            if not line or line.startswith("---") or _REST.match(line):
                break
            kept.append(line.strip())
    else:
        kept = [line.strip() for line in lines if line.strip("-= ")]
        if any(line.startswith("Traceback") for line in kept):
            kept = kept[-_LINES_OF_TRACEBACK:]
    if status < 0:
        with suppress(ValueError):
            kept.append(f"(ended by {signal.Signals(-status).name})")
    message = " ".join(kept) or f"ended with status {status} and said nothing"
    limit = _LONGEST_MESSAGE
    return message if len(message) <= limit else message[: limit - 3] + "..."


def _measure(study: Study, output: Path, outcome: Outcome) -> None:
    """Read cost and error from the run's directory."""
    info = outcome.info
    outcome.costs = costs(info["particles"], info["steps"], info["ranks"], info["seconds"])
    try:
        lines = history.read(output / "history.csv")
        outcome.error = measure(lines, study.measure)
        if study.measure.reference == LIMIT:
            outcome.value, outcome.error = outcome.error, None
    except (MeasureError, PgimpError) as error:
        outcome.state, outcome.message = FAILED, str(error)
        return
    outcome.state = DONE
    lacking = []
    for quantity in map(measure_of, study.columns):
        try:
            outcome.columns[quantity.label] = measure(lines, quantity)
        except MeasureError as error:
            lacking.append(str(error))
    outcome.message = "; ".join(lacking)
