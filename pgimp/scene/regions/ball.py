"""Ball: a sphere in 3D, a disk in 2D, an interval in 1D."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from pgimp.case.base import Model, Positive, Vector
from pgimp.scene.regions.base import Bounds, Mask, Points, Region


class Ball(Model, Region):
    """Ball, a disk in 2D; its surface is outside."""

    centre: Vector = Field(description="centre [length]")
    radius: Positive = Field(description="radius [length]")

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        square = np.zeros(len(points))
        for i, centre in enumerate(self.centre):
            square += (points[:, i] - centre) ** 2
        return square < self.radius * self.radius

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        return (
            tuple(centre - self.radius for centre in self.centre),
            tuple(centre + self.radius for centre in self.centre),
        )
