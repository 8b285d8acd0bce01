"""Base of regions inside a closed surface that a file gives."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.regions.base import Bounds, Lengths, Mask, Plane, Points, Region, around
from pgimp.schema.base import Model

if TYPE_CHECKING:
    from pgimp.geometry.mesh.tree import Surface


class Enclosed(Model, Region):
    """The inside of a closed surface; the file is read at first use of `surface`."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)
    FROM_FILE: ClassVar[bool] = True

    #: What the file is, for messages.
    WHAT: ClassVar[str]

    if TYPE_CHECKING:  # fields of all of them, in an order of their own
        file: str
        scale: float
        translate: tuple[float, ...] | None

    @property
    @abstractmethod
    def surface(self) -> Surface:
        """The surface in the case's coordinates; kept in the instance.

        Raises
        ------
        CaseError
            If the file cannot be read, or encloses nothing.
        """

    def belong(self, dimensions: int) -> None:
        """See `Region.belong`."""
        self.__dict__["dimensions_of_case"] = dimensions

    @property
    def dimensions(self) -> int:
        """Directions of the case."""
        return self.__dict__.get("dimensions_of_case", 3)

    def contains(self, points: Points) -> Mask:
        """See `Region.contains`."""
        return self.surface.contains(points)

    def bounds(self) -> Bounds:
        """See `Region.bounds`."""
        return self.surface.bounds

    def distance(self, points: Points) -> Lengths:
        """See `Region.distance`; exact."""
        return self.surface.distance(points)

    def distances_around(self, points: Points, step: float) -> Lengths:
        """See `Region.distances_around`; the side is the same, unless the surface is near."""
        found = self.surface.reach(points, step)
        found[self.contains(points)] *= -1.0
        near = np.flatnonzero(np.abs(found[:, 0]) <= 2.0 * step)
        for k, place in enumerate(around(points[near], step)):
            found[near, k] = np.where(self.contains(place), -1.0, 1.0) * np.abs(found[near, k])
        return found

    def curved(self, points: Points) -> Lengths:
        """See `Region.curved`."""
        return np.abs(self.distance(points))

    def planes(self) -> list[Plane]:
        """See `Region.planes`."""
        return []

    def crossings(self, points: Points, axis: int) -> Lengths:
        """See `Region.crossings`."""
        return self.surface.crossings(points, axis)

    def facets(self, edges: list[Lengths]) -> tuple[NDArray[np.int64], Points, Points, Points]:
        """See `Region.facets`."""
        from pgimp.geometry.mesh.facets import facets

        return facets(self.surface.triangles, edges)

    def fill(
        self, edges: list[Lengths], ranges: Sequence[tuple[int, int]], products: bool = False
    ) -> tuple[Mask, NDArray[np.int64], Lengths, Points]:
        """See `Region.fill`."""
        try:
            return self.surface.fill(edges, list(ranges), products)
        except CaseError as error:
            raise CaseError(f"{self.WHAT} {self.file} {error}") from None

    def facts(self) -> list[str]:
        """See `Region.facts`."""
        surface = self.surface
        low, high = surface.bounds
        what = "triangles" if self.dimensions == 3 else "segments"
        size = "volume" if self.dimensions == 3 else "area"

        def place(x: tuple[float, ...]) -> str:
            return "(" + ", ".join(f"{value:.6g}" for value in x) + ")"

        return [
            f"{surface.facets:,} {what}, from {place(low)} to {place(high)}, "
            f"{size} {surface.volume:.6g}"
        ]

    def notes(self) -> list[str]:
        """See `Region.notes`."""
        return [f"{self.file}: {note}" for note in self.surface.notes]
