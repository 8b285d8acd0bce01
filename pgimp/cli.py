"""The command line: ``pgimp CASE.yaml`` runs a case, ``pgimp COMMAND ...`` does the rest."""

from __future__ import annotations

import argparse
import atexit
import difflib
import gc
import importlib
import os
import re
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from pgimp import signals
from pgimp.commands import COMMANDS
from pgimp.errors import PgimpError, RunError, UsageError
from pgimp.mpi.comm import (
    SharedUsageError,
    abort_on_error,
    describe,
    launcher,
    quiet_mpi,
    say,
    world,
)
from pgimp.terminal import guarded, silence

# A rank other than the first waits this long before it prints an error of the set-up, which other
# nodes may not have: if the first rank has it too, the launcher has ended the job by then.
_FIRST_RANK_SPEAKS_SECONDS = 3.0
_BROKEN_PIPE_STATUS = 141
# How launchers take the number of ranks, in one word or two.
_RANKS = re.compile(r"(?:-n|-np|--np|--ntasks|--ranks)(?:=?(\d+))?")
# These and a run are on all ranks; the other commands run on one and never initialise MPI.
_PARALLEL = ("run", "bench")
# These read cases, whose materials may come from outside the package.
_IMPORTING = ("run", "check", "study", "batch", "schema", "element", "report")

COMMAND_LIST = "commands:\n" + "\n".join(
    f"  {name:<10} {summary}" for name, summary in COMMANDS.items()
)
OVERVIEW = f"""\
usage: pgimp CASE.yaml [options]               run a case on one rank
       mpirun -n N pgimp CASE.yaml [options]   run it on N ranks, with the same result
       pgimp COMMAND ...

{COMMAND_LIST}

`pgimp --help` lists the options of a run, `pgimp COMMAND --help` those of a command."""


