"""A parameter that is a function of one's own of the place."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import COEFFICIENT, Kind
from pgimp.physics.variation.base import NoValueError, Places, Reals, Variation
from pgimp.schema.problems import Problem


class OwnVariation(FunctionEntry, Variation):
    """A coefficient of one's own that takes ``x``, a particle's initial position."""

    KIND: ClassVar[Kind] = COEFFICIENT
    NOT_GIVEN: ClassVar[tuple[str, ...]] = ("t",)
    ELSEWHERE: ClassVar[str] = "a parameter of a material is of x alone"

    def learn(self, mean: float) -> None:
        """Set a typical value."""
        self.__dict__["mean"] = mean

    def _typical(self) -> float | None:
        return self.__dict__.get("mean")

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        from pgimp.physics.functions.call import evaluate, numbers_at

        values, x = np.empty(len(places.x)), np.ascontiguousarray(places.x)
        evaluate(self.registered, numbers_at, (self.source(), (0.0,) * x.shape[1], x, values))
        if not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values)))
            raise NoValueError(row, f"has no value: {self.registered} returns {values[row]:g}")
        return values

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        yield from self.misfits(dimensions)
