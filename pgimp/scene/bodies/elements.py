"""Elements of a body's surface: area vectors and their first moments."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Indices = NDArray[np.int64]


#: Number of the products of the components, by dimensions.
PRODUCTS = (0, 1, 4)

#: Axes of the first of them.
_PAIRS: tuple[tuple[tuple[int, int], ...], ...] = ((), ((0, 1),), ((1, 2), (0, 2), (0, 1)))


class Elements(NamedTuple):
    """Elements of a surface."""

    box: Indices  #: (n, D) int64: The lattice boxes that they lie in, ascending.
    centre: Reals  #: (n, D) float64: Points to which moments refer.
    area: Reals  #: (n, D) float64: Area vectors, out of the body.
    #: (n, D, D) float64: Integrals of the position from `centre`, along the second index, times the
    #: normal.
    moment: Reals
    half: Reals  #: (n, D) float64: Half-sides of the boxes round their centres that they lie in.
    #: (n, 0, 1 or 4, D) float64: Likewise of products of its components: xy in 2D, yz, xz, xy, xyz
    #: in 3D; zeros but for bodies that are exact to their surface.
    second: Reals

    @classmethod
    def flat(cls, box: Indices, centre: Reals, area: Reals, half: Reals) -> Elements:
        """Elements across the axes, about their centroids."""
        n, D = centre.shape
        second = np.zeros((n, PRODUCTS[D - 1], D))
        return cls(box, centre, area, np.zeros((n, D, D)), half, second)

    def about(self, points: Reals) -> Reals:
        """Integrals as `second`, of positions from points, (n, 0, 1 or 4, D)."""
        D, found = self.centre.shape[1], self.second.copy()
        s = (self.centre - points)[:, :, None]
        A, M, T = self.area, self.moment, self.second
        for k, (i, j) in enumerate(_PAIRS[D - 1]):
            found[:, k] += s[:, i] * M[:, j] + s[:, j] * M[:, i] + s[:, i] * s[:, j] * A
        if D == 3:
            x, y, z = s[:, 0], s[:, 1], s[:, 2]
            found[:, 3] += x * T[:, 0] + y * T[:, 1] + z * T[:, 2] + x * y * z * A
            found[:, 3] += x * y * M[:, 2] + x * z * M[:, 1] + y * z * M[:, 0]
        return found

    @property
    def centroid(self) -> Reals:
        """Positions of the elements."""
        found, D = self.centre.copy(), self.centre.shape[1]
        square = sum(self.area[:, d] ** 2 for d in range(D))
        for j in range(D):
            away = sum(self.moment[:, j, d] * self.area[:, d] for d in range(D))
            found[:, j] += np.divide(away, square, out=np.zeros(len(found)), where=square > 0.0)
        return found

    def chosen(self, rows: NDArray[Any]) -> Elements:
        """Some of them, by a mask or in an order."""
        return Elements(*(each[rows] for each in self))
