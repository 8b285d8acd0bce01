"""An initial velocity of one's own: the entry in the case."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import VELOCITY, Kind


class OwnVelocity(FunctionEntry):
    """Initial velocity by a function of one's own."""

    KIND: ClassVar[Kind] = VELOCITY
    NOT_GIVEN: ClassVar[tuple[str, ...]] = ("t",)
    ELSEWHERE: ClassVar[str] = "an initial velocity is of x alone, that of a constraint of both"

    def at(self, x: np.ndarray) -> np.ndarray:
        """Return the velocities at positions, both (n, D)."""
        from pgimp.physics.functions.call import evaluate, vectors_at

        v = np.empty_like(x)
        origin, x = (0.0,) * x.shape[1], np.ascontiguousarray(x)
        evaluate(self.registered, vectors_at, (self.source(), origin, x, v))
        return v
