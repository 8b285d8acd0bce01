"""Circular cylinder between two points."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from pgimp.geometry.regions.base import (
    Bounds,
    Flat,
    Lengths,
    Mask,
    Plane,
    Points,
    Region,
    Round,
    across,
    roots,
)
from pgimp.schema.base import Model, Positive, Vector
from pgimp.schema.problems import Problem, raise_problems


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
        along, square = self._cylindrical(points)
        return (0.0 <= along) & (along < self._length()) & (square < self.radius * self.radius)

    def _cylindrical(self, points: Points) -> tuple[Lengths, Lengths]:
        """Return the coordinate along the axis and the squared distance from it."""
        axis = self._axis()
        along, square = self._along(points, axis), np.zeros(len(points))
        for i, (a, u) in enumerate(zip(self.start, axis, strict=True)):
            if abs(u) < 1.0:  # else nothing is across the axis
                square += (_across(points[:, i] - a, along, u)) ** 2
        return along, square

    def _along(self, points: Points, axis: tuple[float, ...]) -> Lengths:
        """Return the coordinate along the axis."""
        along = np.zeros(len(points))
        for i, (a, u) in enumerate(zip(self.start, axis, strict=True)):
            if u != 0.0:
                along += (points[:, i] - a) * u
        return along

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        reach = [self.radius * math.sqrt(max(0.0, 1.0 - u * u)) for u in self._axis()]
        pairs = list(zip(self.start, self.end, reach, strict=True))
        return tuple(min(a, b) - r for a, b, r in pairs), tuple(max(a, b) + r for a, b, r in pairs)

    def _parallel(self) -> int | None:
        """Return the axis's direction if it is along the grid."""
        moved = [i for i, (a, b) in enumerate(zip(self.start, self.end, strict=True)) if a != b]
        return moved[0] if len(moved) == 1 else None

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        along, square = self._cylindrical(points)
        ends = np.maximum(-along, along - self._length())
        return np.maximum(np.sqrt(square) - self.radius, ends)

    def signed_distance(self, points: Points) -> Lengths:
        """See `Region.signed_distance`."""
        along, square = self._cylindrical(points)
        ends = np.maximum(-along, along - self._length())
        mantle = np.sqrt(square) - self.radius
        outside = np.hypot(np.maximum(mantle, 0.0), np.maximum(ends, 0.0))
        return np.where(np.maximum(mantle, ends) > 0.0, outside, np.maximum(mantle, ends))

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`; the mantle, and tilted ends."""
        along, square = self._cylindrical(points)
        mantle = np.abs(np.sqrt(square) - self.radius)
        if self._parallel() is not None:
            return mantle
        return np.minimum(mantle, np.minimum(np.abs(along), np.abs(along - self._length())))

    def planes(self) -> list[Plane]:
        """See `Region.planes`; if the axis is along the grid, the ends and tangent planes."""
        parallel = self._parallel()
        if parallel is None:
            return []
        low, high = self.bounds()
        found = [across(parallel, at, low, high) for at in (low[parallel], high[parallel])]
        line = [
            tuple(ends[i] if i == parallel else self.start[i] for i in range(3))
            for ends in (low, high)
        ]
        sides = [i for i in range(3) if i != parallel]
        return found + [across(i, at, *line) for i in sides for at in (low[i], high[i])]

    def flats(self) -> list[Flat]:
        """See `Region.flats`; the ends."""
        return [Flat(self._axis(), end) for end in (self.start, self.end)]

    def rounds(self) -> list[Round]:
        """See `Region.rounds`; the mantle."""
        return [Round(self.start, self.radius, self._axis())]

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`; x is relative to each point's own coordinate."""
        u = self._axis()
        along = self._along(points, u)
        # Squared distance from the axis: constant, half the linear, and quadratic term.
        c = np.full(len(points), -self.radius * self.radius)
        b = np.zeros(len(points))
        for i, a in enumerate(self.start):
            if abs(u[i]) == 1.0:
                continue
            away = _across(points[:, i] - a, along, u[i])
            c += away * away
            if (slope := float(i == axis) - u[axis] * u[i]) != 0.0:
                b += away * slope
        x = points[:, axis : axis + 1]
        if abs(u[axis]) == 1.0:  # no line meets the mantle
            ends = np.stack([-along, self._length() - along], axis=1) / u[axis]
            return np.where((c > 3.0 * self.radius * self.radius)[:, None], np.nan, ends) + x
        if u[axis] == 0.0:  # no line meets the ends
            far = np.abs(along - 0.5 * self._length()) > 0.5 * self._length() + self.radius
            return np.where(far[:, None], np.nan, roots(1.0, b, c)) + x
        aa = sum((float(i == axis) - u[axis] * u[i]) ** 2 for i in range(3))
        mantle = roots(aa, b, c)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            ends = np.stack([-along, self._length() - along], axis=1) / u[axis]
            # Far beyond the rims, mantle and ends are no surface.
            height = along[:, None] + mantle * u[axis]
            far = np.abs(height - 0.5 * self._length()) > 0.5 * self._length() + self.radius
            mantle = np.where(far, np.nan, mantle)
            square = c[:, None] + (2.0 * b[:, None] + aa * ends) * ends
            ends = np.where(square > 3.0 * self.radius * self.radius, np.nan, ends)
        return np.concatenate([mantle, ends], axis=1) + x


def _across(away: Lengths, along: Lengths, u: float) -> Lengths:
    """Component across an axis, whose component is u, of vectors from a point of it."""
    return away if u == 0.0 else away - along * u
