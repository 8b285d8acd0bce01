"""What a function of a program gets after a step: the state of the run, and loads to set."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from pgimp.physics.loads.controlled import Level
from pgimp.schema.messages import unknown
from pgimp.solver.callbacks.exact_sum import parts_of, rounded
from pgimp.solver.callbacks.exchange import Exchange
from pgimp.solver.callbacks.particles import Particles
from pgimp.solver.callbacks.readings import History

if TYPE_CHECKING:
    from pgimp.solver.state.progress import SimulationProgress

Numbers = float | np.ndarray


class Loads(MutableMapping[str, float]):
    """The controlled loads of the case by name; a value that is set holds from the next step on."""

    def __init__(self, levels: dict[str, Level], time: float) -> None:
        self._levels, self._time = levels, time

    def _level(self, name: str) -> Level:
        if name not in self._levels:
            raise KeyError(unknown("controlled load", str(name), self._levels))
        return self._levels[name]

    def __getitem__(self, name: str) -> float:
        """Return the present value."""
        return self._level(name).value

    def __setitem__(self, name: str, value: float) -> None:
        """Set the value."""
        number = float(value)
        if not np.isfinite(number):
            raise ValueError(f"the load '{name}' was set to {number}")
        self._level(name).set(number, self._time)

    def __delitem__(self, name: str) -> None:
        """Refuse."""
        raise TypeError("controlled loads stay; set one to 0.0")

    def __iter__(self) -> Iterator[str]:
        """Go through the names."""
        return iter(self._levels)

    def __len__(self) -> int:
        """Return their number."""
        return len(self._levels)


class Now:
    """The run after a step, as a function of a program gets it.

    Attributes
    ----------
    time, dt : float
        Simulated time, and length of the last step.
    step, stage : int
        Steps done, and number of the stage.
    rank, ranks : int
        Number of this rank, and of all.
    particles : Particles
        The particles of this rank, by the names of a frame's fields.
    history : History
        The columns of the history, as after the step.
    loads : Loads
        The controlled loads, which may be set.
    state
        The function's own, which checkpoints hold; equal on all ranks.
    """

    def __init__(
        self,
        core: SimulationProgress,
        exchange: Exchange,
        levels: dict[str, Level],
        state: dict[str, Any],
    ) -> None:
        self.time, self.dt = core.time, core.dt
        self.step, self.stage = core.step, core.stage
        self.rank, self.ranks = core.comm.rank, core.comm.size
        self.particles, self.loads, self.state = Particles(core), Loads(levels, core.time), state
        self.history = History(core, exchange)
        self._core, self._exchange = core, exchange
        self._made = True

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse to replace what the run would not see."""
        if hasattr(self, "_made"):
            raise AttributeError(
                f"now.{name} cannot be replaced; set what is in it: now.state['sum'] = .., "
                "now.loads['push'] = .."
            )
        super().__setattr__(name, value)

    def sum(self, values: ArrayLike) -> Numbers:
        """Return the sum over all ranks of numbers, (n,), or of each column, (n, k); collective.

        It is rounded once, so that its bits depend neither on ranks nor on the order.
        """
        columns = self._columns(values)
        every = self._exchange.gather("a sum", [parts_of(column) for column in columns.T])
        found = [rounded(each) for each in zip(*every, strict=True)]
        return found[0] if np.ndim(values) < 2 else np.array(found)

    def max(self, values: ArrayLike) -> Numbers:
        """Return the greatest number of all ranks, or of each column; collective."""
        columns = self._columns(values)
        every = self._exchange.gather("a maximum", columns.max(axis=0, initial=-np.inf))
        found = np.max(every, axis=0)
        return float(found[0]) if np.ndim(values) < 2 else np.asarray(found)

    def min(self, values: ArrayLike) -> Numbers:
        """Return the least number of all ranks, or of each column; collective."""
        return -self.max(-np.asarray(values, float))

    def vertices(self) -> dict[str, np.ndarray]:
        """Return position, mass, velocity and force of this rank's vertices; collective.

        They are those of the next step, with the particles as they are: each vertex with mass on
        one rank. The force includes gravity.
        """
        from pgimp.solver.state.grid_state import active_grid

        self._exchange.gather("vertices()", None)
        found = active_grid(self._core.rank, self.time)
        rows = found.mass > 0.0
        mass = found.mass[rows]
        return {
            "position": found.position[rows],
            "mass": mass,
            "velocity": found.momentum[rows] / mass[:, None],
            "force": found.force[rows],
        }

    def _columns(self, values: ArrayLike) -> np.ndarray:
        found = np.atleast_1d(np.asarray(values, float))
        if not np.isfinite(found).all():
            raise ValueError("a sum or a maximum is of finite numbers")
        if found.ndim > 2:
            raise ValueError(
                f"expected numbers or a table, got an array of {found.ndim} dimensions"
            )
        return found[:, None] if found.ndim == 1 else found
