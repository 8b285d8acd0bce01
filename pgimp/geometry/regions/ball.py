"""Ball: a sphere in 3D, a disk in 2D, an interval in 1D."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pgimp.geometry.regions.base import Bounds, Lengths, Mask, Plane, Points, Region, Round, across
from pgimp.schema.base import Model, Positive, Vector


class Ball(Model, Region):
    """Ball, a disk in 2D; its surface is outside."""

    SPELLINGS: ClassVar[dict[str, str]] = {"center": "centre"}

    centre: Vector = Field(description="centre [length]")
    radius: Positive = Field(description="radius [length]")

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        return self._square(points) < self.radius * self.radius

    def _square(self, points: Points, axis: int | None = None) -> Lengths:
        """Return the squared distance to the centre, without its part along `axis`."""
        square = np.zeros(len(points))
        for i, centre in enumerate(self.centre):
            if i != axis:
                square += (points[:, i] - centre) ** 2
        return square

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        return (
            tuple(centre - self.radius for centre in self.centre),
            tuple(centre + self.radius for centre in self.centre),
        )

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        return np.sqrt(self._square(points)) - self.radius

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`; an interval in 1D has none."""
        if len(self.centre) == 1:
            return np.full(len(points), np.inf)
        return np.abs(self.distance(points))

    def planes(self) -> list[Plane]:
        """See `Region.planes`; the tangent planes."""
        low, high = self.bounds()
        c = self.centre
        return [across(i, at, c, c) for i in range(len(c)) for at in (low[i], high[i])]

    def rounds(self) -> list[Round]:
        """See `Region.rounds`."""
        return [Round(self.centre, self.radius)]

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`."""
        half, found = self._square(points, axis), np.empty((len(points), 2))
        np.subtract(self.radius * self.radius, half, out=half)
        with np.errstate(invalid="ignore"):
            np.sqrt(half, out=half)
        np.subtract(self.centre[axis], half, out=found[:, 0])
        np.add(self.centre[axis], half, out=found[:, 1])
        return found
