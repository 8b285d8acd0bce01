"""Running a simulation with all its output, to its end or a requested stop."""

from __future__ import annotations

import shlex
from time import perf_counter

from pgimp.case.schema import Case
from pgimp.errors import EndlessError, NoRestError, RunError
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import describe
from pgimp.running import failure
from pgimp.running.checkpoints import About
from pgimp.running.log import Log, timing_table
from pgimp.running.progress import Progress, duration, terminal_columns
from pgimp.running.recorder import Recorder
from pgimp.running.stop import Stop
from pgimp.solver.reduction import Request
from pgimp.solver.simulation import Simulation
from pgimp.solver.time.held_rate import WORTH

#: Fraction of the mass past a wall above which a note is shown.
_NEGLIGIBLE = 1e-6
#: Fraction of the mass, or of all particle-steps, above which results may be visibly wrong.
_MATTERS = 1e-3


def advance(
    case: Case, sim: Simulation, about: About | None, directory: RunDirectory, log: Log, stop: Stop
) -> bool:
    """Do all steps, with frames, history lines and checkpoints when they are due; collective.

    Parameters
    ----------
    case : Case
        The case.
    sim : Simulation
        At its start, or as resumed.
    about : About or None
        Header of the checkpoint of a resumed run.
    directory : RunDirectory
        Prepared for the run.
    log : Log
        Receives messages.
    stop : Stop
        Decides about a stop before the end, with a checkpoint.

    Returns
    -------
    bool
        Whether the end was reached.

    Raises
    ------
    RunError
        If the run fails, on the ranks that find it.
    """
    recorder = Recorder(directory, case, sim)
    progress = Progress(log, sim, case.time.last, terminal_columns() if log.speaks else 0)
    began, first = perf_counter(), sim.step
    try:
        stopped = False
        if sim.preparing:
            if about:
                recorder.checkpoints.resume(sim.comm, sim.step, about)
            stopped = _settle(sim, recorder, progress, log, stop)
            about = None
        if not sim.preparing:
            _begin(recorder, about, log)
        # Signals before the first step, also during set-up, were deferred until here.
        stopped = stopped or stop.agree(recorder.checkpoints.seconds if about is None else 0.0)
        while not (stopped or sim.finished):
            if sim.stage_done:
                _next_stage(sim, recorder, log)
            each = (perf_counter() - began) / (sim.step - first + 1)
            sim.request = _request(sim, recorder, stop, each)
            settling = sim.settling
            sim.advance(complete=False)
            if settling and not sim.settling:
                _say_settled(sim, sim.step - sim.clock.before, log)
            recorder.step()
            progress.step()
            if sim.watch and sim.watch.said:
                log.say(f"warning: {sim.watch.said.pop(0)}")
            _warn(sim, log)
            stopped = sim.agreed_request == Request.STOP
        sim.complete_reduction()
        if not sim.finished:
            stop.agree(0.0)
            recorder.checkpoint()
            ended = False
        else:
            recorder.end()
            _warn(sim, log)
            _note_held(sim, log)
            ended = True
    except BaseException as error:
        spent = perf_counter() - began - sum(recorder.seconds.values())
        if isinstance(error, NoRestError) and not sim.preparing:  # what moves is seen
            recorder.show()
        if sim.failure or isinstance(error, EndlessError | NoRestError):
            recorder.salvage()
        state = "stopped" if isinstance(error, KeyboardInterrupt) else "failed"
        directory.record_failure(state, sim.step, sim.time, describe(error), spent)
        if isinstance(error, RunError):
            stage = f"\n  in {sim.case.staged.title}" if len(sim.cases) > 1 else ""
            text = f"{error}{stage}\n  {recorder.kept()}"
            bundle = failure.write(directory.path, sim, str(error), recorder.history.path)
            if bundle:
                text += f"\n  {bundle} shows the particles: report.txt, particles.xdmf for ParaView"
            raise type(error)(text) from error
        raise
    finally:
        progress.close()
        recorder.close()
    total = perf_counter() - began
    if ended:
        _say_done(sim, first, recorder, directory, log, total)
    else:
        log.say(
            f"stopped {stop} at step {sim.step}, t = {sim.time:.6g}, with a checkpoint; the same "
            "command with --resume goes on"
        )
    seconds = recorder.seconds
    table = timing_table(sim.comm, dict(sim.rank.timings) | seconds, total)
    log.note(f"\n{table}")
    if text := sim.balance.summary():
        log.note(text)
    directory.finish(
        "done" if ended else "stopped",
        sim.step,
        sim.time,
        total - sum(seconds.values()),
        None if ended else f"stopped {stop}",
    )
    return ended


def _begin(recorder: Recorder, about: About | None, log: Log) -> None:
    """Write the state at time 0, or continue the output of a resumed run; collective."""
    if about is None:
        recorder.begin()
        return
    for note in recorder.resume(about):
        log.say(f"note: {note}")


def _settle(sim: Simulation, recorder: Recorder, progress: Progress, log: Log, stop: Stop) -> bool:
    """Do the steps before time 0 until the run is at rest; whether it was stopped; collective."""
    log.say("settling before time 0")
    (began, first), stopped = (perf_counter(), sim.step), stop.agree(recorder.checkpoints.seconds)
    while sim.preparing and not stopped:
        each = (perf_counter() - began) / (sim.step - first + 1)
        sim.request = _request(sim, recorder, stop, each)
        sim.advance(complete=False)
        if sim.preparing:
            recorder.settle()
        progress.step()
        stopped = sim.agreed_request == Request.STOP
    if not sim.preparing:
        _say_settled(sim, sim.step, log, "; time 0 begins")
    return stopped


