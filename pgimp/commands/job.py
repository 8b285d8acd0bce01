"""A run that is to be made: where, on which ranks, and what it says and obeys."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

from pgimp.io.rundir.rundir import RunDirectory
from pgimp.io.rundir.runinfo import describe_start, installed
from pgimp.mpi.communicator import Communicator
from pgimp.running.how import How, has_companions
from pgimp.running.log import Log
from pgimp.running.progress import duration
from pgimp.running.stop import Stop

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.callbacks.callback import Each
    from pgimp.solver.simulation import Simulation


class Job(NamedTuple):
    """A run that is to be made in a directory, by all ranks."""

    comm: Communicator
    output: Path
    log: Log
    stop: Stop
    how: How
    text: bytes | None = None  #: The file of the case.
    each: Each | None = None

    def run(self, case: Case) -> bool:
        """Run a case; return whether it reached its end; collective."""
        ended, again = self._run_once(case)
        if not again:
            return ended
        how = self.how._replace(overwrite=False, resume=True)
        return self._replace(how=how, log=Log(self.log.speaks, self.log.quiet)).run(case)

    def companion(self, case: Case, path: Path) -> bool:
        """Run a companion in its own directory, or what is left of it; see `run`."""
        quiet = Log(self.comm.rank == 0, True)
        return Job(self.comm, path, quiet, self.stop, How(resume=True)).run(case)

    def _run_once(self, case: Case) -> tuple[bool, bool]:
        """Run a case; return whether it ended, and whether it is to run on smaller cells."""
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

        comm, output, log, stop, how, text, each = self
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

                    chosen = accompany.begin(case, directory, how, log, stop, self.companion)
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
