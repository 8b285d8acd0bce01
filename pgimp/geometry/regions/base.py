"""Base of all regions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from pgimp.schema.registries import ByKey

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]
Lengths = NDArray[np.float64]
Bounds = tuple[tuple[float, ...], tuple[float, ...]]


class Plane(NamedTuple):
    """A part of a surface, or a tangent plane of it, in a plane across an axis.

    `low` and `high` are the corners of a box around it; both hold `at` along the axis.
    """

    axis: int
    at: float
    low: tuple[float, ...]
    high: tuple[float, ...]


class Flat(NamedTuple):
    """A flat part of a surface at any angle: the unit normal and a point of its plane."""

    normal: tuple[float, ...]
    point: tuple[float, ...]


class Round(NamedTuple):
    """A round part of a surface: a sphere, or a cylinder without ends round an axis.

    `axis` is the cylinder's unit vector; None for a sphere, in 2D a circle.
    """

    centre: tuple[float, ...]
    radius: float
    axis: tuple[float, ...] | None = None


def across(axis: int, at: float, low: tuple[float, ...], high: tuple[float, ...]) -> Plane:
    """Return the plane at coordinate `at` within the box from `low` to `high`."""
    ends = [tuple(at if d == axis else x for d, x in enumerate(end)) for end in (low, high)]
    return Plane(axis, at, ends[0], ends[1])


class Region(ABC):
    """A part of space. Points on its surface are inside or outside by a fixed rule.

    Each point is computed separately, in a fixed order of operations, so results do not depend on
    the other points of the call.
    """

    #: Whether it is in a file, which is not read when a case is validated.
    FROM_FILE: ClassVar[bool] = False
    #: Whether it can only be a whole body, not a part of another region.
    WHOLE_BODY: ClassVar[bool] = False

    @property
    def parts(self) -> int:
        """Number of its simple regions."""
        return 1

    def belong(self, dimensions: int) -> None:
        """Set the dimensions of the case."""

    def misfits(self, dimensions: int) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yield keys below the region that do not fit the dimensions, and why."""
        return iter(())

    def simple(self) -> Iterator[Region]:
        """Yield its simple regions."""
        yield self

    def facts(self) -> list[str]:
        """Notes for the user before a run, a line each; none if the case has the information."""
        return []

    def notes(self) -> list[str]:
        """Repairs of its file's content."""
        return []

    def fill(
        self, edges: list[Lengths], ranges: Sequence[tuple[int, int]], products: bool = False
    ) -> tuple[Mask, NDArray[np.int64], Lengths, Points] | None:
        """Measure all boxes of a part of a lattice; None if boxes are measured one by one.

        Parameters
        ----------
        edges : list of (n + 1,) float64
            Edges of the lattice's boxes by direction.
        ranges : list of (int, int)
            First box and end by direction; the boxes are numbered in C order.
        products : bool
            Whether to measure products of inertia, too.

        Returns
        -------
        whole : (boxes,) bool
            Boxes that lie inside and do not meet the surface.
        places : (n,) int64
            Boxes that meet the surface, ascending.
        volume, moment : (n,) and (n, D or 2^D - 1) float64
            See `pgimp.geometry.measure.measure`.
        """
        return None

    def facets(
        self, edges: list[Lengths]
    ) -> tuple[NDArray[np.int64], Points, Points, Points] | None:
        """Pieces of a surface of triangles in the boxes of a lattice; None for other surfaces.

        Returns
        -------
        box : (n, D) int64
            Numbers of their boxes by direction.
        centre, area : (n, D) float64
            Centroids, and area vectors out of the region.
        second : (n, 0, 1 or 4) float64
            Means of products of the distances from the centroid: xy in 2D; yz, xz, xy, xyz in 3D.
        """
        return None

    @abstractmethod
    def contains(self, points: Points) -> Mask:
        """Return a mask of the points in the region.

        Parameters
        ----------
        points : ndarray of float64, shape (n, D)
            Positions.

        Returns
        -------
        ndarray of bool, shape (n,)
            Whether each point is inside.
        """

    @abstractmethod
    def bounds(self) -> Bounds:
        """Return the low and the high corner, shape (D,) each, of the region's bounding box.

        Infinite where the region has no end; low above high where it is empty.
        """

    def flats(self) -> list[Flat]:
        """Return the planes of its flat surfaces."""
        return []

    def rounds(self) -> list[Round]:
        """Return the spheres and cylinders of its round surfaces."""
        return []

    def at(self, axis: int, reach: float) -> str:
        """Describe the part at a bound along an axis, for messages; may be empty."""
        return ""

    def near(self, low: Sequence[float], high: Sequence[float]) -> Region | None:
        """Return a region that is equal within a box, without parts that do not reach the box.

        None if no part does.
        """
        least, most = self.bounds()
        pairs = (*zip(least, high, strict=True), *zip(low, most, strict=True))
        return self if all(a <= b for a, b in pairs) else None

    @abstractmethod
    def distance(self, points: Points) -> Lengths:
        """Return a lower bound, in amount, of the distance to the surface: negative inside.

        It differs between two points by at most their distance. A ball around a point, with a
        radius below its amount, is therefore entirely inside or entirely outside.
        """

    def signed_distance(self, points: Points) -> Lengths:
        """Return the distance to the surface, negative inside: exact where it is flat or round.

        At edges between the regions of a combination it is a bound.
        """
        return self.distance(points)

    def distances_around(self, points: Points, step: float) -> Lengths:
        """Return `signed_distance` of points and a step beside them, see `around`, (n, 1 + 2 D)."""
        return np.stack([self.signed_distance(place) for place in around(points, step)], axis=1)

    @abstractmethod
    def curved(self, points: Points) -> Lengths:
        """Return a bound of the distance to the parts of the surface not in `planes`.

        Zero or more; infinite if there are none.
        """

    @abstractmethod
    def planes(self) -> list[Plane]:
        """Return the parts of the surface across an axis, and further planes to cut at.

        Curved surfaces are measured more accurately if cut at their extremes.
        """

    @abstractmethod
    def crossings(self, points: Points, axis: int) -> Lengths:
        """Return the coordinates at which lines through the points may enter or leave the region.

        Parameters
        ----------
        points : ndarray of float64, shape (n, D)
            A point of each line.
        axis : int
            Direction of all lines.

        Returns
        -------
        ndarray of float64, shape (n, k)
            Coordinates along the axis in any order; NaN where a line has fewer than k.
        """


def around(points: Points, step: float) -> list[Points]:
    """Return points, those a step ahead of them along each direction, and those behind."""
    ahead = step * np.eye(points.shape[1])
    return [points, *(points + one for one in ahead), *(points - one for one in ahead)]


def roots(a: Lengths | float, b: Lengths, c: Lengths) -> Lengths:
    """Return both solutions of a x^2 + 2 b x + c = 0, (n, 2); NaN where there are none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        q = -(b + np.copysign(root, b))
        return np.stack([q / a, c / q], axis=1)


#: Regions by their name in the case, ``region: {NAME: ...}``; the package fills it.
REGIONS: dict[str, type[BaseModel]] = {}

REGION = ByKey(lambda: REGIONS, "region")

RegionEntry = Annotated[Any, REGION]
"""A region as a case writes it, ``{box: {...}}``; validated to a `Region`."""