def _say_settled(sim: Simulation, steps: int, log: Log, what: str = "") -> None:
    log.say(
        f"settled in {steps} steps: the unbalanced force is {sim.unbalanced:.3g} of the "
        f"forces of stresses and tractions{what}"
    )


def _warn(sim: Simulation, log: Log) -> None:
    """Show warnings that follow from the history's sums."""
    said = sim.diagnostic_sums.said
    while said:
        log.say(f"warning: {said.pop(0)}")


def _next_stage(sim: Simulation, recorder: Recorder, log: Log) -> None:
    """Write the state at the end of a stage, and begin the next stage; collective."""
    sim.complete_reduction()
    recorder.end()
    _note_held(sim, log)
    known = len(sim.warnings)
    sim.next_stage()
    recorder.enter()
    staged = sim.case.staged
    to = "until it is at rest" if sim.settling else f"to t = {sim.case.time.end:.6g}"
    log.say(
        f"stage {staged.number + 1} of {len(sim.cases)}, '{staged.name}': from t = {sim.time:.6g}, "
        f"step {sim.step}, {to}"
    )
    for warning in sim.warnings[known:]:
        log.say(f"warning: {warning}")


def _note_held(sim: Simulation, log: Log) -> None:
    """Log the number of a stage's steps that were shorter than necessary."""
    held = sim.clock.held
    if held and held.waited:
        log.note(
            f"note: {held.waited} steps could have been longer by {100.0 * WORTH:.0f} % or more: "
            f"they shorten at once, and lengthen only after {held.window} in a row that could"
        )


def _request(sim: Simulation, recorder: Recorder, stop: Stop, step: float) -> Request:
    """Request of this rank after the next step; `step` is the duration of a step.

    Ranks may agree on it a step later, see `Simulation.advance`. Until then a checkpoint must not
    be requested again.
    """
    if stop.requested(recorder.checkpoints.seconds + 3.0 * step):
        return Request.STOP
    known = sim.agreed or sim.request != Request.CHECKPOINT
    if sim.comm.rank == 0 and recorder.checkpoints.overdue and known:
        return Request.CHECKPOINT
    return Request.NONE if recorder.ready else Request.PENDING


def amount(size: float) -> str:
    """Format a number of bytes with three digits."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"


def _tell(log: Log, matters: bool, what: str, wrong: str) -> None:
    """Show an event and the wrong result if it matters; else only log the event."""
    if matters:
        log.say(f"note: {what}: {wrong}")
    else:
        log.note(f"note: {what}: too little to matter")


def _say_done(
    sim: Simulation, first: int, recorder: Recorder, directory: RunDirectory, log: Log, total: float
) -> None:
    """Return a summary of the steps since `first`, in `total` seconds."""
    output = sum(recorder.seconds.values())
    steps = sim.step - first
    rate = sim.comm.allreduce(sim.rank.particle_steps) / max(total, 1e-9)
    since = f" since step {first}" if first else ""
    log.say(
        f"done: t = {sim.time:.6g} after {steps} steps{since} in {duration(total)}, "
        f"{rate:.3g} particle-steps/s; output took {100.0 * output / max(total, 1e-9):.0f} % "
        f"({amount(recorder.size)} at {amount(recorder.size / max(output, 1e-9))}/s)"
    )
    frames = recorder.frames.written
    collection = shlex.quote(str(directory.path / "particles.xdmf"))
    log.say(
        f"{frames} frame{'s' if frames > 1 else ''} and history.csv in {directory.path}; "
        f"look at them with: paraview {collection}"
    )
    left = sim.count - sim.present() if sim.scene.settings.loses else 0
    if left:
        faces = dict.fromkeys(
            face for case in sim.cases for face, way in case.escape.items() if way == "remove"
        )
        ways = [f"left through {' or '.join(faces)}"] if faces else []
        ways += ["were removed with their bodies"] if sim.case.staged.removed else []
        columns = [*["escaped"] * bool(faces), *["removed"] * bool(sim.case.staged.removed)]
        log.say(
            f"note: {left} of {sim.count} particles {' or '.join(ways)}; the columns "
            f"{' and '.join(columns)} of history.csv tell what they took along"
        )
    clamped = sim.comm.allreduce(sim.rank.clamped)
    if clamped:
        share = clamped / (sim.count * sim.step)
        _tell(
            log,
            share > _MATTERS,
            f"in {clamped} particle-steps ({100.0 * share:.2g} %) a particle was stretched to a "
            "half-width of more than one cell, and reached no farther than one",
            "neighbours along the stretch may lose contact, and the body tear where it would not: "
            "use fewer or larger cells along the stretch",
        )
    held = sim.comm.allreduce(sim.rank.held)
    if held:
        share = held / (sim.count * sim.step)
        _tell(
            log,
            share > _MATTERS,
            f"in {held} particle-steps ({100.0 * share:.2g} %) a wall held in a particle whose "
            "centre had passed it; its velocity into the wall is lost, as a force of the wall",
            "kinetic energy is lost at the wall, and what lies there is denser than it should be: "
            "smaller cells or steps, or finite-gimp, press fewer particles through",
        )
    part, when, face = sim.diagnostic_sums.most_outside
    if part > _NEGLIGIBLE:
        _tell(
            log,
            part > _MATTERS,
            f"up to {100.0 * part:.2g} % of the mass lay past {face} (t = {when:.6g}), borne by "
            "the wall",
            f"weights and pressures of the rest are too small by that part, and forces on {face}: "
            "a size that follows the deformation (finite-gimp), or wall: mirror, avoids that",
        )
