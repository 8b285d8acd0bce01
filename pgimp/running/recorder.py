"""Output during a run: frames, history and checkpoints when due."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from time import perf_counter
from typing import TYPE_CHECKING

from pgimp.errors import RunError
from pgimp.io.frames.series import Series
from pgimp.io.results.history import History
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.collective import on_root
from pgimp.running.checkpoints import About, Checkpoints
from pgimp.running.frames import Frames
from pgimp.running.meshes.gridframes import GridFrames
from pgimp.running.meshes.rigidframes import RigidFrames
from pgimp.running.meshes.surfaceframes import SurfaceFrames
from pgimp.running.probes import Probes
from pgimp.running.schedule import Schedule
from pgimp.solver.reduction import Request
from pgimp.solver.start.validate_stages import absent

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation


class Recorder:
    """Output of a run.

    Parameters
    ----------
    directory : RunDirectory
        Prepared for the run.
    case : Case
        The whole case, with all its stages; the present one gives the times of output.
    sim : Simulation
        The run, at its beginning or as resumed.

    Attributes
    ----------
    grid
        GridFrames.
    rigid
        RigidFrames.
    surface
        SurfaceFrames.
    seconds : dict of str to float
        Time of this rank for each; the grid's frames count as frames, probes as history.
    """

    def __init__(self, directory: RunDirectory, case: Case, sim: Simulation) -> None:
        self._sim = sim
        self._directory = directory
        whole, case = case, sim.case
        self.frames = Frames(directory.path, case, sim)
        self.grid = GridFrames(directory.path, case, sim)
        self.rigid = RigidFrames(directory.path, case, sim)
        self.surface = SurfaceFrames(directory.path, case, sim)
        self.history = History(directory.path / "history.csv")
        self.probes = Probes(directory.path, case, sim)
        self.checkpoints = Checkpoints(directory.path, whole, sim)
        self._frame_times = Schedule(case.output.every, case.output.at)
        self._line_times = Schedule(case.history.every)
        self.seconds = {"frames": 0.0, "history": 0.0, "checkpoints": 0.0}

    @property
    def _series(self) -> tuple[Series, ...]:
        return self.frames, self.grid, self.rigid, self.surface

    def begin(self) -> None:
        """Write the initial state; collective.

        Raises
        ------
        RunError
            On every rank, if that is not possible; later methods raise it likewise.
        """
        with self._timed("history"):
            self.probes.begin()
        self._record(frame=True, line=True)

    def resume(self, about: About) -> list[str]:
        """Continue the output from its state at a checkpoint; collective.

        Parameters
        ----------
        about : About
            Header of the checkpoint.

        Returns
        -------
        list of str
            Messages on missing parts of the earlier output.
        """
        sim = self._sim
        self.checkpoints.resume(sim.comm, sim.step, about)
        notes = [note for series in self._series for note in series.resume(about.frames)]
        self.history.resume(sim.comm, about.history)
        if sim.columns:
            on_root(sim.comm, lambda: self.history.widen(sim.columns, absent))
        if self.history.step != about.history:
            notes.append(
                f"{self.history.path} ends at step {self.history.step}, but it had a line of step "
                f"{about.history}: lines are missing"
            )
        notes += self.probes.resume(about.probes)
        for schedule in (self._frame_times, self._line_times):
            schedule.skip(sim.time, sim.step, sim.dt)
        return notes

    def enter(self) -> None:
        """Continue in the stage that the run has entered; collective."""
        sim, case = self._sim, self._sim.case
        with self._timed("frames"):
            for series in self._series:
                series.finish()
        for series in self._series:
            series.enter(case, sim)
        self.probes.enter(case)
        self._frame_times = Schedule(case.output.every, case.output.at)
        self._line_times = Schedule(case.history.every)
        for schedule in (self._frame_times, self._line_times):
            schedule.skip(sim.time, sim.step, sim.dt)

    def step(self) -> None:
        """Write due or requested output after a step; collective.

        Nothing is written before all ranks have agreed that the step was successful.

        Raises
        ------
        RunError
            On every rank, if it was not.
        """
        sim = self._sim
        waiting = any(series.waiting for series in self._series)
        finish = waiting and sim.agreed_request == Request.NONE
        frame = self._frame_times.due(sim.time, sim.step, sim.dt)
        line = self._line_times.due(sim.time, sim.step, sim.dt)
        probes = self.probes.due()
        checkpoint = self.checkpoints.due(sim) or sim.agreed_request == Request.CHECKPOINT
        if not (finish or frame or line or probes or checkpoint):
            return
        sim.complete_reduction()
        if finish:
            with self._timed("frames"), self._salvaging():
                for series in self._series:
                    series.finish()
        if probes:
            self._look(probes)
        if frame or line:
            self._record(frame, line)
        # The checkpoint of a stage's end comes after the frame of the end.
        if (checkpoint or sim.agreed_request == Request.CHECKPOINT) and not sim.stage_done:
            self.checkpoint()

    def settle(self) -> None:
        """Write a due or requested checkpoint after a step before time 0; collective."""
        sim = self._sim
        if self.checkpoints.due(sim) or sim.agreed_request == Request.CHECKPOINT:
            sim.complete_reduction()
            self.checkpoint()

    def end(self) -> None:
        """Write the state at the end of a stage, unless already written; collective."""
        self.show()
        self.checkpoint()

    def show(self) -> None:
        """Write a frame, unless this step has one, and lines; collective."""
        self._look(None)
        self._record(frame=self.frames.step != self._sim.step, line=True)

    def checkpoint(self) -> None:
        """Write a checkpoint, unless this step has one; collective."""
        # It refers to the frames and lines before it, and must not survive them.
        with self._timed("frames"):
            for series in self._series:
                series.sync(last=self._sim.finished)
        with self._timed("checkpoints"):
            on_root(self._sim.comm, self._sync)
            safe = self.frames.written, self.history.step, self.probes.records()
            if self.checkpoints.write(self._sim, *safe, self.history.count):
                self._directory.note(checkpoint=self._sim.step)

    def _sync(self) -> None:
        self.history.sync()
        self.probes.sync()

    def salvage(self) -> None:
        """Finish the last frame of a run that has failed on all ranks; collective."""
        for series in self._series:
            with suppress(RunError):
                series.finish()

    def _look(self, probes: list[str] | None) -> None:
        with self._timed("history"), self._salvaging():
            self.probes.write(probes)

    def _record(self, frame: bool, line: bool) -> None:
        if line:
            with self._timed("history"), self._salvaging():
                self.history.write(self._sim)
        if frame:
            with self._timed("frames"), self._salvaging():
                self.frames.finish()
                for series in self._series:
                    series.write(self._sim, self.frames.written)

    @contextmanager
    def _salvaging(self) -> Iterator[None]:
        try:
            yield
        except RunError:
            self.salvage()
            raise

    @contextmanager
    def _timed(self, what: str) -> Iterator[None]:
        began = perf_counter()
        yield
        self.seconds[what] += perf_counter() - began

    def kept(self) -> str:
        """Describe the content of the run directory so far in a sentence."""
        folder = self.checkpoints.folder.parent
        frames = self.frames.written
        if not frames:
            return f"{folder} holds no frame"
        number = "1 frame" if frames == 1 else f"{frames} frames"
        text = f"{folder} holds {number}, to t = {self.frames.latest:.6g}, and history.csv"
        if self.checkpoints.latest < 0:
            return f"{text}, but no checkpoint"
        return f"{text}; the checkpoint of step {self.checkpoints.latest} is intact: --resume"

    @property
    def size(self) -> int:
        """Bytes of the frames and checkpoints written by this process, on rank 0."""
        return sum(series.size for series in self._series) + self.checkpoints.size

    @property
    def ready(self) -> bool:
        """Whether this rank can finish the last frames without waiting for the disk."""
        return all(series.ready for series in self._series)

    def close(self) -> None:
        """Close the history and the probes' files, and list all frames."""
        for series in self._series:
            series.close()
        self.history.close()
        self.probes.close()
