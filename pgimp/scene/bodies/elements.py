"""Elements of a body's surface: area vectors and their first moments."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Indices = NDArray[np.int64]


class Elements(NamedTuple):
    """Elements of a surface."""

    box: Indices  #: (n, D) int64: The lattice boxes that they lie in, ascending.
    centre: Reals  #: (n, D) float64: Points to which moments refer.
    area: Reals  #: (n, D) float64: Area vectors, out of the body.
    #: (n, D, D) float64: Integrals of the position from `centre`, along the second index, times the
    #: normal.
    moment: Reals
    half: Reals  #: (n, D) float64: Half-sides of the boxes round their centres that they lie in.

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
