"""Circular cylinder between two points."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from pgimp.case.base import Model, Positive, Vector
from pgimp.case.problems import Problem, raise_problems
from pgimp.scene.regions.base import Bounds, Mask, Points, Region


class Cylinder(Model, Region):
    """Circular cylinder in 3D; its mantle and the end at `to` are outside."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)

    start: Vector = Field(alias="from", description="centre of one end [length]")
    end: Vector = Field(alias="to", description="centre of the other end [length]")
    radius: Positive = Field(description="radius [length]")

    @model_validator(mode="after")
    def _check_axis(self) -> Cylinder:
        if len(self.start) == len(self.end) and not self._length() > 0.0:
            raise_problems("cylinder", [Problem(("to",), "the same point as from")])
        return self

    def _length(self) -> float:
        return math.hypot(*(b - a for a, b in zip(self.start, self.end, strict=True)))

    def _axis(self) -> tuple[float, ...]:
        """Return the unit vector from one end to the other."""
        length = self._length()
        return tuple((b - a) / length for a, b in zip(self.start, self.end, strict=True))

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        axis = self._axis()
        along = np.zeros(len(points))
        for i, a in enumerate(self.start):
            along += (points[:, i] - a) * axis[i]
        square = np.zeros(len(points))
        for i, a in enumerate(self.start):
            square += ((points[:, i] - a) - along * axis[i]) ** 2
        return (0.0 <= along) & (along < self._length()) & (square < self.radius * self.radius)

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        reach = [self.radius * math.sqrt(max(0.0, 1.0 - u * u)) for u in self._axis()]
        pairs = list(zip(self.start, self.end, reach, strict=True))
        return tuple(min(a, b) - r for a, b, r in pairs), tuple(max(a, b) + r for a, b, r in pairs)
