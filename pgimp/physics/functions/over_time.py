"""A coefficient of one's own over time, in place of a number that may vary in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from typing import ClassVar

import numpy as np
from pydantic import model_validator

from pgimp.errors import CaseError, RunError
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import COEFFICIENT, Kind
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.time_functions import TimeFunction

#: Fewest and most panels of the quadrature, its points and weights on (-1, 1), instants of `rows`.
_PANELS, _MOST_PANELS, _ROWS = 64, 4096, 257
#: Difference on halving the panels that has converged, as a part of the greatest value.
_CONVERGED = 1e-9
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


#: End of the run whose case is being read.
_END: ContextVar[float] = ContextVar("end", default=0.0)


@contextmanager
def until(end: object) -> Iterator[None]:
    """Read a case with this end of the run, if it is a time."""
    known = isinstance(end, int | float) and not isinstance(end, bool) and 0.0 < end < inf
    token = _END.set(float(end) if known else 0.0)  # type: ignore[arg-type]
    try:
        yield
    finally:
        _END.reset(token)


class FunctionOfTime(FunctionEntry, TimeFunction):
    """A number over time by a function of one's own, a coefficient that takes ``t``."""

    KIND: ClassVar[Kind] = COEFFICIENT
    NOT_GIVEN: ClassVar[tuple[str, ...]] = ("x",)
    ELSEWHERE: ClassVar[str] = "a number of a load or of a motion is of t alone"

    @model_validator(mode="after")
    def _check_fit(self) -> FunctionOfTime:
        raise_problems("function", list(self.misfits(1)))
        self.__dict__["end"] = _END.get()
        try:
            self.rows
        except RunError as error:
            raise_problems("function", [Problem(("function",), str(error))])
        return self

    def _values(self, times: np.ndarray) -> np.ndarray:
        from pgimp.physics.functions.call import evaluate, numbers_in_time

        if "kernel_source" not in self.__dict__:
            self.__dict__["kernel_source"] = self.source()
        values = np.empty(len(times))
        try:
            source = self.__dict__["kernel_source"]
            evaluate(self.registered, numbers_in_time, (source, times, values))
        except CaseError as error:
            when = f" at t = {times[0]:.6g}" if len(times) == 1 else ""
            raise RunError(f"{error}{when}") from None
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            raise RunError(f"{self.registered} returns {values[k]:g} at t = {times[k]:.6g}")
        return values

    @property
    def rows(self) -> Sequence[tuple[float, float]]:
        """See `TimeFunction`; the greatest value is one of many instants, not of all."""
        end = self.__dict__["end"]
        times = np.linspace(0.0, end, _ROWS if end else 1)
        return tuple(zip(times.tolist(), self._values(times).tolist(), strict=True))

    def value(self, t: float) -> float:
        """See `TimeFunction`."""
        if "last" not in self.__dict__ or self.__dict__["last"][0] != t:
            self.__dict__["last"] = t, float(self._values(np.array([float(t)]))[0])
        found: float = self.__dict__["last"][1]
        return found

    def integral(self, t: float) -> float:
        """See `TimeFunction`: by Gauss' quadrature in equal panels, as many as it takes."""
        if not 0.0 < abs(t) < inf:
            return 0.0
        panels, (found, most) = _PANELS, self._quadrature(t, _PANELS)
        while panels < _MOST_PANELS:
            finer, higher = self._quadrature(t, 2 * panels)
            most = max(most, higher)
            if abs(finer - found) <= _CONVERGED * most * abs(t):
                break
            panels, found = 2 * panels, finer
        return found

    def _quadrature(self, t: float, panels: int) -> tuple[float, float]:
        """Return the integral in equal panels, and the greatest absolute value."""
        half = 0.5 * t / panels
        middles = half * (2.0 * np.arange(panels) + 1.0)
        values = self._values((middles[:, None] + half * _POINTS).ravel())
        sums = np.cumsum((values.reshape(panels, -1) * _WEIGHTS).ravel())  # in one order
        return float(sums[-1]) * half, float(np.abs(values).max())
