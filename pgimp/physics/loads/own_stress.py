"""An initial stress of one's own: the entry in the case."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import STRESS, Kind
from pgimp.schema.base import Name


class OwnStress(FunctionEntry):
    """Initial stress by a function of one's own."""

    KIND: ClassVar[Kind] = STRESS

    bodies: tuple[Name, ...] | None = Field(
        default=None, description="the bodies that begin with it; null: all"
    )

    def begins(self, body: str) -> bool:
        """Whether a body begins with the stress."""
        return self.bodies is None or body in self.bodies

    def at(self, x: np.ndarray, components: int) -> np.ndarray:
        """Return the stresses at positions (n, D), (n, components)."""
        from pgimp.physics.functions.call import evaluate, vectors_at

        sigma = np.empty((len(x), components))
        origin, x = (0.0,) * x.shape[1], np.ascontiguousarray(x)
        evaluate(self.registered, vectors_at, (self.source(), origin, x, sigma))
        return sigma
