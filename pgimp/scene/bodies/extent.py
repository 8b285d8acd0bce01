"""Bounds of a case's number of particles, computed without storing particles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.schema import Case
from pgimp.geometry.regions import Points
from pgimp.geometry.regions.base import Region

#: Limit of bricks examined times parts of the regions: a fraction of a second.
_LOOKS = 400_000


class Extent(NamedTuple):
    """Bounds of a body without examining its particles one by one."""

    #: low, high: Corners of the part of the lattice that holds the body.
    low: tuple[int, ...]
    high: tuple[int, ...]
    #: least, most: Bounds of the number of particles.
    least: float
    most: float
    surface: float  #: Approximate number of boxes that the surface may cut.

    @property
    def boxes(self) -> tuple[int, ...]:
        """Number of boxes from `low` to `high` along each direction."""
        return tuple(b - a for a, b in zip(self.low, self.high, strict=True))


def points(case: Case) -> tuple[int, ...]:
    """Number of lattice boxes along each direction."""
    return tuple(
        cells * each
        for cells, each in zip(case.grid.cells, case.method.particles_per_cell, strict=True)
    )


def extents(case: Case) -> list[Extent]:
    """Extent of every body."""
    origin = np.array(case.grid.origin, float)
    size = np.array(case.grid.cell, float) / np.array(case.method.particles_per_cell, float)
    found = []
    for body in case.bodies.values():
        low, high = [], []
        ends = zip(*body.region.bounds(), origin, size, points(case), strict=True)
        for a, b, x, h, n in ends:
            low.append(int(np.clip(np.floor((a - x) / h), 0, n)))
            high.append(int(np.clip(np.ceil((b - x) / h), low[-1], n)))
        if isinstance(body.region, Points):
            high = [max(a + 1, b) for a, b in zip(low, high, strict=True)]
            count = float(body.region.summary.number)
            found.append(Extent(tuple(low), tuple(high), count, count, 0.0))
            continue
        looks = _LOOKS // (body.region.parts * len(case.bodies))
        found.append(_extent(body.region, origin, size, tuple(low), tuple(high), looks))
    return found


def _extent(
    region: Region,
    origin: NDArray[np.float64],
    size: NDArray[np.float64],
    low: tuple[int, ...],
    high: tuple[int, ...],
    looks: int,
) -> Extent:
    """Subdivide bricks that the surface may cut, down to boxes or up to `_LOOKS`."""
    D = len(low)
    a, b = np.array([low], float), np.array([high], float)
    least = cut_through = surface = 0.0
    while True:
        extent = b - a
        middle = origin + 0.5 * (a + b) * size
        radius = 0.5 * np.sqrt(np.square(extent * size).sum(axis=1)) * (1.0 + 1e-9)
        distance = region.distance(middle)
        boxes = extent.prod(axis=1)
        least += float(boxes[distance < -radius].sum())
        mixed = ~(np.abs(distance) > radius) & (boxes > 0.0)
        cut_through += float((mixed & (boxes == 1.0)).sum())
        divide = mixed & (boxes > 1.0)
        looks -= len(boxes)
        a, b, boxes = a[divide], b[divide], boxes[divide]
        if len(a) == 0 or looks < 2**D * len(a):
            # A surface through a brick has some three layers of boxes at it.
            thin = np.maximum(1.0, (b - a).min(axis=1, initial=np.inf) / 3.0)
            surface = cut_through + float((boxes / thin).sum())
            return Extent(low, high, least, least + cut_through + float(boxes.sum()), surface)
        # Of what can be divided: one box may be longer than many across it.
        longest = np.where(b - a > 1.0, (b - a) * size, 0.0).max(axis=1)
        for d in range(D):
            long = (b[:, d] - a[:, d] > 1.0) & ((b[:, d] - a[:, d]) * size[d] > 0.5 * longest)
            cut = np.floor(0.5 * (a[:, d] + b[:, d]))
            a, b = np.concatenate([a, a[long]]), np.concatenate([b, b[long]])
            b[: len(long)][long, d] = cut[long]
            a[len(long) :, d] = cut[long]
            longest = np.concatenate([longest, longest[long]])
