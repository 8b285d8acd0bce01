"""Progress of a simulation: its time and steps, whether it has ended, and its particles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.decomposition.balance import Balance
from pgimp.decomposition.population import Population
from pgimp.errors import RunError
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.physics.functions.raised import raised_by
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.time.clock import CourantClock, FixedClock, Step

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.scene.scene import Scene
    from pgimp.solver.history.diagnostics import Diagnostics


class SimulationProgress:
    """What follows from the attributes of `pgimp.solver.simulation.Simulation`."""

    cases: tuple[Case, ...]
    scene: Scene
    stage: int
    comm: Communicator
    clock: FixedClock | CourantClock
    rank: Rank
    balance: Balance
    reduction: StepReduction
    diagnostic_sums: Diagnostics
    columns: list[str]
    done: Step
    doing: Step | None
    settling: bool

    @property
    def now(self) -> Step:
        """The last step done on this rank; its end is the reported time."""
        step = self.doing or self.done
        return step._replace(end=self.time)

    @property
    def time(self) -> float:
        """Simulated time, with `doing`; likewise `step` and `dt`."""
        return 0.0 if self.preparing else self.clock.time(self.doing or self.done)

    @property
    def preparing(self) -> bool:
        """Whether the run still comes to rest before time 0."""
        return self.settling and not self.stage

    @property
    def step(self) -> int:
        """Steps done."""
        return (self.doing or self.done).number

    @property
    def dt(self) -> float:
        """Length of the last step, 0 before the first."""
        return (self.doing or self.done).dt

    @property
    def finished(self) -> bool:
        """Whether the end of the last stage is reached."""
        return self.stage == len(self.cases) - 1 and self.stage_done

    @property
    def stage_done(self) -> bool:
        """Whether the end of the stage is reached."""
        return not self.settling and self.clock.finished(self.doing or self.done)

    @property
    def agreed(self) -> bool:
        """Whether the last step's reduction is complete."""
        return not self.reduction.open

    def name_function(self, error: BaseException) -> None:
        """Raise an exception of a function of one's own anew, with its name and the time.

        Raises
        ------
        RunError
            If the exception is of such a function.
        """
        if text := raised_by(error):
            rank = f", on rank {self.comm.rank}" if self.comm.size > 1 else ""
            when = f"after step {self.step}, at t = {self.time:.6g}"
            raise RunError(f"{text}; {when}{rank}") from error

    @property
    def population(self) -> Population:
        """The particles of this rank, and their order."""
        return self.rank.population

    @property
    def particles(self) -> Particles:
        """The particles of this rank, with holes; see `live`."""
        return self.rank.population.up_to_date()

    @property
    def count(self) -> int:
        """Particles that all ranks have had so far; one more than the greatest id."""
        return self.rank.numbered

    @property
    def known_count(self) -> int:
        """Particles of all ranks; with several ranks as of the last re-sort."""
        return self.balance.total if self.comm.size > 1 else self.rank.count

    def present(self) -> int:
        """Current number of particles on all ranks; collective."""
        return int(self.comm.allreduce(self.rank.count))

    def live(self) -> np.ndarray:
        """Rows of this rank's particles in canonical order, (n,) int64."""
        return self.rank.live()
