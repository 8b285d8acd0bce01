"""``pgimp study STUDY.yaml``: runs a case many times with changes; error against cost."""

from __future__ import annotations

import argparse
import fcntl
import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from pgimp.errors import PgimpError, UsageError, explain
from pgimp.io.rundir.ownfiles import REPORT, RUN
from pgimp.mpi.comm import launcher
from pgimp.running.log import Log
from pgimp.running.progress import duration, terminal_columns
from pgimp.running.stop import Held
from pgimp.storage import atomic
from pgimp.terminal import unescaped
from pgimp.utilities.check.prepare import prepare
from pgimp.utilities.study import brackets
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.bisection import Bracket, run_all
from pgimp.utilities.study.measures import number
from pgimp.utilities.study.plan import Plan, read_plan
from pgimp.utilities.study.runs import DONE, Outcome, command, perform
from pgimp.utilities.study.tables import as_csv, as_markdown, compare

TABLE, PAGE, PICTURE, COPY = "study.csv", "study.md", "study.png", "study.yaml"
_LOCK = ".lock"
_BAR_COLUMNS = 24
_REFRESHES = 2.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument("study", metavar="STUDY.yaml", help="the study file")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="where runs, tables and plot go (default: the study's key folder, or its name with "
        ".study.out, where pgimp is started)",
    )
    parser.add_argument(
        "--list", action="store_true", help="check the study and print its runs, but run nothing"
    )
    parser.add_argument(
        "--again", action="store_true", help="run also what is done already from an earlier call"
    )
    parser.add_argument("--quiet", action="store_true", help="nothing on the terminal but errors")


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        0 if every run has a result, 1 otherwise.

    Raises
    ------
    CaseError, UsageError
        If the study, one of its cases or the command line is wrong; nothing is run.
    KeyboardInterrupt
        After Ctrl-C; the tables have the runs finished so far.
    """
    started = launcher()
    if started is not None:
        raise UsageError(
            f"{started.name} started this process, but a study starts its runs itself: call it "
            "without a launcher, and name launcher and ranks in the study"
        )
    plan = read_plan(args.study, prepare if args.list else None)
    folder = _folder(args, plan)
    if args.list:
        values = plan.study.bisect.between if plan.study.bisect else ()
        tried = [one.planned(value) for one in plan.bisected for value in values]
        for run in (*plan.runs, *tried):
            print(shlex.join(command(plan.study, run, folder / "runs" / run.name)))
        return 0
    log = Log(True, args.quiet)
    if plan.study.bisect:
        return _bisect(plan, plan.study.bisect, folder, args.again, log)
    with _claimed(folder):
        outcomes = [Outcome(run) for run in plan.runs]
        try:
            with Held((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)) as held:
                _run_all(plan, folder, outcomes, args.again, log, held)
        finally:
            _write(plan, folder, outcomes)
        _report(folder, log)
    done = sum(one.state == DONE for one in outcomes)
    for one in outcomes:
        if one.value is not None and one.message:
            log.say(f"{one.plan.name}: {one.message}")
    log.say(f"{done} of {len(outcomes)} runs have a result; see {folder / PAGE}")
    return 0 if done == len(outcomes) else 1


def _folder(args: argparse.Namespace, plan: Plan) -> Path:
    if args.output:
        return Path(args.output)
    if plan.study.folder is not None:
        return Path(os.path.relpath(Path(args.study).parent / plan.study.folder))
    return Path(f"{plan.name}.study.out")


@contextmanager
def _claimed(folder: Path) -> Iterator[None]:
    """Create the folder and lock it against other studies."""
    if (folder / RUN).exists():
        raise UsageError(f"{folder} is the directory of a run; name another with -o")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise UsageError(f"cannot use the folder {folder}: {explain(error)}") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(lock)
        raise UsageError(
            f"a study is writing to {folder}; wait for it, stop it, or name another with -o"
        ) from None
    except OSError:
        pass  # no locks on this file system: one study at a time is then up to the user
    try:
        yield
    finally:
        os.close(lock)


def _run_all(
    plan: Plan, folder: Path, outcomes: list[Outcome], again: bool, log: Log, held: Held
) -> None:
    """Run all; replace each outcome by the outcome of its run."""
    with _bar(log, len(outcomes)) as show:
        for i, run in enumerate(plan.runs):
            show(i, run.name)
            output = folder / "runs" / run.name
            one = outcomes[i] = perform(plan.study, run, output, again, held.check)
            if one.state == DONE:
                text = f"error {number(one.error)}"
                if one.value is not None:
                    text = f"{plan.study.measure.label} {number(one.value, 6)}"
                text += f" in {duration(one.costs['wall'])}"
                text += " (from before)" if one.reused else ""
            else:
                text = f"{one.state}: {one.message}"
            log.say(f"{i + 1}/{len(outcomes)} {run.name}: {text}")


def _bisect(plan: Plan, entry: Bisection, folder: Path, again: bool, log: Log) -> int:
    """Do the bisections of a study; return the exit status."""
    found = [Bracket(variant) for variant in plan.bisected]
    with _claimed(folder):
        try:
            with Held((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)) as held:
                run_all(found, entry, folder, again, log, held.check)
        finally:
            texts: dict[str, str | bytes] = {
                COPY: plan.text,
                TABLE: brackets.as_csv(plan, found, entry),
                PAGE: brackets.as_markdown(plan, found, entry),
            }
            _store(folder, texts, None)
        _report(folder, log)
    done = sum(bracket.ended for bracket in found)
    log.say(f"{done} of {len(found)} bisections have a result; see {folder / PAGE}")
    return 0 if done == len(found) else 1


@contextmanager
def _bar(log: Log, total: int) -> Iterator[Callable[[int, str], None]]:
    """Show the number of finished runs below the lines of the log; nothing without a terminal."""
    columns = 0 if log.quiet else terminal_columns()
    if not columns:
        yield lambda done, text: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Column

    bar = Progress(
        BarColumn(bar_width=_BAR_COLUMNS),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[text]}", table_column=Column(no_wrap=True, overflow="ellipsis")),
        console=Console(file=unescaped(sys.stdout), force_terminal=True, width=columns),
        transient=True,
        refresh_per_second=_REFRESHES,  # rarely: the runs are being timed
    )
    task = bar.add_task("", total=total, text="")
    log.show = lambda text: bar.console.print(text, markup=False, highlight=False, soft_wrap=True)
    try:
        with bar:
            yield lambda done, text: bar.update(task, completed=done, text=text)
    finally:
        log.show = print


def _write(plan: Plan, folder: Path, outcomes: list[Outcome]) -> None:
    """Write tables and plot, each completely or not at all."""
    from pgimp.utilities.study.plot import picture

    compare(plan, outcomes)
    texts: dict[str, str | bytes]
    texts = {COPY: plan.text, TABLE: as_csv(plan, outcomes), PAGE: as_markdown(plan, outcomes)}
    _store(folder, texts, picture(plan, outcomes))


def _report(folder: Path, log: Log) -> None:
    """Write the report of all runs; the tables stand whatever it meets."""
    from pgimp.utilities.report.file import write
    from pgimp.utilities.report.study import report_of_study

    try:
        write(folder / REPORT, report_of_study(folder))
    except PgimpError as error:
        log.say(f"warning: no report: {error}")


def _store(folder: Path, texts: Mapping[str, str | bytes], drawn: bytes | None) -> None:
    try:
        for name, text in texts.items():
            atomic.write(folder / name, text)
        if drawn is None:
            (folder / PICTURE).unlink(missing_ok=True)
        else:
            atomic.write(folder / PICTURE, drawn)
    except OSError as error:
        raise UsageError(f"cannot write to {folder}: {explain(error)}") from error
