"""A function of a program that is called after every N steps."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import DamagedError, RunError, UsageError, raised_at
from pgimp.solver.callbacks.exchange import Exchange
from pgimp.solver.callbacks.levels import levels_of
from pgimp.solver.callbacks.memory import decoded, encoded
from pgimp.solver.callbacks.now import Now

if TYPE_CHECKING:
    from pgimp.solver.state.progress import SimulationProgress
    from pgimp.solver.state.state import State

#: Names of `Diagnostics.read` in a checkpoint.
_READING = ("time", "impulse", "force")


class Each:
    """A function that is called after every N steps, by all ranks.

    Parameters
    ----------
    function : callable
        Is called with a `Now`: time, particles, vertices, sums over all ranks, loads to set, and
        a state. What it returns is ignored.
    steps : int
        N; it is called after steps whose number is a multiple of this.
    state : mapping
        What ``now.state`` has at the start: numbers, texts, arrays by name. Checkpoints hold it.
    """

    def __init__(
        self,
        function: Callable[[Now], object],
        steps: int = 1,
        state: Mapping[str, Any] | None = None,
    ) -> None:
        if not callable(function):
            raise UsageError(f"each: expected a function, got {function!r}")
        if isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 1:
            raise UsageError(f"each: expected a number of steps from 1 on, got {steps!r}")
        if not isinstance(state, Mapping | None):
            raise UsageError(f"each: expected a state, values by name, got {state!r}")
        self.function, self.steps, self.state = function, int(steps), dict(state or {})
        self.name = getattr(function, "__qualname__", type(function).__name__)
        try:
            encoded(self.state, f"each: {self.name}")
        except RunError as error:
            raise UsageError(str(error)) from None


def each_of(given: Each | Callable[[Now], object] | None) -> Each | None:
    """Return the argument ``each=`` of a simulation or a run."""
    return given if given is None or isinstance(given, Each) else Each(given)


class Calls:
    """The calls of a function in a simulation.

    Parameters
    ----------
    each : Each
        The function.
    core
        Simulation.
    stored : dict or None
        What a checkpoint has, see `stored`.
    """

    def __init__(
        self, each: Each, core: SimulationProgress, stored: Mapping[str, Any] | None
    ) -> None:
        self._each, self._core = each, core
        self._levels = levels_of(core.cases)
        self._state = decoded(encoded(each.state, "each"))
        self._read: dict[str, Any] = {}
        if stored is not None:
            self._state = decoded(stored.get("state", {}))
            self._read = decoded(stored.get("reading", {}))
            for name, numbers in stored.get("loads", {}).items():
                self._restore(name, numbers)

    def _restore(self, name: str, numbers: Any) -> None:
        if name in self._levels:
            level = self._levels[name]
            try:
                level.value, level.since, level.passed = (float.fromhex(n) for n in numbers)
            except (TypeError, ValueError):
                raise DamagedError(f"its load '{name}' is not what it must be") from None

    def resume(self) -> None:
        """Give the simulation the last reading of the history, where it goes on.

        Raises
        ------
        DamagedError
            If that is not of its stage.
        """
        if not self._read:
            return
        found: Any = tuple(self._read.get(name) for name in _READING)
        rows = (self._core.diagnostic_sums.rows(self._core.rank), 3)
        shapes = [np.shape(part) for part in found]
        if shapes != [(), rows, rows] or not all(np.isfinite(part).all() for part in found):
            raise DamagedError("its reading of the history is not of its stage")
        self._core.diagnostic_sums.read = found

    def due(self, step: int) -> bool:
        """Whether the function is called after a step."""
        return step % self._each.steps == 0

    def call(self) -> None:
        """Call the function after a complete step; collective.

        Raises
        ------
        RunError
            On every rank, if it fails on any, or leaves other states on some.
        """
        where = f"each: {self._each.name} after step {self._core.step}"
        exchange = Exchange(self._core.comm, where)
        try:
            self._each.function(Now(self._core, exchange, self._levels, self._state))
            stored = self.stored(where)
            digest = sha256(json.dumps(stored).encode()).hexdigest()
        except (Exception, SystemExit) as error:
            raise exchange.fail(_described(error)) from error
        every = exchange.gather("its end", digest)
        if len({*every}) > 1:
            rank = next(rank for rank, other in enumerate(every) if other != every[0])
            raise RunError(
                f"{where}: its state, or a load that it set, is another one on rank {rank} than "
                "on rank 0; take both from now.sum, now.max and now.min, which are of all ranks"
            )
        self._state = decoded(stored["state"])  # of the types that a resumed run has

    def stored(self, where: str = "each") -> dict[str, Any]:
        """Return state and loads as a checkpoint holds them."""
        loads = {
            name: [number.hex() for number in (level.value, level.since, level.passed)]
            for name, level in self._levels.items()
        }
        found = {"state": encoded(self._state, where), "loads": loads}
        if read := self._core.diagnostic_sums.read:
            found["reading"] = encoded(dict(zip(_READING, read, strict=True)), where)
        return found


def calls_of(each: Each | None, core: SimulationProgress, state: State | None) -> Calls | None:
    """Return the calls in a simulation, which may go on from the state of a checkpoint.

    Raises
    ------
    UsageError
        If the run has been with a function, and goes on without.
    """
    if each is not None:
        return Calls(each, core, state.each if state else None)
    if state is not None and state.each is not None:
        raise UsageError(
            "the run was with a function after its steps (each=), whose state is in the "
            "checkpoint: give it again, pgimp.run(case, each=.., resume=True)"
        )
    return None


def _described(error: BaseException) -> str:
    """Describe an exception, with file and line."""
    at = raised_at(error)
    place = f" ({at.filename}:{at.lineno})" if at else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{place}"
