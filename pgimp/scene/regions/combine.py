"""Regions made of regions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, RootModel, model_validator

from pgimp.case.base import tuples
from pgimp.scene.regions.base import Bounds, Lengths, Mask, Plane, Points, Region, RegionEntry


class Combination(RootModel[Annotated[tuple[RegionEntry, ...], Field(min_length=2)]], Region):
    """Base of the regions that are written as a list of regions."""

    model_config = ConfigDict(strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _take_lists(cls, data: Any) -> Any:
        return tuples(data)

    @property
    def parts(self) -> int:
        """See `Region.parts`."""
        return sum(region.parts for region in self.root)

    def simple(self) -> Iterator[Region]:
        """See `Region.simple`."""
        for region in self.root:
            yield from region.simple()

    def facts(self) -> list[str]:
        """See `Region.facts`."""
        return [fact for region in self.root for fact in region.facts()]

    def notes(self) -> list[str]:
        """See `Region.notes`."""
        return [note for region in self.root for note in region.notes()]

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`."""
        nearest = self.root[0].curved(points)
        for region in self.root[1:]:
            nearest = np.minimum(nearest, region.curved(points))
        return nearest

    def planes(self) -> list[Plane]:
        """See `Region.planes`."""
        return [plane for region in self.root for plane in region.planes()]

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`."""
        return np.concatenate([part.crossings(points, axis) for part in self.root], axis=1)


class Union(Combination):
    """All points that lie in at least one of the regions."""

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = self.root[0].contains(points)
        for region in self.root[1:]:
            inside |= region.contains(points)
        return inside

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        distance = self.root[0].distance(points)
        for region in self.root[1:]:
            distance = np.minimum(distance, region.distance(points))
        return distance

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """See `Region.near`."""
        reach = dict.fromkeys(region.near(low, high) for region in self.root)
        parts = tuple(region for region in reach if region is not None)
        if len(parts) > 1:
            return Union.model_construct(root=parts)
        return parts[0] if parts else None

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        lows, highs = zip(*(region.bounds() for region in self.root), strict=True)
        return (
            tuple(min(low) for low in zip(*lows, strict=True)),
            tuple(max(high) for high in zip(*highs, strict=True)),
        )


class Difference(Combination):
    """All points of the first region that lie in none of the others."""

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = self.root[0].contains(points)
        for region in self.root[1:]:
            inside &= ~region.contains(points)
        return inside

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        distance = self.root[0].distance(points)
        for region in self.root[1:]:
            distance = np.maximum(distance, -region.distance(points))
        return distance

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """See `Region.near`."""
        first = self.root[0].near(low, high)
        reach = dict.fromkeys(region.near(low, high) for region in self.root[1:])
        others = tuple(region for region in reach if region is not None)
        if first is None or not others:
            return first
        return Difference.model_construct(root=(first, *others))

    def bounds(self) -> Bounds:
        """See `Region.bounds`; those of the first region."""
        return self.root[0].bounds()
