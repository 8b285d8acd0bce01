"""Box along the axes."""

from __future__ import annotations

import numpy as np
from pydantic import Field, model_validator

from pgimp.geometry.regions.base import Bounds, Flat, Lengths, Mask, Plane, Points, Region, across
from pgimp.schema.base import Model, Vector
from pgimp.schema.problems import Problem, raise_problems


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

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        distance = np.full(len(points), -np.inf)
        for i, (low, high) in enumerate(zip(self.min, self.max, strict=True)):
            np.maximum(distance, low - points[:, i], out=distance)
            np.maximum(distance, points[:, i] - high, out=distance)
        return distance

    def signed_distance(self, points: Points) -> Lengths:
        """See `Region.signed_distance`."""
        square, inside = np.zeros(len(points)), self.distance(points)
        for i, (low, high) in enumerate(zip(self.min, self.max, strict=True)):
            square += np.maximum(0.0, np.maximum(low - points[:, i], points[:, i] - high)) ** 2
        return np.where(inside > 0.0, np.sqrt(square), inside)

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`; there are none."""
        return np.full(len(points), np.inf)

    def planes(self) -> list[Plane]:
        """See `Region.planes`."""
        ends = enumerate(zip(self.min, self.max, strict=True))
        return [across(i, at, self.min, self.max) for i, pair in ends for at in pair]

    def flats(self) -> list[Flat]:
        """See `Region.flats`."""
        axes = np.eye(len(self.min))
        return [Flat(tuple(n), at) for at in (self.min, self.max) for n in axes.tolist()]

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`."""
        return np.tile([self.min[axis], self.max[axis]], (len(points), 1))
