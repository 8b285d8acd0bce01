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

    def about(self, points: Reals, count: int | None = None) -> Reals:
        """Integrals as the first of `second`, of positions from points, (n, count, D)."""
        D, found = self.centre.shape[1], self.second[:, :count].copy()
        s = (self.centre - points)[:, :, None]
        A, M, T = self.area, self.moment, self.second
        for k, (i, j) in enumerate(_PAIRS[D - 1]):
            found[:, k] += s[:, i] * M[:, j] + s[:, j] * M[:, i] + s[:, i] * s[:, j] * A
        if found.shape[1] == 4:
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


#: Weight of the extent of a facet's box beside its products of inertia.
_BOX = 1e-6


def half_edges(elements: Elements, x: Reals, normal: Reals, size: Reals) -> Reals:
    """Half-edges of parallelograms with the second moments of flat elements, (n, 2, D).

    In 2D the second one is 0. Squares of components are not among the moments: in planes across an
    axis they are those of a rectangle with the greatest extent about the centroid in the box.

    Parameters
    ----------
    x, normal, size : (n, D) float64, (n, D) float64, (n,) float64
        Centroids, unit normals, areas.
    """
    n, D = x.shape
    found = np.zeros((n, 2, D))
    if D == 2:
        found[:, 0] = 0.5 * size[:, None] * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    if D < 3:
        return found
    row = np.arange(n)
    axis = np.argmin(np.round(np.abs(normal), 6), axis=1)
    along = np.sqrt(1.0 - normal[row, axis] ** 2)
    a = -normal * (normal[row, axis] / along)[:, None]
    a[row, axis] = along
    b = np.cross(normal, a)
    half = (elements.half - np.abs(x - elements.centre))[row, axis] / along
    half = np.maximum(half, 1e-3 * np.sqrt(size))
    box = np.stack([half**2, np.zeros(n), (0.25 * size / half) ** 2], axis=1) / 3.0
    area = elements.area
    products = (elements.about(x, 3) * area[:, None]).sum(axis=2)
    products /= (area * area).sum(axis=1)[:, None]
    pairs = [[a[:, i] * a[:, j], a[:, i] * b[:, j] + b[:, i] * a[:, j], b[:, i] * b[:, j]]
             for i, j in _PAIRS[2]]  # fmt: skip
    M = np.moveaxis(np.array(pairs), 2, 0)
    T = M.transpose(0, 2, 1)
    second = np.linalg.solve(
        T @ M + _BOX * np.eye(3), T @ products[:, :, None] + _BOX * box[:, :, None]
    )[:, :, 0]
    whole = np.maximum(second[:, 0], 0.0)
    skew = np.divide(second[:, 1], np.sqrt(whole), out=np.zeros(n), where=whole > 0.0)
    rest = np.sqrt(np.maximum(second[:, 2] - skew**2, 0.0))
    found[:, 0] = np.sqrt(3.0 * whole)[:, None] * a + (np.sqrt(3.0) * skew)[:, None] * b
    found[:, 1] = (np.sqrt(3.0) * rest)[:, None] * b
    return found
