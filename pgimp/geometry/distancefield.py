"""Distances to the surface of a rigid body, and normals, on a lattice that moves with it.

Interpolated distances are exact where the surface is flat, for all regions: boxes, balls, their
combinations, meshes. The interpolation is in the kernels, see `pgimp.kernels.rigid.bodies`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.regions.base import Region

#: Spacing of the lattice's points, over the smallest side of a cell.
SPACING = 0.5

#: Cells by which the lattice extends beyond the body: the reach of a vertex, and one more.
MARGIN = 3.0

#: Step of the differences for normals, over the spacing.
_STEP = 1e-3

#: Points per block of the computation.
_BLOCK = 1 << 16


class DistanceField(NamedTuple):
    """Distances and normals on a lattice."""

    #: (3,) float64: First point of the lattice; 0 in directions that the scene does not have.
    low: NDArray[np.float64]
    spacing: float  #: Spacing of its points.
    #: (3,) int64: Number of points along each direction; 1 where the scene has none.
    shape: NDArray[np.int64]
    #: (points, 5) float64: Distance, negative inside; unit vector away from the body; mean distance
    #: over a vertex's neighbourhood if the body is not turned. Points in C order.
    values: NDArray[np.float64]

    @property
    def middle(self) -> NDArray[np.float64]:
        """The middle of the lattice, (3,)."""
        return self.low + 0.5 * self.spacing * (self.shape - 1)

    def least_by_block(self, block: int) -> NDArray[np.float64]:
        """Least distances by block of so many points by direction, and one beside it, (blocks,)."""
        least = self.values[:, 0].reshape(tuple(self.shape))
        for axis, points in enumerate(self.shape.tolist()):
            ends = [(max(n - 1, 0), min(n + block + 1, points)) for n in range(0, points, block)]
            parts = [least.take(range(*end), axis).min(axis, keepdims=True) for end in ends]
            least = np.concatenate(parts, axis)
        return least.reshape(-1)

    def points(self, numbers: NDArray[np.int64], D: int) -> NDArray[np.float64]:
        """Return the positions of points, given by their numbers, (n, D)."""
        places = np.stack(np.unravel_index(numbers, tuple(self.shape)), axis=1)[:, :D]
        return self.low[:D] + self.spacing * places


def extent(
    region: Region, cell: tuple[float, ...], within: tuple[NDArray, NDArray] | None
) -> tuple[NDArray[np.float64], float, NDArray[np.int64]]:
    """Return first point, spacing and shape of a region's lattice.

    The region's middle is on a lattice point, or half-way between two. So the lattice of a
    symmetric region is symmetric, and its points do not depend on `within`. Of these two choices
    the points nearer to the region's ends are taken, as edges between points are rounded.

    Parameters
    ----------
    region : Region
        The body at the start, of finite size.
    cell : tuple of D float
        Sides of a cell.
    within : (low, high), optional
        Ends of the part of the region that can matter during the run.
    """
    spacing, D = SPACING * min(cell), len(cell)
    low, high = (np.array(end, float) for end in region.bounds())
    middle, half = 0.5 * (low + high), 0.5 * (high - low) / spacing
    between = np.abs(half - 0.5 - np.round(half - 0.5)) < np.abs(half - np.round(half)) - 1e-6
    middle += np.where(between, 0.5 * spacing, 0.0)
    low, high = low - MARGIN * np.array(cell), high + MARGIN * np.array(cell)
    if within is not None:
        low, high = np.maximum(low, within[0]), np.minimum(high, within[1])
    begin = np.floor((low - middle) / spacing + 1e-9)
    counts = np.maximum(np.ceil((high - middle) / spacing - 1e-9) - begin, 1.0) + 1.0
    shape = np.ones(3, np.int64)
    shape[:D] = np.minimum(counts, 1e9)
    first = np.zeros(3)
    first[:D] = middle + spacing * begin
    return first, spacing, shape


def distance_field(
    region: Region, cell: tuple[float, ...], within: tuple[NDArray, NDArray] | None = None
) -> DistanceField:
    """Compute the distances of a region, and normals from their differences; see `extent`."""
    low, spacing, shape = extent(region, cell, within)
    D, count = len(cell), int(np.prod(shape))
    values = np.zeros((count, 5))
    field = DistanceField(low, spacing, shape, values)
    for begin in range(0, count, _BLOCK):
        numbers = np.arange(begin, min(begin + _BLOCK, count))
        found = region.distances_around(field.points(numbers, D), _STEP * spacing)
        values[numbers, 0] = found[:, 0]
        values[numbers, 1 : 1 + D] = found[:, 1 : 1 + D] - found[:, 1 + D :]
    length = np.sqrt(np.square(values[:, 1:4]).sum(axis=1))
    values[:, 1:4] /= np.where(length > 0.0, length, 1.0)[:, None]
    mean = values[:, 0].reshape(shape)
    for d in range(D):
        mean = _mean(mean, d, 0.5 * cell[d] / spacing)
    values[:, 4] = mean.ravel()
    return field


def _mean(values: NDArray[np.float64], d: int, step: float) -> NDArray[np.float64]:
    """Half of each value plus a quarter of the values `step` points before and behind it."""
    n = values.shape[d]
    found = 0.5 * values
    for side in (-1.0, 1.0):
        at = np.clip(np.arange(n) + side * step, 0.0, n - 1.0)
        first = np.minimum(at.astype(int), n - 2)
        part = (at - first).reshape([-1 if e == d else 1 for e in range(3)])
        near, far = np.take(values, first, axis=d), np.take(values, first + 1, axis=d)
        found += 0.25 * ((1.0 - part) * near + part * far)
    return found


def thickness(region: Region, D: int) -> float:
    """Return twice the depth of a region's deepest point, within some per cent."""
    low, high = (np.array(end, float) for end in region.bounds())
    count = (65, 49, 25)[D - 1]
    points = low + (high - low) * _grid(np.linspace(0.0, 1.0, count), D)
    step = (high - low) / (count - 1)
    for _ in range(3):
        depth = -region.signed_distance(points)
        best = points[np.argsort(-depth, kind="stable")[:8]]
        points = (best[:, None] + step * _grid(np.linspace(-0.5, 0.5, 5), D)).reshape(-1, D)
        step = 0.25 * step
    return 2.0 * max(0.0, float(depth.max()))


def _grid(values: NDArray[np.float64], D: int) -> NDArray[np.float64]:
    """Grid of all points with these coordinates, (n^D, D)."""
    return np.stack(np.meshgrid(*[values] * D, indexing="ij"), axis=-1).reshape(-1, D)
