"""Running a simulation with all its output, to its end or a requested stop."""

from __future__ import annotations

from time import perf_counter

from pgimp.case.schema import Case
from pgimp.errors import EndlessError, NoRestError, RunError
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import describe
from pgimp.running import failure
from pgimp.running.checkpoints import About
from pgimp.running.log import Log, timing_table
from pgimp.running.progress import Progress, terminal_columns
from pgimp.running.recorder import Recorder
from pgimp.running.stop import Stop
from pgimp.running.summary import accuracy, figures, say_done
from pgimp.solver.reduction import Request
from pgimp.solver.simulation import Simulation
from pgimp.solver.time.held_rate import WORTH


def advance(
    case: Case, sim: Simulation, about: About | None, directory: RunDirectory, log: Log, stop: Stop
) -> bool:
    """Do all steps, with frames, history lines and checkpoints when they are due; collective.

    Parameters
    ----------
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
        stopped, stages = False, _begun(sim, directory)
        if sim.preparing:
            if about:
                recorder.checkpoints.resume(sim.comm, sim.step, about)
            recorder.probes.choose(about.probes if about else {})
            stopped = _settle(sim, recorder, progress, log, stop)
            about = None
        if not sim.preparing:
            _begin(recorder, about, log)
        # Signals before the first step, also during set-up, were deferred until here.
        stopped = stopped or stop.agree(recorder.checkpoints.seconds if about is None else 0.0)
        while not (stopped or sim.finished):
            if sim.stage_done:
                _next_stage(sim, recorder, log)
                stages.append(sim.step)
                directory.note(stages=stages)
            each = (perf_counter() - began) / (sim.step - first + 1)
            sim.request = _request(sim, recorder, stop, each)
            settling = sim.settling
            sim.advance(complete=False)
            if settling and not sim.settling:
                _say_settled(sim, sim.step - sim.clock.before, log)
            recorder.step()
            progress.step()
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
        if isinstance(error, NoRestError):  # what moves is seen
            recorder.begin() if sim.preparing else recorder.show()
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
        say_done(sim, first, recorder, directory, log, total)
        if log.speaks and (text := accuracy(directory.path, case)):
            log.say(f"accuracy: {text}")
    else:
        log.say(
            f"stopped {stop} at step {sim.step}, t = {sim.time:.6g}, with a checkpoint; the same "
            f"command with --resume{' in place of --overwrite' * directory.overwrite} goes on"
        )
    seconds = recorder.seconds
    timings = sim.comm.gather(dict(sim.rank.timings) | seconds)
    log.note(f"\n{timing_table(timings, total)}")
    if text := sim.balance.summary():
        log.note(text)
    directory.finish(
        "done" if ended else "stopped",
        sim.step,
        sim.time,
        total - sum(seconds.values()),
        None if ended else f"stopped {stop}",
        figures(sim, timings, total) | {"warnings": log.warnings},
    )
    return ended


def _begun(sim: Simulation, directory: RunDirectory) -> list[int | None]:
    """Steps after which the stages after the first began, also those before a resume; collective.

    None for a stage of which the run directory does not tell.
    """
    before = directory.before or {}
    known = before.get("stages")
    stages = [*(known if isinstance(known, list) else []), *[None] * sim.stage][: sim.stage]
    if stages:
        directory.note(stages=stages)
    return stages


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
        _warn(sim, log)
        stopped = sim.agreed_request == Request.STOP
    if not sim.preparing:
        _say_settled(sim, sim.step, log, "; time 0 begins")
    return stopped


def _say_settled(sim: Simulation, steps: int, log: Log, what: str = "") -> None:
    left = sim.left_part
    if left > 0.01:  # forces alone have decided
        what = f", while about {left:.1g} of the way may be left{what}"
    log.say(
        f"settled in {steps} steps: the unbalanced force is {sim.unbalanced:.3g} of the "
        f"loads and what bears them{what}"
    )


def _warn(sim: Simulation, log: Log) -> None:
    """Show warnings that follow from the energy, and from the history's sums."""
    while sim.watch and sim.watch.said:
        log.say(f"warning: {sim.watch.said.pop(0)}")
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
