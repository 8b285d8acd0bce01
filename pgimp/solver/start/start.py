"""Start of a run, or of a stage: its state at the first step."""

from __future__ import annotations

from dataclasses import dataclass, field

from pgimp.case.schema import Case
from pgimp.decomposition.balance import Balance
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.time.clock import START, CourantClock, FixedClock, Step
from pgimp.solver.time.energy_watch import EnergyWatch


@dataclass
class Start:
    """The state that a simulation takes over; for its attributes see `Simulation`.

    Set-up fills it in order: `clock`, `watch`, `balance`, then `rank`
    and `rate`.
    """

    scene: Scene
    comm: Communicator
    reduction: StepReduction
    diagnostic_sums: Diagnostics = field(default_factory=Diagnostics)
    done: Step = START
    stage: int = 0
    settling: bool = False
    rate: float = 0.0
    watch: EnergyWatch | None = None
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    clock: FixedClock | CourantClock = field(init=False)
    balance: Balance = field(init=False)
    rank: Rank = field(init=False)

    @property
    def case(self) -> Case:
        """The case of the stage."""
        return self.scene.case
