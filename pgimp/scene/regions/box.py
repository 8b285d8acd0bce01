"""Box along the axes."""

from __future__ import annotations

import numpy as np
from pydantic import Field, model_validator

from pgimp.case.base import Model, Vector
from pgimp.case.problems import Problem, raise_problems
from pgimp.scene.regions.base import Bounds, Mask, Points, Region


class Box(Model, Region):
    """Box along the axes, half-open: min <= x < max, so that touching boxes share no point."""

    min: Vector = Field(description="low corner [length]")
    max: Vector = Field(description="high corner [length], above min in every direction")

    @model_validator(mode="after")
    def _check_corners(self) -> Box:
        if len(self.min) != len(self.max):
            text = f"expected {len(self.min)} entries as in min, got {len(self.max)}"
            raise_problems("box", [Problem(("max",), text)])
        raise_problems(
            "box",
            [
                Problem(("max", i), f"must be above min, {low:.15g}, got {high:.15g}")
                for i, (low, high) in enumerate(zip(self.min, self.max, strict=True))
                if not low < high
            ],
        )
        return self

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = np.ones(len(points), dtype=bool)
        for i, (low, high) in enumerate(zip(self.min, self.max, strict=True)):
            inside &= (low <= points[:, i]) & (points[:, i] < high)
        return inside

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        return self.min, self.max
