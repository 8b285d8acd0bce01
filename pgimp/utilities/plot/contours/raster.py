"""Lattices of points over a body, in the plane of a picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Array = np.ndarray

_MOST = 1500


class Raster(NamedTuple):
    """Points in rows and columns.

    Attributes
    ----------
    x, y : ndarray, shape (columns,) and (rows,)
        Coordinates in the picture, equally spaced.
    """

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

    def windows(self, centre: Array, reach: Array) -> list[tuple[Array, Array, Array]]:
        """Find the points around particles.

        Parameters
        ----------
        centre, reach : ndarray, shape (n, 2)
            Centres, and how far the windows go to either side.

        Returns
        -------
        list of (rows, column, row)
            Particles with windows of about the same size, (m,), and of the points of each the
            column and row, (m, k); some are beyond the raster.
        """
        first = np.ceil((centre - reach - self.low) / self.step).astype(np.int64)
        last = np.floor((centre + reach - self.low) / self.step).astype(np.int64)
        first = np.maximum(first, 0)
        count = np.minimum(last, np.array(self.shape[::-1]) - 1) - first + 1
        size = np.where((count > 0).all(axis=1)[:, None], 2 * ((count + 1) // 2), 0)
        found = []
        for wide, high in np.unique(size, axis=0):
            rows = np.flatnonzero((size == (wide, high)).all(axis=1))
            if wide and len(rows):
                column = first[rows, 0, None] + np.tile(np.arange(wide), high)
                row = first[rows, 1, None] + np.repeat(np.arange(high), wide)
                found.append((rows, column, row))
        return found

    def add(self, sums: Array, column: Array, row: Array, values: Array) -> None:
        """Add values at points to sums, of shape (rows columns,); beyond the raster none."""
        inside = (column < len(self.x)) & (row < len(self.y))
        place = (row * len(self.x) + column)[inside]
        sums += np.bincount(place, values[inside], len(sums))


def raster(low: Array, high: Array, step: Array, fixed: Array) -> Raster:
    """Return a raster that covers a rectangle.

    Parameters
    ----------
    low, high, step : ndarray, shape (2,)
        Its corners; the wanted distances of points, larger where there would be too many.
    fixed : ndarray of bool, shape (2,)
        Directions in which it begins and ends at the corners: those of periodic faces. In the
        others it goes two points beyond.
    """
    axes = []
    for a, b, distance, exact in zip(low, high, step, fixed, strict=True):
        count = max(1, int(np.ceil((b - a) / max(distance, (b - a) / _MOST, 1e-300))))
        points = np.linspace(a, b, count + 1)
        if not exact:
            distance = (b - a) / count
            points = a + distance * np.arange(-2, count + 3)
        axes.append(points)
    return Raster(*axes)
