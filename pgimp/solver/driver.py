"""A simulation driven from Python, without a run directory: ``pgimp.Simulation``."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isclose

import numpy as np

from pgimp.case.load import Source, load
from pgimp.case.schema import Case
from pgimp.case.writer import dump_case
from pgimp.mpi.comm import world
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.peers import created, together
from pgimp.mpi.together import end_all_on_exceptions, require_same
from pgimp.schema.overrides import Overrides
from pgimp.solver import simulation
from pgimp.solver.callbacks.callback import Each, each_of
from pgimp.solver.callbacks.levels import own_levels
from pgimp.solver.callbacks.now import Now
from pgimp.solver.callbacks.particles import Particles

#: Relative difference, to the later one, below which times are equal.
_SAME = 1e-12


class Simulation:
    """A case, advanced step by step; all ranks create it and advance it together.

    Nothing is written; `pgimp.run` does these steps and writes a run directory.

    Parameters
    ----------
    case : Case, str, Path or mapping
        A case, the name of its file, or the file's content as a dictionary.
    comm : communicator, optional
        Of all ranks; by default all ranks of the launcher.
    overrides : mapping, or sequence of str
        Changes to the case, as for `pgimp.load`.
    each : callable or Each, optional
        A function that is called after every step, or after every N, see `pgimp.Each`.

    Attributes
    ----------
    case : Case
        The simulated case.
    particles : Particles
        The current particles of this rank: ``sim.particles["stress"]``.
    core : pgimp.solver.simulation.Simulation
        The solver itself, whose interface may change.

    Raises
    ------
    CaseError, UsageError
        If the case is wrong.
    """

    def __init__(
        self,
        case: Source,
        comm: Communicator | None = None,
        overrides: Overrides = (),
        each: Each | Callable[[Now], object] | None = None,
    ) -> None:
        comm = world() if comm is None else comm
        end_all_on_exceptions(comm)
        self.case: Case = own_levels(load(case, overrides))
        require_same(comm, "pgimp.Simulation", dump_case(self.case))
        self._name = f"simulation {created(comm)}"
        with together(comm, self._name):
            self.core = simulation.Simulation(self.case, comm, each=each_of(each))
            while self.core.preparing:
                self.core.advance()
            self.core.diagnostics()  # what later ones refer to: energy at the start
        self.particles = Particles(self.core)

    def __repr__(self) -> str:
        """Return a summary of the progress."""
        return f"<Simulation: t = {self.time:.6g} of {self.case.time.last:.6g}, step {self.steps}>"

    @property
    def time(self) -> float:
        """Simulated time."""
        return self.core.time

    @property
    def dt(self) -> float:
        """Length of the last step; 0 before the first."""
        return self.core.dt

    @property
    def steps(self) -> int:
        """Steps done."""
        return self.core.step

    @property
    def finished(self) -> bool:
        """Whether the end of the case, and of its last stage, is reached."""
        return self.core.finished

    @property
    def stage(self) -> int:
        """Number of the stage, from 0 on; it begins with its first step."""
        return self.core.stage

    def step(self, count: int = 1) -> None:
        """Do a step, or several; collective.

        The step after the last one of a stage is the first of the next.

        Parameters
        ----------
        count : int
            Number of steps.

        Raises
        ------
        ValueError
            If `count` is no whole number from 0 on.
        RunError
            On every rank: if particles of any are at fault, or past the end of the case.
        UsageError
            On every rank, if one does other steps than the others.
        """
        if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 0:
            raise ValueError(f"step: expected a number of steps from 0 on, got {count!r}")
        with together(self.core.comm, f"step({count}) of {self._name}"):
            for _ in range(count):
                self.core.advance()

    def advance(self, to: float = inf) -> None:
        """Do steps until a time is reached or, first, the end of the case; collective.

        The steps are the steps of a run, so the time afterwards may be up to a step later.

        Parameters
        ----------
        to : float
            The simulated time; the end of the case by default.

        Raises
        ------
        ValueError
            If `to` is no time.
        RunError
            On every rank, if particles of any are at fault.
        UsageError
            On every rank, if one advances to another time, or does something else.
        """
        if isinstance(to, bool) or not isinstance(to, float | int | np.number) or not to >= 0.0:
            raise ValueError(f"advance: expected a simulated time from 0 on, got {to!r}")
        core = self.core
        with together(core.comm, f"advance({float(to)}) of {self._name}"):
            while not core.finished and self._before(to):
                core.advance(complete=False)
            core.complete_reduction()

    def _before(self, to: float) -> bool:
        return self.time < to and not isclose(self.time, to, rel_tol=_SAME)

    def diagnostics(self) -> dict[str, float] | None:
        """Return the current line of history.csv; None except on rank 0; collective."""
        with together(self.core.comm, f"diagnostics() of {self._name}"):
            return self.core.diagnostics()
