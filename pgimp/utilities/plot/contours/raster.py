"""Lattices of points over a body, in the plane of a picture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

Array = np.ndarray

#: Points of particles that are computed at once.
_TOGETHER = 1_000_000


class Raster(NamedTuple):
    """Points in rows and columns."""

    #: x, y: ndarray, shape (columns,) and (rows,): Coordinates in the picture, equally spaced.
    x: Array
    y: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return len(self.y), len(self.x)

    @property
    def low(self) -> Array:
        """The first point, (2,)."""
        return np.array([self.x[0], self.y[0]])

    @property
    def step(self) -> Array:
        """Distances of the points, (2,)."""
        return np.array([self.x[1] - self.x[0], self.y[1] - self.y[0]])

    def windows(self, centre: Array, reach: Array) -> Iterator[tuple[Array, Array, Array]]:
        """Find the points around particles.

        Parameters
        ----------
        centre, reach : ndarray, shape (n, 2)
            Centres, and how far the windows go to either side.

        Yields
        ------
        rows : ndarray of int64, shape (m,)
            Particles with windows of about the same size, as many as memory needs.
        column, row : ndarray of int64, shape (m, k)
            The points of each; some are beyond the raster.
        """
        first = np.ceil((centre - reach - self.low) / self.step).astype(np.int64)
        last = np.floor((centre + reach - self.low) / self.step).astype(np.int64)
        first = np.maximum(first, 0)
        count = np.minimum(last, np.array(self.shape[::-1]) - 1) - first + 1
        size = np.where((count > 0).all(axis=1)[:, None], 2 * ((count + 1) // 2), 0)
        for wide, high in np.unique(size, axis=0):
            some = np.flatnonzero((size == (wide, high)).all(axis=1)) if wide else size[:0, 0]
            each = max(1, _TOGETHER // max(1, int(wide * high)))
            for begin in range(0, len(some), each):
                rows = some[begin : begin + each]
                column = first[rows, 0, None] + np.tile(np.arange(wide), high)
                row = first[rows, 1, None] + np.repeat(np.arange(high), wide)
                yield rows, column, row

    def add(self, sums: Array, column: Array, row: Array, values: Array) -> None:
        """Add values at points to sums, of shape (rows columns,); beyond the raster none."""
        inside = (column < len(self.x)) & (row < len(self.y))
        place = (row * len(self.x) + column)[inside]
        sums += np.bincount(place, values[inside], len(sums))


def raster(low: Array, high: Array, step: Array, fixed: Array, most: int) -> Raster:
    """Return a raster that covers a rectangle.

    Parameters
    ----------
    low, high, step : ndarray, shape (2,)
        Its corners; the wanted distances of points.
    fixed : ndarray of bool, shape (2,)
        Directions in which it begins and ends at the corners: those of periodic faces. In the
        others it goes two points beyond.
    most : int
        Number of points along a side between the corners, at most.
    """
    axes = []
    for a, b, distance, exact in zip(low, high, step, fixed, strict=True):
        count = max(1, int(np.ceil((b - a) / max(distance, (b - a) / most, 1e-300))))
        points = np.linspace(a, b, count + 1)
        if not exact:
            distance = (b - a) / count
            points = a + distance * np.arange(-2, count + 3)
        axes.append(points)
    return Raster(*axes)
