"""``pgimp CASE.yaml``: runs a case on all ranks and writes its run directory."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from pgimp.errors import UsageError, explain
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.io.rundir.runinfo import describe_start, installed
from pgimp.mpi.collective import on_root
from pgimp.mpi.comm import abort_on_error, world
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.peers import within
from pgimp.mpi.together import end_all_on_exceptions, require_same
from pgimp.running.how import How, has_companions
from pgimp.running.log import Log
from pgimp.running.progress import duration
from pgimp.running.stop import Stop, wall_time

if TYPE_CHECKING:
    from pgimp.case.load import Source
    from pgimp.case.schema import Case
    from pgimp.io.results.reader import Run
    from pgimp.schema.overrides import Overrides
    from pgimp.solver.callbacks.callback import Each
    from pgimp.solver.callbacks.now import Now
    from pgimp.solver.simulation import Simulation

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
        ended = _run(case, text, comm, output, how, log, stop)
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
            _run(own_levels(case), text, comm, Path(output), how, log, stop, calls)
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


def _run(
    case: Case,
    text: bytes | None,
    comm: Communicator,
    output: Path,
    how: How,
    log: Log,
    stop: Stop,
    each: Each | None = None,
) -> bool:
    """Run a case in a directory; return whether it reached its end."""
    ended, again = _run_once(case, text, comm, output, how, log, stop, each)
    if not again:
        return ended
    how = how._replace(overwrite=False, resume=True)
    return _run(case, text, comm, output, how, Log(log.speaks, log.quiet), stop, each)


def _run_once(
    case: Case,
    text: bytes | None,
    comm: Communicator,
    output: Path,
    how: How,
    log: Log,
    stop: Stop,
    each: Each | None,
) -> tuple[bool, bool]:
    """Run a case; return whether it reached its end, and whether it is to run on smaller cells."""
    from pgimp.case.choices.choose import lines as chosen_lines
    from pgimp.case.choices.kept import carried
    from pgimp.case.functions import functions_of
    from pgimp.case.reader import dump_case
    from pgimp.jit.compiled.cache import announced
    from pgimp.jit.outside import digests
    from pgimp.running.resume import Resumed, as_begun
    from pgimp.running.resume import resume as load_pair
    from pgimp.running.running import advance
    from pgimp.storage.hdf5 import load_h5py

    directory = RunDirectory(output, comm, how.overwrite, how.resume, tuple(case.probes))
    try:
        log.say(f"pgimp {installed('pgimp') or '(not installed)'}: {case.title or output.stem}")
        began = perf_counter()
        if comm.rank == 0:  # takes longer than writing most frames
            load_h5py()
        with announced(log.say):
            if how.resume:
                case = as_begun(case, comm, directory)
            conclude: Callable[[], bool] = bool  # there is nothing to tell
            if has_companions(case, directory, how):
                from pgimp.utilities.accuracy import accompany

                chosen = accompany.begin(case, directory, how, log, stop, _run)
                if chosen is None:
                    return False, False
                case = carried(case, chosen.case)
                conclude = partial(accompany.conclude, chosen, directory, log, stop)
                if chosen.over:
                    how = how._replace(resume=False)
            found = load_pair(case, comm, directory, log, each) if how.resume else None
            if found == "done":
                log.say(f"{output} holds this run, done already: nothing is left to do")
                return True, conclude()
            resumed = found if isinstance(found, Resumed) else None
            sim = _set_up(case, comm, log, began, each) if resumed is None else resumed.sim
        for line in chosen_lines(case):
            log.say(f"chosen: {line}")
        for note in sim.notes:
            log.say(f"note: {note}")
        for warning in sim.warnings:
            log.say(f"warning: {warning}")
        step = None if resumed is None else sim.step
        texts = {"case.yaml": dump_case(case).encode()} | ({"input.yaml": text} if text else {})
        about = describe_start(comm, sim.count, step)
        if isinstance(case.time.step, float | int):
            about["courant"] = sim.rate * float(case.time.step)
        own = {
            "materials": digests(sim.scene.materials.parameters),
            "functions": digests(entry.source() for entry in functions_of(case)),
        }
        about |= {key: known for key, known in own.items() if known}
        if step is not None:
            _warn_of_edited(own, directory, log)
        directory.prepare(texts, about, resumed is not None)
        log.write_to(output / "log.txt")
        ended = advance(case, sim, resumed and resumed.about, directory, log, stop)
        return ended, ended and conclude()
    finally:
        directory.release()
        log.close()


def _warn_of_edited(own: dict[str, dict[str, str]], directory: RunDirectory, log: Log) -> None:
    """Warn of materials and functions of one's own that have changed since the run began."""
    for key, now in own.items():
        before = (directory.before or {}).get(key)
        for name, known in before.items() if isinstance(before, dict) else ():
            if now.get(name) != known:
                log.say(
                    f"warning: {name} is not what it was when the run began; from here on the "
                    f"{key.removesuffix('s')} acts as it does now"
                )


def _set_up(
    case: Case, comm: Communicator, log: Log, began: float, each: Each | None
) -> Simulation:
    from pgimp.solver.simulation import Simulation

    sim = Simulation(case, comm, each=each)
    ranks = f"{comm.size} ranks" if comm.size > 1 else "1 rank"
    stages = f" in {len(case.stages)} stages" if case.time.stages else ""
    log.say(
        f"{sim.count} particles in {sim.scene.dimension}D on {ranks}, "
        f"to t = {case.time.last:.6g}{stages}; set up in {duration(perf_counter() - began)}"
    )
    return sim
