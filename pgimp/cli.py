"""The command line: ``pgimp CASE.yaml`` runs a case, ``pgimp COMMAND ...`` does the rest."""

from __future__ import annotations

import argparse
import difflib
import importlib
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from pgimp.errors import PgimpError, UsageError
from pgimp.parallel.comm import (
    SharedUsageError,
    abort_on_error,
    describe,
    launcher,
    quiet_mpi,
    say,
    world,
)

# A rank other than the first waits this long before it prints an error of the set-up, which other
# nodes may not have: if the first rank has it too, the launcher has ended the job by then.
_FIRST_RANK_SPEAKS_SECONDS = 3.0
_BROKEN_PIPE_STATUS = 141


class Command(NamedTuple):
    """A word of the command line; its module in `pgimp.commands` has the same name.

    Attributes
    ----------
    summary : str
        One line for the overview.
    parallel : bool
        Whether it runs on all ranks; the other commands run on one and never initialise MPI.
    """

    summary: str
    parallel: bool = False


RUN = Command("runs the case on all ranks", parallel=True)
COMMANDS = {
    "check": Command("validates a case and estimates what it will cost"),
    "study": Command("runs a case with many changes: a table and a plot of error against cost"),
    "compare": Command("tells whether two runs have the same particles, bit for bit"),
    "bench": Command("measures the speed of this machine by phase", parallel=True),
    "doctor": Command("checks that MPI, HDF5, h5py and Numba are there and fit each other"),
    "schema": Command("prints the JSON schema of the case file, for editors"),
}

COMMAND_LIST = "commands:\n" + "\n".join(
    f"  {name:<9} {command.summary}" for name, command in COMMANDS.items()
)
OVERVIEW = f"""\
usage: pgimp CASE.yaml [options]               run a case on one rank
       mpirun -n N pgimp CASE.yaml [options]   run it on N ranks, with the same result
       pgimp COMMAND ...

{COMMAND_LIST}

`pgimp --help` lists the options of a run, `pgimp COMMAND --help` those of a command."""


class Parser(argparse.ArgumentParser):
    """An argument parser that answers once for all ranks and raises what it finds wrong."""

    def error(self, message: str) -> NoReturn:
        """Raise a `SharedUsageError` with the usage line that belongs to it."""
        raise SharedUsageError(f"{message}\n{self.format_usage().rstrip()}")

    def print_help(self, file: Any = None) -> None:
        """Print the help, on the first rank."""
        if _is_first_rank():
            super().print_help(file)


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
    try:
        status = _dispatch(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # The interpreter flushes stdout once more at exit and would complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE_STATUS
    except KeyboardInterrupt as error:
        return _complain(error, 130)
    except PgimpError as error:
        return _complain(error, error.exit_status)
    except Exception as error:
        return _complain(error, 1)


def _dispatch(words: list[str]) -> int:
    if not words:
        raise SharedUsageError(f"which case?\n{OVERVIEW}")
    name = words[0]
    if name in COMMANDS:
        parser = Parser(
            prog=f"pgimp {name}",
            description=f"{COMMANDS[name].summary.capitalize()}.",
            allow_abbrev=False,
        )
        return _execute(name, COMMANDS[name], parser, words[1:])
    if "--version" in words:
        from importlib.metadata import version

        if _is_first_rank():
            print(f"pgimp {version('pgimp')}")
        return 0
    parser = Parser(
        prog="pgimp",
        usage="pgimp CASE.yaml [options]",
        description="Run a case; under mpirun on all its ranks.",
        epilog=COMMAND_LIST,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="store_true", help="print the version and exit")
    return _execute("run", RUN, parser, words)


def _execute(name: str, command: Command, parser: Parser, words: list[str]) -> int:
    if not command.parallel and not _is_first_rank():
        return 0
    started = launcher()
    if started is None or started.size == 1 or not command.parallel:
        quiet_mpi()
    implementation = importlib.import_module(f"pgimp.commands.{name}")
    implementation.add_arguments(parser)
    arguments = parser.parse_args(words)
    if not command.parallel:
        return implementation.execute(arguments)
    comm = world()
    with abort_on_error(comm):
        if command is RUN:
            missing = comm.bcast(_why_no_case(arguments.case) if comm.rank == 0 else "")
            if missing:
                raise UsageError(missing)
        return implementation.execute(arguments)


def _why_no_case(name: str) -> str:
    """Say why there is no file of this name, and what was probably meant; empty if there is one."""
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


def _complain(error: BaseException, status: int) -> int:
    if not _is_first_rank():
        if isinstance(error, SharedUsageError):
            return status
        time.sleep(_FIRST_RANK_SPEAKS_SECONDS)
    say(describe(error))
    return status
