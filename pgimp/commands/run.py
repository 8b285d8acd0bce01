"""The main job: ``pgimp CASE.yaml`` runs a case on all ranks and writes its run directory."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from pgimp.errors import RunError, UsageError
from pgimp.output.collective import explain, on_root
from pgimp.output.frames import Frames
from pgimp.output.history import History
from pgimp.output.interrupt import Interrupt
from pgimp.output.log import Log, timing_table
from pgimp.output.progress import Progress, duration, terminal_columns
from pgimp.output.rundir import RunDirectory
from pgimp.output.runinfo import describe_start, installed
from pgimp.output.schedule import Schedule
from pgimp.parallel.comm import abort_on_error, describe, world

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.output.reader import Run

#: Part of the mass past a wall that is worth a note.
_NEGLIGIBLE = 1e-6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line of a run.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser to add to.
    """
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
    parser.add_argument(
        "--overwrite", action="store_true", help="replace the run that the directory holds"
    )
    parser.add_argument("--quiet", action="store_true", help="nothing on the terminal but errors")


def execute(args: argparse.Namespace) -> int:
    """Run the case that the command line names; collective.

    Parameters
    ----------
    args : argparse.Namespace
        What `add_arguments` declares.

    Returns
    -------
    int
        0; every failure is an exception.

    Raises
    ------
    CaseError, UsageError
        On every rank, if the case or the command line is wrong.
    RunError
        If the run fails, on the ranks that find it.
    """
    comm = world()
    text = _read(args.case, comm)
    case = _parse(text, args.case, args.set)
    output = Path(args.output or f"{Path(args.case).stem}.out")
    _run(case, text, comm, output, args.overwrite, args.quiet)
    return 0


def run(
    case: Case | str | Path,
    comm: Any = None,
    output: str | Path | None = None,
    *,
    overrides: Sequence[str] = (),
    overwrite: bool = False,
    quiet: bool = False,
) -> Run:
    """Run a case from Python; collective.

    Parameters
    ----------
    case : Case, str or Path
        A case, or the name of its file.
    comm : communicator, optional
        Of all ranks; by default all that the launcher started.
    output : str or Path, optional
        The run directory; by default the name of the case's file with ``.out``, in the working
        directory. A case that comes from no file needs one.
    overrides : sequence of str
        Changes to the case's file, as ``key.path=value``.
    overwrite : bool
        Whether a run that the directory holds may be replaced.
    quiet : bool
        Whether the terminal gets nothing but errors.

    Returns
    -------
    Run
        The results, as `pgimp.open` gives them.

    Raises
    ------
    CaseError, UsageError
        If the case is wrong or the directory cannot be used.
    RunError
        If the run fails. On more than one rank this ends the whole job with status 1.
    """
    from pgimp.output import reader

    comm = world() if comm is None else comm
    with abort_on_error(comm):
        text = None
        if isinstance(case, str | Path):
            output = f"{Path(case).stem}.out" if output is None else output
            text = _read(str(case), comm)
            case = _parse(text, str(case), list(overrides))
        elif overrides:
            raise UsageError("overrides change a case's file; change the Case itself instead")
        if output is None:
            raise UsageError("a case that comes from no file needs output=, its run directory")
        _run(case, text, comm, Path(output), overwrite, quiet)
    return reader.open(output)


def _read(name: str, comm: Any) -> bytes:
    """Let rank 0 read the case file for all."""

    def read() -> bytes:
        try:
            return Path(name).read_bytes()
        except OSError as error:
            raise UsageError(f"cannot read the case {name}: {explain(error)}") from error

    return on_root(comm, read)


def _parse(text: bytes, name: str, overrides: list[str]) -> Case:
    from pgimp.case.reader import read_case

    return read_case(text, name, overrides)


def _run(
    case: Case, text: bytes | None, comm: Any, output: Path, overwrite: bool, quiet: bool
) -> None:
    from pgimp.case.reader import dump_case

    log = Log(comm.rank == 0, quiet)
    directory = RunDirectory(output, comm, overwrite)
    try:
        log.say(f"pgimp {installed('pgimp') or '(not installed)'}: {case.title or output.stem}")
        sim = _set_up(case, comm, log)
        texts = {"case.yaml": dump_case(case).encode()} | ({"input.yaml": text} if text else {})
        directory.prepare(texts, describe_start(comm, sim.count))
        log.keep_in(output / "log.txt")
        _advance(case, sim, directory, log)
    finally:
        directory.release()
        log.close()


