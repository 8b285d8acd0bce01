"""Half-space: all points on one side of a plane.

As for boxes, points on the plane belong to the half-space if the plane is its low face. With two
opposite normals, each point belongs to exactly one half-space.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field, model_validator

from pgimp.geometry.regions.base import Bounds, Flat, Lengths, Mask, Plane, Points, Region, across
from pgimp.schema.base import Model, Vector
from pgimp.schema.problems import Problem, raise_problems


class HalfSpace(Model, Region):
    """Side of a plane that its normal points away from; of a body only a part (intersection)."""

    point: Vector = Field(description="a point of the plane [length]")
    normal: Vector = Field(
        description="normal of the plane, of any length, out of the material: the material is on "
        "the other side"
    )

    @model_validator(mode="after")
    def _check_normal(self) -> HalfSpace:
        if len(self.point) != len(self.normal):
            text = f"expected {len(self.point)} entries as in point, got {len(self.normal)}"
            raise_problems("half-space", [Problem(("normal",), text)])
        if not (0.0 < math.hypot(*self.normal) < math.inf):
            text = "expected a vector with a length above zero, and below 1e308"
            raise_problems("half-space", [Problem(("normal",), text)])
        return self

    def _unit(self) -> tuple[float, ...]:
        """Return the unit normal."""
        length = math.hypot(*self.normal)
        return tuple(n / length for n in self.normal)

    def _across(self) -> int | None:
        """Return the axis along the normal, if there is one."""
        along = [i for i, n in enumerate(self.normal) if n != 0.0]
        return along[0] if len(along) == 1 else None

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        away = self.distance(points)
        is_low_face = next(n for n in self.normal if n != 0.0) < 0.0
        return away <= 0.0 if is_low_face else away < 0.0

    def bounds(self) -> Bounds:
        """See `Region.bounds`; infinite except one end if the normal is along an axis."""
        low, high = [-math.inf] * len(self.point), [math.inf] * len(self.point)
        axis = self._across()
        if axis is not None:
            (high if self.normal[axis] > 0.0 else low)[axis] = self.point[axis]
        return tuple(low), tuple(high)

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`; exact."""
        return self._beyond(points)

    def _beyond(self, points: Points, without: int | None = None) -> Lengths:
        """Return the distance of points beyond the plane, without the part along an axis."""
        away = np.zeros(len(points))
        for i, (n, p) in enumerate(zip(self._unit(), self.point, strict=True)):
            if n != 0.0 and i != without:
                away += n * (points[:, i] - p)
        return away

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`; a plane that lies across no axis counts."""
        if self._across() is not None:
            return np.full(len(points), np.inf)
        return np.abs(self.distance(points))

    def planes(self) -> list[Plane]:
        """See `Region.planes`."""
        axis = self._across()
        if axis is None:
            return []
        D = len(self.point)
        return [across(axis, self.point[axis], (-math.inf,) * D, (math.inf,) * D)]

    def flats(self) -> list[Flat]:
        """See `Region.flats`."""
        return [Flat(self._unit(), self.point)]

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`."""
        slope = self._unit()[axis]
        if slope == 0.0:
            return np.zeros((len(points), 0))
        with np.errstate(over="ignore"):
            return (self.point[axis] - self._beyond(points, axis) / slope)[:, None]
