"""Regions made of regions."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property, reduce
from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field, RootModel, model_validator

from pgimp.geometry.regions.base import Bounds, Lengths, Mask, Plane, Points, Region, RegionEntry
from pgimp.geometry.regions.extremes import extremes
from pgimp.schema.base import tuples


def _joined(bounds: Iterable[Bounds]) -> Bounds:
    """Return the bounds of the union."""
    lows, highs = zip(*bounds, strict=True)
    return (
        tuple(min(low) for low in zip(*lows, strict=True)),
        tuple(max(high) for high in zip(*highs, strict=True)),
    )


def _common(bounds: Iterable[Bounds]) -> Bounds:
    """Return the bounds of the intersection."""
    lows, highs = zip(*bounds, strict=True)
    return (
        tuple(max(low) for low in zip(*lows, strict=True)),
        tuple(min(high) for high in zip(*highs, strict=True)),
    )


class Combination(RootModel[Annotated[tuple[RegionEntry, ...], Field(min_length=2)]], Region):
    """Base of the regions that are written as a list of regions."""

    model_config = ConfigDict(strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _take_lists(cls, data: object) -> object:
        return tuples(data)

    @property
    def parts(self) -> int:
        """See `Region.parts`."""
        return sum(region.parts for region in self.root)

    def simple(self) -> Iterator[Region]:
        """See `Region.simple`."""
        for region in self.root:
            yield from region.simple()

    @abstractmethod
    def _around(self) -> Bounds:
        """Return bounds from the parts' bounds, possibly too wide."""

    @cached_property
    def exact_bounds(self) -> Bounds:
        """Bounds, exact where `extremes` finds them."""
        return extremes(self, self._around())

    def bounds(self) -> Bounds:
        """See `Region.bounds`; exact except for meshes, and round surfaces that meet in curves."""
        if any(part.FROM_FILE for part in self.simple()):
            return self._around()
        return self.exact_bounds

    def facts(self) -> list[str]:
        """See `Region.facts`."""
        return [fact for region in self.root for fact in region.facts()]

    def notes(self) -> list[str]:
        """See `Region.notes`."""
        return [note for region in self.root for note in region.notes()]

    @abstractmethod
    def _combined(self, distances: Iterator[Lengths]) -> Lengths:
        """Return the distance, given the distances of the parts."""

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`."""
        return self._combined(part.distance(points) for part in self.root)

    def signed_distance(self, points: Points) -> Lengths:
        """See `Region.signed_distance`."""
        return self._combined(part.signed_distance(points) for part in self.root)

    def distances_around(self, points: Points, step: float) -> Lengths:
        """See `Region.distances_around`."""
        return self._combined(part.distances_around(points, step) for part in self.root)

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

    def _combined(self, distances: Iterator[Lengths]) -> Lengths:
        """See `Combination`."""
        return reduce(np.minimum, distances)

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """See `Region.near`."""
        reach = dict.fromkeys(region.near(low, high) for region in self.root)
        parts = tuple(region for region in reach if region is not None)
        if len(parts) > 1:
            return Union.model_construct(root=parts)
        return parts[0] if parts else None

    def _around(self) -> Bounds:
        """See `Combination`."""
        return _joined(region.bounds() for region in self.root)

    def bounds(self) -> Bounds:
        """See `Region.bounds`; from the parts' bounds."""
        return self._around()


class Difference(Combination):
    """All points of the first region that lie in none of the others."""

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = self.root[0].contains(points)
        for region in self.root[1:]:
            inside &= ~region.contains(points)
        return inside

    def _combined(self, distances: Iterator[Lengths]) -> Lengths:
        """See `Combination`."""
        return reduce(lambda whole, part: np.maximum(whole, -part), distances)

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """See `Region.near`."""
        first = self.root[0].near(low, high)
        reach = dict.fromkeys(region.near(low, high) for region in self.root[1:])
        others = tuple(region for region in reach if region is not None)
        if first is None or not others:
            return first
        return Difference.model_construct(root=(first, *others))

    def _around(self) -> Bounds:
        """See `Combination`."""
        return self.root[0].bounds()


class Intersection(Combination):
    """All points that lie in every one of the regions, as of a ball and two half-spaces."""

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = self.root[0].contains(points)
        for region in self.root[1:]:
            inside &= region.contains(points)
        return inside

    def _combined(self, distances: Iterator[Lengths]) -> Lengths:
        """See `Combination`."""
        return reduce(np.maximum, distances)

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """See `Region.near`."""
        reach = dict.fromkeys(region.near(low, high) for region in self.root)
        parts = tuple(region for region in reach if region is not None)
        if len(parts) < len(reach):
            return None
        return Intersection.model_construct(root=parts) if len(parts) > 1 else parts[0]

    def _around(self) -> Bounds:
        """See `Combination`."""
        return _common(region.bounds() for region in self.root)
