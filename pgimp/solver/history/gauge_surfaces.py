"""Surfaces of gauges: how much of a point is inside, and how a velocity passes them.

Each surface is spread over a cell on either side. Points are computed one by one, in a fixed order
of operations, so that no bit depends on the ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.geometry.regions import Box, HalfSpace
from pgimp.geometry.regions.base import Region

Array = np.ndarray


class Side(NamedTuple):
    """A plane of a surface."""

    normal: tuple[float, ...]  #: tuple of D float: Out of the inside.
    point: tuple[float, ...]  #: tuple of D float: A point of the plane.
    width: float  #: Size of a cell along the normal.
    period: float = 0.0  #: Period of the domain along the normal, 0 without one.
    rest: float = 0.0  #: Part of the tent about the plane that lies beyond the domain's outer end.
    seen: float = 1.0  #: Part of it that lies in the domain.

    def beyond(self, points: Array) -> Array:
        """Return the distance of points (n, D) beyond the plane, in cells."""
        away = np.zeros(len(points))
        for d, (n, x) in enumerate(zip(self.normal, self.point, strict=True)):
            if n != 0.0:
                away += n * (points[:, d] - x)
        if self.period > 0.0:
            away -= np.round(away / self.period) * self.period
        return away / self.width

    def within(self, away: Array) -> Array:
        """Return weights (n,) of points by their distance: 1 far inside, 0 far outside.

        They fall over two cells, like the integral of a tent, of its part in the domain.
        """
        return np.maximum(_ramp(away) - self.rest, 0.0) / self.seen


class Surface(NamedTuple):
    """The surface of a half-space or of a box, without what lies beyond the domain."""

    sides: tuple[Side, ...]

    def inside(self, points: Array) -> Array:
        """Return weights (n,) of vertices: 1 inside, 0 outside, linear over a cell in between."""
        found = np.ones(len(points))
        for side in self.sides:
            found *= np.clip(0.5 - side.beyond(points), 0.0, 1.0)
        return found

    def passing(self, points: Array, velocity: Array) -> Array:
        """Return the rate (n,) at which points leave, per time: of a mean over a cell each way."""
        away = [side.beyond(points) for side in self.sides]
        # The weight of a side is the integral of a tent; its rate is the tent over the width.
        weights = [side.within(x) for side, x in zip(self.sides, away, strict=True)]
        found = np.zeros(len(points))
        for i, side in enumerate(self.sides):
            rate = np.zeros(len(points))
            for d, n in enumerate(side.normal):
                if n != 0.0:
                    rate += n * velocity[:, d]
            rate *= np.maximum(0.0, 1.0 - np.abs(away[i])) / (side.seen * side.width)
            for j, weight in enumerate(weights):
                if j != i:
                    rate *= weight
            found += rate
        return found

    def near(self, points: Array) -> Array:
        """Return a mask (n,) of the points that may have a weight between 0 and 1 in a step.

        In a step no point moves farther than a cell.
        """
        far = np.zeros(len(points), bool)
        close = np.zeros(len(points), bool)
        for side in self.sides:
            away = side.beyond(points)
            far |= away > 2.0
            close |= away > -2.0
        return close & ~far

    def passed(self, before: Array, way: Array) -> Array:
        """Return the part (n,) of points at `before` that leaves on their way (n, D)."""
        had, has = np.ones((2, len(before)))
        for side in self.sides:
            away, moved = side.beyond(before), np.zeros(len(before))
            for d, n in enumerate(side.normal):
                if n != 0.0:
                    moved += n * way[:, d]
            had *= side.within(away)
            has *= side.within(away + moved / side.width)
        return had - has


def _ramp(x: Array) -> Array:
    """Return the integral of a tent from `x` on: 1 below -1, 0 above 1."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 * np.where(x > 0.0, (1.0 - x) ** 2, 2.0 - (1.0 + x) ** 2)


def covered(low: float, high: float, at: float, cell: float) -> float:
    """Return the integral of a tent of width `cell` about `at`, from `low` to `high`."""
    ends = _ramp(np.array([(low - at) / cell, (high - at) / cell]))
    return cell * float(ends[0] - ends[1])


def _side(
    normal: tuple[float, ...],
    point: tuple[float, ...],
    d: int,
    ends: tuple[float, float],
    cell: float,
    period: float,
) -> Side:
    """A plane across direction `d`, in a domain with these ends."""
    if period > 0.0:
        return Side(normal, point, cell, period)
    outer = (ends[1] - point[d]) if normal[d] > 0.0 else (point[d] - ends[0])
    seen = covered(*ends, point[d], cell) / cell
    return Side(normal, point, cell, 0.0, float(_ramp(np.array(outer / cell))), seen)


def surface_of(
    region: Region,
    cell: Sequence[float],
    ends: Sequence[tuple[float, float]],
    periods: Sequence[float],
) -> Surface:
    """Return the surface of a half-space or of a box in a domain.

    Parameters
    ----------
    region
        HalfSpace or Box.
    cell : sequence of float
        Size of a cell by direction.
    ends : sequence of (float, float)
        Both ends of the domain by direction.
    periods : sequence of float
        Period of the domain by direction, 0 without one.
    """
    if isinstance(region, HalfSpace):
        flat = region.flats()[0]
        width = sum(abs(n) * h for n, h in zip(flat.normal, cell, strict=True))
        along = [d for d, n in enumerate(flat.normal) if n != 0.0]
        if len(along) > 1:
            return Surface((Side(flat.normal, flat.point, width),))
        d = along[0]
        return Surface((_side(flat.normal, flat.point, d, ends[d], cell[d], float(periods[d])),))
    assert isinstance(region, Box)
    sides = []
    for d, (low, high) in enumerate(ends):
        for sign, at, is_end in (
            (-1.0, region.min[d], region.min[d] <= low),
            (1.0, region.max[d], region.max[d] >= high),
        ):
            if not is_end:
                normal = tuple(sign if k == d else 0.0 for k in range(len(cell)))
                point = tuple(at if k == d else 0.0 for k in range(len(cell)))
                side = _side(normal, point, d, (low, high), cell[d], float(periods[d]))
                sides.append(side._replace(period=0.0))
    return Surface(tuple(sides))