def _set_up(case: Case, comm: Any, log: Log) -> Any:
    from pgimp.solver.simulation import Simulation

    began = perf_counter()
    sim = Simulation(case, comm)
    ranks = f"{comm.size} ranks" if comm.size > 1 else "1 rank"
    log.say(
        f"{sim.count} particles in {sim.scene.dimension}D on {ranks}, "
        f"to t = {case.time.end:.6g}; set up in {duration(perf_counter() - began)}"
    )
    for note in sim.notes:
        log.say(f"note: {note}")
    for warning in sim.warnings:
        log.say(f"warning: {warning}")
    return sim


def _advance(case: Case, sim: Any, directory: RunDirectory, log: Log) -> None:
    """Take all steps, with frames and history lines where they fall due."""
    frames = Frames(directory.path, case, sim)
    if sim.comm.size > 1 and not frames.parallel:
        log.say("note: this h5py has no MPI, so frames go through rank 0 block by block")
    history = History(directory.path / "history.csv")
    frame_times = Schedule(case.output.every, case.output.at)
    history_times = Schedule(case.history.every)
    seconds = {"frames": 0.0, "history": 0.0}

    def record(frame: bool, line: bool) -> None:
        start = perf_counter()
        if line:
            history.write(sim)
        middle = perf_counter()
        if frame:
            frames.write(sim)
        seconds["history"] += middle - start
        seconds["frames"] += perf_counter() - middle

    progress = Progress(log, sim, case.time.end, terminal_columns() if log.speaks else 0)
    began = perf_counter()
    try:
        with Interrupt() as interrupt:
            record(frame=True, line=True)
            framed = True
            while not sim.finished:
                sim.advance()
                time, step, dt = sim.time, sim.step, sim.dt
                framed = frame_times.due(time, step, dt)
                line = history_times.due(time, step, dt)
                if framed or line:
                    record(framed, line)
                progress.step()
                interrupt.check()
            record(frame=not framed, line=True)
    except BaseException as error:
        state = "stopped" if isinstance(error, KeyboardInterrupt) else "failed"
        directory.record_failure(state, sim.step, sim.time, describe(error))
        if isinstance(error, RunError):
            raise RunError(f"{error}\n  {_intact(frames, directory)}") from error
        raise
    finally:
        progress.close()
        history.close()
    total = perf_counter() - began
    _close(sim, frames.written, directory, log, seconds, total)


def _intact(frames: Frames, directory: RunDirectory) -> str:
    if not frames.written:
        return f"{directory.path} holds no frame"
    number = "1 frame" if frames.written == 1 else f"{frames.written} frames"
    return f"{directory.path} holds {number}, to t = {frames.latest:.6g}, and history.csv"


def _close(
    sim: Any,
    frames: int,
    directory: RunDirectory,
    log: Log,
    seconds: dict[str, float],
    total: float,
) -> None:
    """Say what was done, and note it in run.json."""
    output = sum(seconds.values())
    rate = sim.count * sim.step / total if total > 0.0 else 0.0
    log.say(
        f"done: t = {sim.time:.6g} after {sim.step} steps in {duration(total)}, "
        f"{rate:.3g} particle-steps/s; output took {100.0 * output / max(total, 1e-9):.0f} %"
    )
    collection = shlex.quote(str(directory.path / "particles.xdmf"))
    log.say(
        f"{frames} frame{'s' if frames > 1 else ''} and history.csv in {directory.path}; "
        f"look at them with: paraview {collection}"
    )
    clamped = sim.comm.allreduce(sim.clamped)
    if clamped:
        share = 100.0 * clamped / (sim.count * sim.step)
        log.say(
            f"note: in {clamped} particle-steps ({share:.2g} %) a particle was stretched to a "
            "half-width of more than one cell; its reach is held at one cell, so that neighbours "
            "may lose contact: use fewer or larger cells along the stretch"
        )
    part, when, face = sim.diagnostic_sums.beyond
    if part > _NEGLIGIBLE:
        log.say(
            f"note: particles carried up to {100.0 * part:.2g} % of the mass past {face} (t = "
            f"{when:.6g}); what lies there the wall bears, so the rest is light by as much: a size "
            "that follows the deformation (finite-gimp), or wall: mirror, avoids that"
        )
    table = timing_table(sim.comm, dict(sim.timings) | seconds, total)
    log.note(f"\n{table}")
    directory.finish(sim.step, sim.time, total - output)