class Parser(argparse.ArgumentParser):
    """An argument parser that answers once for all ranks and raises its errors."""

    def error(self, message: str) -> NoReturn:
        """Raise a `SharedUsageError` with the usage line that belongs to it."""
        raise SharedUsageError(f"{message}\n{self.format_usage().rstrip()}")

    def print_help(self, file: Any = None) -> None:
        """Print the help, on the first rank."""
        if _is_first_rank():
            print(self.format_help(), end="", file=file, flush=True)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        The words after ``pgimp``; those of the process by default.

    Returns
    -------
    int
        The exit status: 0 done, 1 failed, 2 the case or the command line is wrong.
    """
    gc.set_threshold(100_000)  # searching all modules for garbage takes a twentieth of a start
    atexit.register(gc.freeze)  # and of its end
    with guarded() as out:
        try:
            status = _dispatch(list(sys.argv[1:] if argv is None else argv))
            out.flush()
            return status
        except KeyboardInterrupt as error:
            return _report_error(error, 130)
        except PgimpError as error:
            return _report_error(error, error.exit_status)
        except Exception as error:
            if signals.interrupted:
                return _report_error(KeyboardInterrupt(), 130)
            if error is not out.error:
                return _report_error(error, 1)
            silence(out)
            if isinstance(error, BrokenPipeError):  # the reader has seen enough
                return _BROKEN_PIPE_STATUS
            return _report_error(RunError(f"cannot write to standard output: {error.strerror}"), 1)


def _dispatch(words: list[str]) -> int:
    if not words:
        raise SharedUsageError(f"which case?\n{OVERVIEW}")
    name = words[0]
    if name in COMMANDS:
        return _execute(name, words[1:])
    if "--version" in words:
        from importlib.metadata import version

        if _is_first_rank():
            print(f"pgimp {version('pgimp')}")
        return 0
    if wrong := _slip(words):
        raise SharedUsageError(wrong)
    return _execute("run", words)


def _slip(words: list[str]) -> str:
    """Return the probable meaning of words that are no run of a case; empty if they may be."""
    name, rest = words[0], shlex.join(words[1:])
    if name == "run" and not os.path.exists(name):
        if not rest:
            return "there is no command run: a case is run with `pgimp CASE.yaml`. Which case?"
        return f"there is no command run: a case is run with `pgimp {rest}`"
    if name.isidentifier() and len(words) > 1 and not os.path.exists(name):
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        if near:
            return f"there is no command {name}. Did you mean `pgimp {near[0]} {rest}`?"
    for place, word in enumerate(words):
        if (found := _RANKS.fullmatch(word)) is None:
            continue
        number = found[1] or next(iter(words[place + 1 :]), "")
        if number.isdecimal():
            others = words[:place] + words[place + (1 if found[1] else 2) :]
            return (
                "the number of ranks is for the launcher: "
                f"`mpirun -n {number} {shlex.join(['pgimp', *others])}`"
            )
    return ""


def parser_of(name: str) -> Parser:
    """Return the parser of a command's words.

    Parameters
    ----------
    name : str
        One of `COMMANDS`, or ``run``.

    Returns
    -------
    Parser
        For the words after it; for all words of a run.
    """
    if name == "run":
        parser = Parser(
            prog="pgimp",
            usage="pgimp CASE.yaml [options]",
            description="Run a case; under mpirun on all its ranks.",
            epilog=COMMAND_LIST,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        parser.add_argument("--version", action="store_true", help="print the version and exit")
    else:
        summary = COMMANDS[name]
        parser = Parser(
            prog=f"pgimp {name}",
            description=f"{summary[0].upper()}{summary[1:]}.",
            allow_abbrev=False,
        )
    importlib.import_module(f"pgimp.commands.{name}").add_arguments(parser)
    if name == "completion":
        parser.set_defaults(parser_of=parser_of)  # commands know no command line but their own
    if name in _IMPORTING:
        parser.add_argument(
            "--import",
            dest="imports",
            metavar="FILE.py",
            action="append",
            default=[],
            help="a Python file or module that registers materials or functions; repeatable",
        )
    return parser


def _execute(name: str, words: list[str]) -> int:
    parallel = name in _PARALLEL
    if not parallel and not _is_first_rank():
        return 0
    started = launcher()
    if started is None or started.size == 1 or not parallel:
        quiet_mpi()
    arguments = parser_of(name).parse_args(words)
    implementation = importlib.import_module(f"pgimp.commands.{name}")
    if not parallel:
        _import(arguments)
        return implementation.execute(arguments)
    comm = world()
    with abort_on_error(comm):
        _import(arguments)
        if name == "run":
            missing = comm.bcast(_why_no_case(arguments.case) if comm.rank == 0 else "")
            if missing:
                raise UsageError(missing)
        return implementation.execute(arguments)


def _import(arguments: argparse.Namespace) -> None:
    """Import what the command line names; without that, no material is imported yet."""
    if names := getattr(arguments, "imports", None):
        from pgimp.physics.materials.registry import import_file

        for name in names:
            import_file(name)


def _why_no_case(name: str) -> str:
    """Return why there is no such file, and a likely correction; empty if there is one."""
    path = Path(name)
    if os.path.isdir(name):
        return f"{name} is a directory; a case is a YAML file"
    if os.path.exists(name):
        return ""
    if name in COMMANDS:
        return f"the command must be the first word: pgimp {name} ..."
    if not path.suffix and path.parent == Path("."):
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        hint = f" Did you mean `pgimp {near[0]}`?" if near else ""
        return (
            f"'{name}' is neither a case file here nor a command.{hint}\n"
            f"Commands are {', '.join(COMMANDS)}; a case is a YAML file."
        )
    try:
        there = [str(path.parent / entry.name) for entry in path.parent.glob("*.y*ml")]
    except OSError:
        there = []
    near = difflib.get_close_matches(str(path), there, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return f"there is no case file {name}.{hint}"


def _is_first_rank() -> bool:
    started = launcher()
    return started is None or started.rank == 0


def _report_error(error: BaseException, status: int) -> int:
    if not _is_first_rank():
        # Open MPI kills all ranks when one ends like this that has not begun with MPI: the first
        # one, too, which then has not spoken yet.
        time.sleep(_FIRST_RANK_SPEAKS_SECONDS)
        if isinstance(error, SharedUsageError):
            return status
    say(describe(error))
    return status
