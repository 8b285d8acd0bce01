"""Regions made of regions."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field, RootModel, model_validator

from pgimp.case.base import tuples
from pgimp.scene.regions.base import Bounds, Mask, Points, Region, RegionEntry


class Combination(RootModel[Annotated[tuple[RegionEntry, ...], Field(min_length=2)]], Region):
    """Base of the regions that are written as a list of regions."""

    model_config = ConfigDict(strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _take_lists(cls, data: Any) -> Any:
        return tuples(data)


class Union(Combination):
    """All points that lie in at least one of the regions."""

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        inside = self.root[0].contains(points)
        for region in self.root[1:]:
            inside |= region.contains(points)
        return inside

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

    def bounds(self) -> Bounds:
        """See `Region.bounds`; those of the first region."""
        return self.root[0].bounds()
