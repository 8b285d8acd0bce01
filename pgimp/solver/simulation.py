"""The simulation: a scene's particles on this rank, advanced step by step with all others."""

from __future__ import annotations

from math import inf, nan
from typing import TYPE_CHECKING

from pgimp.case.schema import Case
from pgimp.errors import DamagedError, RunError
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver import setup
from pgimp.solver.callbacks.callback import Each, calls_of
from pgimp.solver.decomposition import RESORT, rebalance, resort
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.reduction import Request, StepReduction
from pgimp.solver.stages import enter
from pgimp.solver.start.creation import Creation
from pgimp.solver.start.particle_errors import Failure, collect_errors
from pgimp.solver.start.settle import (
    CALM,
    end_at_rest,
    is_at_rest,
    is_due,
    left_part,
    require_rest,
    unbalanced_part,
)
from pgimp.solver.start.start import Start
from pgimp.solver.start.validate_stages import absent, look_ahead
from pgimp.solver.state.progress import SimulationProgress
from pgimp.solver.state.state import State
from pgimp.solver.step import step
from pgimp.solver.time.clock import Step
from pgimp.solver.time.energy_watch import EnergyWatch

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile


class Simulation(SimulationProgress):
    """A case on the ranks of a communicator; creating it and advancing it are collective.

    Parameters
    ----------
    case : Case
        The case to simulate.
    comm : communicator
        mpi4py's, or `pgimp.mpi.comm.Serial`.
    source : CheckpointFile, optional
        The state to continue from; without it the case begins.
    each : Each, optional
        A function that is called after every N steps; `calls` are its calls.

    Attributes
    ----------
    cases : tuple of Case
        The cases of the stages; `stage` is the number of the current one, `case` its case.
    scene, clock : Scene, FixedClock or CourantClock
        Constant within a stage.
    columns : list of str
        Columns of the history of a run of several stages, the union of theirs; else empty.
    settling, unbalanced, left_part : bool, float, float
        Whether the run, or the stage, still comes to rest; the last `unbalanced_part` found, and
        the part of the way that was left then.
    rank, balance : Rank, Balance
        This rank's part, and the load of all.
    done, doing : Step, Step or None
        The last step that succeeded on all ranks. The step after it, if done by this rank with its
        reduction incomplete.
    request : Request
        This rank's request; it goes with the reduction of every step.
    agreed_request : Request
        The greatest request of all ranks since the last step began, equal on all;
        `Request.PENDING` without any.
    reduction : StepReduction
        The reduction of the last step, complete or not.
    failure : Failure or None
        The step that failed; `time`, `step` and `dt` then belong to the step before.

    Raises
    ------
    CaseError
        On every rank alike, for errors that show only in the particles.
    DamagedError
        On every rank alike, if the checkpoint does not hold a state of this case.
    """

    #: Creates the particles at the start.
    creation: type[Creation] = Creation
    watch: EnergyWatch | None  #: The guard of the steps that pgimp chooses.
    rate: float  #: Largest (c_p + |v_p|)/L of all ranks.
    diagnostic_sums: Diagnostics
    #: notes, warnings: Messages to the user, equal on every rank.
    notes: list[str]
    warnings: list[str]

    def __init__(
        self,
        case: Case,
        comm: Communicator,
        source: CheckpointFile | None = None,
        each: Each | None = None,
    ) -> None:
        state = None if source is None else State.of(source)
        self.cases, self.comm = case.stages, comm
        self.stage = state.stage if state else 0
        if self.stage >= len(self.cases):
            raise DamagedError(f"it is of stage {self.stage + 1}, of {len(self.cases)}")
        scenes = [Scene(each) for each in self.cases]
        self.case, self.scene = self.cases[self.stage], scenes[self.stage]
        self.columns = look_ahead(scenes) if len(scenes) > 1 else []
        self.doing: Step | None = None
        self.failure: Failure | None = None
        self.unbalanced, self.left_part = nan, 0.0
        self.calls = calls_of(each, self, state)
        self.request = self.agreed_request = Request.NONE
        self.reduction = StepReduction(comm)
        if source is None or state is None:
            start = setup.begin(scenes, comm, self.reduction, self.creation(scenes[0]))
        else:
            start = setup.resume(scenes, comm, self.reduction, source, state)
        self.take(start)
        if self.calls:
            self.calls.resume()

    def take(self, start: Start) -> None:
        """Continue from a start."""
        self.case, self.scene, self.stage = start.case, start.scene, start.stage
        self.clock, self.watch, self.done = start.clock, start.watch, start.done
        self.rank, self.balance = start.rank, start.balance
        self.rate, self.diagnostic_sums = start.rate, start.diagnostic_sums
        self.notes, self.warnings = start.notes, start.warnings
        self.settling = start.settling

    def now_as_start(self) -> Start:
        """Return the start of another stage."""
        start = Start(
            self.scene, self.comm, self.reduction, self.diagnostic_sums, self.done, self.stage,
            self.settling, self.rate, self.watch, self.notes, self.warnings,
        )  # fmt: skip
        start.clock, start.balance, start.rank = self.clock, self.balance, self.rank
        return start

    def next_stage(self) -> None:
        """Begin the next stage, when one is done; collective.

        Raises
        ------
        RunError
            On every rank, if the last step failed, or the next stage cannot begin. Also if the
            current one is not done or is the last.
        """
        self.complete_reduction()
        if self.finished:
            raise RunError(
                f"the case ends at t = {self.time:.6g}, after {self.step} steps; a longer one has "
                "another time.end, or one more of time.stages"
            )
        if not self.stage_done:
            raise RunError(
                f"t = {self.time:.6g} is not the end of {self.case.staged.title}, "
                f"which is at t = {self.case.time.end:.6g}; advance until stage_done"
            )
        self.take(enter(self.now_as_start(), self.cases[self.stage + 1]))

    def advance(self, complete: bool = True) -> None:
        """Do one step, the first of the next stage where one is done; collective.

        Parameters
        ----------
        complete : bool
            Whether to wait until all ranks have done it. Otherwise the next step, or
            `complete_reduction`, reports its failure.

        Raises
        ------
        RunError
            On every rank, if particles of any are at fault; that step then does not count, and
            there will be no other. Also past the end of the case. On a rank alone, if a function
            of one's own raises an exception there.
        """
        if self.failure:
            raise RunError(self.failure.text)
        if self.stage_done:
            self.next_stage()
        self.agreed_request = Request.PENDING
        rank, reduction, balance = self.rank, self.reduction, self.balance
        try:
            doing, rate = step(rank, self.now, self._next, self.controlled)
        except Exception as error:
            self.name_function(error)
            raise
        self.doing, number = doing, doing.number
        if self.case.rests:
            self.diagnostic_sums.settling_time += doing.dt
        if self.comm.size > 1:
            balance.note(rank.worked, rank.count, number)
        move = reduction.rebalance_requested
        request = Request.ERROR if rank.failed else self.request
        moved, bounds = rank.contact.excursion(rank), rank.vertex_bounds
        reduction.begin(rate, request, balance.rebalance_requested, bounds, moved)
        sort = number % RESORT == 0
        since = number - self.clock.before if self.settling else inf
        watch = self.watch if self.watch and self.watch.due(number) and since >= CALM else None
        look = self.settling and is_due(number, number - self.clock.before)
        call = self.calls is not None and not self.preparing and self.calls.due(number)
        if complete or move or sort or watch or look or call or self.comm.size == 1:
            self.complete_reduction()
        if watch and since == CALM:
            watch.begin(rank)
        elif watch:
            watch.look(rank, self.step, self.time, self.clock)
        if not rank.grid.covers(reduction.vertex_bounds):
            rank.grid.extend(reduction.vertex_bounds)
        if move:
            rebalance(rank, balance, number)
            reduction.rebalance_requested = False
        if sort:
            resort(rank, balance, reduction, number)
        if look:
            self._look_for_rest()
        if self.calls and call:
            self.calls.call()

    def _look_for_rest(self) -> None:
        """End the settling if the run, or the stage, has come to rest; collective."""
        settle = self.case.start.equilibrate
        self.unbalanced = unbalanced_part(self.rank)
        if self.case.rests:
            self.diagnostic_sums.note_forces(self.rank, self.now)
        self.left_part = left_part(self.rank)
        steps = self.done.number - self.clock.before
        if settle and is_at_rest(self.rank, settle, steps, self.unbalanced, self.left_part):
            self.take(end_at_rest(self.now_as_start()))
        else:
            require_rest(self.now_as_start(), self.unbalanced)

    @property
    def controlled(self) -> bool | float:
        """Whether the next step's length follows the fastest wave, and how."""
        return self.scene.settings.controlled if self.clock.controlled else False

    def _next(self) -> Step:
        """Complete the last step's reduction; its top speed sets the next dt."""
        self.complete_reduction()
        step = self.clock.next(self.done, self.clock.follow(self.fastest))
        if free := self.rank.free:
            free.require_slow(step)
            free.require_clear(self.done, step.dt)
        return step

    @property
    def fastest(self) -> float:
        """Cells that waves, particles or rigid bodies cross in a unit of time, at most."""
        return self.rank.fastest(self.rate)

    def complete_reduction(self) -> None:
        """Complete the last step's reduction, if that has not been done; collective.

        Raises `RunError` as `advance` does.
        """
        reduction = self.reduction
        if not reduction.end() or self.doing is None:
            return
        self.rank.contact.note_excursion(reduction.moved)
        known = self.agreed_request if self.agreed_request != Request.PENDING else Request.NONE
        self.rate, self.agreed_request = reduction.rate, max(known, reduction.request)
        last, self.doing = self.now, None
        if reduction.request == Request.ERROR:
            self.failure = collect_errors(self.rank, last)
            raise RunError(self.failure.text)
        self.done = last

    def diagnostics(self) -> dict[str, float] | None:
        """The columns of history.csv, in order, on rank 0; None elsewhere; collective."""
        try:
            line = self.diagnostic_sums.line(self.rank, self.now)
        except Exception as error:
            self.name_function(error)
            raise
        if line is None or not self.columns:
            return line
        return {name: line.get(name, absent(name)) for name in self.columns}
