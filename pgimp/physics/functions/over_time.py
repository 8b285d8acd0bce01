"""A coefficient of one's own over time, in place of a number that may vary in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from typing import ClassVar

import numpy as np
from pydantic import model_validator

from pgimp.errors import RunError
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import COEFFICIENT, Kind
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.time_functions import TimeFunction

#: Panels of the quadrature, its points and weights on (-1, 1), and instants of `rows`.
_PANELS, _ROWS = 64, 257
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
        from pgimp.physics.functions.call import numbers_in_time

        if "kernel_source" not in self.__dict__:
            self.__dict__["kernel_source"] = self.source()
        values = np.empty(len(times))
        numbers_in_time(self.__dict__["kernel_source"], times, values)
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
        """See `TimeFunction`: by Gauss' quadrature, in equal panels."""
        if not 0.0 < abs(t) < inf:
            return 0.0
        half = 0.5 * t / _PANELS
        middles = half * (2.0 * np.arange(_PANELS) + 1.0)
        times = (middles[:, None] + half * _POINTS).ravel()
        sums = self._values(times).reshape(_PANELS, -1) * _WEIGHTS
        total = 0.0
        for each in sums.ravel().tolist():  # in one order
            total += each
        return total * half
