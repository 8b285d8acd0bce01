"""``pgimp CASE.yaml``: runs a case on all ranks and writes its run directory."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.commands.job import Job
from pgimp.errors import UsageError, explain
from pgimp.mpi.collective import on_root
from pgimp.mpi.comm import abort_on_error, world
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.peers import within
from pgimp.mpi.together import end_all_on_exceptions, require_same
from pgimp.running.how import How
from pgimp.running.log import Log
from pgimp.running.stop import Stop, wall_time

if TYPE_CHECKING:
    from pgimp.case.load import Source
    from pgimp.case.schema import Case
    from pgimp.io.results.reader import Run
    from pgimp.schema.overrides import Overrides
    from pgimp.solver.callbacks.callback import Each
    from pgimp.solver.callbacks.now import Now

#: Exit status of a run that stopped early on request, with a checkpoint.
STOPPED = 75


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line of a run."""
    parser.add_argument("case", metavar="CASE.yaml", help="the case file")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="the run directory (default: the case's name with .out, where pgimp is started)",
    )
    parser.add_argument(
        "--set",
        metavar="KEY.PATH=VALUE",
        action="append",
        default=[],
        help="change a value of the case, for example --set grid.cell=[0.5]; repeatable",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--resume",
        action="store_true",
        help="go on from the newest intact checkpoint in the run directory; begin if there is none",
    )
    what.add_argument(
        "--overwrite", action="store_true", help="replace the run that the directory holds"
    )
    parser.add_argument(
        "--wall-time",
        metavar="HH:MM:SS",
        type=wall_time,
        help="stop in time, with a checkpoint and exit status 75, so that all ends within this",
    )
    parser.add_argument(
        "--error",
        action="store_true",
        help="run the case on larger cells first, and estimate the errors of history and probes",
    )
    parser.add_argument(
        "--forecast",
        action="store_true",
        help="only what runs on larger cells for --error, or for the case's `accuracy`, and what "
        "the run itself will cost; --resume goes on with it",
    )
    parser.add_argument("--quiet", action="store_true", help="nothing on the terminal but errors")


def execute(args: argparse.Namespace) -> int:
    """Run the case that the command line names; collective.

    Returns
    -------
    int
        0 if the run is done, 75 if it stopped early on request; every failure is an exception.

    Raises
    ------
    CaseError, UsageError
        On every rank, if the case or the command line is wrong.
    RunError
        If the run fails, on the failing ranks.
    """
    comm = world()
    text = _read(args.case, comm)
    case = _parse(text, args.case, args.set)
    output = Path(args.output or f"{Path(args.case).stem}.out")
    log = Log(comm.rank == 0, args.quiet)
    with Stop(comm, args.wall_time) as stop:
        how = How(args.overwrite, args.resume, args.error, args.forecast)
        ended = Job(comm, output, log, stop, how, text).run(case)
    return 0 if ended or (args.forecast and not stop.reason) else STOPPED


def run(
    case: Source,
    comm: Communicator | None = None,
    output: str | Path | None = None,
    *,
    overrides: Overrides = (),
    overwrite: bool = False,
    resume: bool = False,
    wall_time: float | None = None,
    error: bool = False,
    quiet: bool = False,
    each: Each | Callable[[Now], object] | None = None,
) -> Run:
    """Run a case from Python; collective.

    Parameters
    ----------
    case : Case, str, Path or mapping
        A case, the name of its file, or the file's content as a dictionary.
    comm : communicator, optional
        Of all ranks; by default all ranks that the launcher started. `pgimp.mpi.comm.Serial()` is
        this single rank, so that ranks may run separate cases.
    output : str or Path, optional
        The run directory; by default the name of the case's file with ``.out``, in the working
        directory. A case without a file needs it.
    overrides : mapping, or sequence of str
        Changes to the case, ``{"time.end": 3.0}``, as for `load`.
    overwrite : bool
        Whether an existing run in the directory may be replaced.
    resume : bool
        Whether to resume from the newest intact checkpoint in the directory, if there is one.
    wall_time : float, optional
        Seconds after which the run has stopped, with a checkpoint; its state is then "stopped".
    error : bool
        Whether the case runs on larger cells first, for the errors of its history and probes.
    quiet : bool
        Whether the terminal gets only errors.
    each : callable or Each, optional
        A function that is called after every step, or after every N, see `pgimp.Each`; with
        `resume` its state is that of the checkpoint.

    Returns
    -------
    Run
        The results, as from `pgimp.open`.

    Raises
    ------
    CaseError, UsageError
        If the case is wrong or the directory cannot be used.
    ValueError
        If `output` is empty, `wall_time` not above zero, or `each` given with companion runs.
    RunError
        If the run fails. On more than one rank this ends the whole job with status 1.
    KeyboardInterrupt, SystemExit
        After SIGINT, as from a notebook's stop button, or SIGTERM. First a checkpoint is written
        and the files are closed; ``resume=True`` continues from there.
    """
    from pgimp.case.load import load
    from pgimp.case.writer import dump_case
    from pgimp.solver.callbacks.callback import each_of
    from pgimp.solver.callbacks.levels import own_levels
    from pgimp.utilities import opened

    calls = each_of(each)
    comm = world() if comm is None else comm
    end_all_on_exceptions(comm)
    if output is not None and not str(output):
        raise ValueError("output: expected the name of a directory, got an empty one")
    if wall_time is not None and not wall_time > 0.0:
        raise ValueError(f"wall_time: expected seconds above 0, got {wall_time!r}")
    # Before any collective call in which a single rank would wait.
    require_same(comm, "pgimp.run", repr((str(output), overwrite, resume, error)))
    with abort_on_error(comm), within(comm, "pgimp.run"):
        text = None
        if isinstance(case, str | Path):
            output = f"{Path(case).stem}.out" if output is None else output
            text = _read(str(case), comm)
            case = _parse(text, str(case), overrides)
        else:
            case = load(case, overrides)
        require_same(comm, "pgimp.run", dump_case(case))
        if output is None:
            raise UsageError("a case that comes from no file needs output=, its run directory")
        if calls is not None and (error or case.accuracy is not None):
            raise ValueError("each: a companion run (error, accuracy) would call it on other cells")
        if overwrite and resume:
            raise UsageError("a run is either replaced or resumed; choose one")
        with Stop(comm, wall_time) as stop:
            log = Log(comm.rank == 0, quiet)
            how = How(overwrite, resume, error)
            Job(comm, Path(output), log, stop, how, text, calls).run(own_levels(case))
    return opened.open(output)


def _read(name: str, comm: Communicator) -> bytes:
    """Read the case file on rank 0 for all."""

    def content() -> bytes:
        from pgimp.schema.document import read

        try:
            return read(name)
        except OSError as error:
            raise UsageError(f"cannot read the case {name}: {explain(error)}") from error

    return on_root(comm, content)


def _parse(text: bytes, name: str, overrides: Overrides) -> Case:
    from pgimp.case.reader import read_case

    return read_case(text, name, overrides)
