"""Volume fractions of a body in the boxes of a part of the lattice."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ranges = list[tuple[int, int]]
Indices = NDArray[np.int64]
Reals = NDArray[np.float64]


class VolumeFractions(NamedTuple):
    """Volume fractions and moments of a body in the boxes of a part of the lattice."""

    #: list of (int, int): The part of the lattice: first box and end by direction; its boxes are
    #: numbered in C order.
    ranges: Ranges
    #: bool, one for each box: Boxes that lie entirely inside, except the boxes in `indices`.
    whole: NDArray[np.bool_]
    indices: Indices  #: (n,) int64: Numbers of boxes with a fraction other than 0 and 1, ascending.
    fractions: Reals  #: (n,) float64: Volume of their parts inside, over the volume of a box.
    #: (n, D or more) float64: Integrals over their parts of the position relative to the box's
    #: centre, over the volume of a box. Of bodies that are exact to their surface also of its
    #: components' products.
    moments: Reals

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Mask of the boxes with a particle."""
        exists = self.whole.copy()
        exists[self.indices] = True
        return exists

    def fraction(self, indices: Indices) -> Reals:
        """Volume fractions of the boxes with these numbers, (n,)."""
        return self._take(indices, self.whole[indices].astype(float), self.fractions)

    def moment(self, indices: Indices) -> Reals:
        """Moments of the boxes with these numbers, (n, D)."""
        D = len(self.ranges)
        return self._take(indices, np.zeros((len(indices), D)), self.moments[:, :D])

    def products(self, indices: Indices) -> Reals:
        """Products of inertia of the boxes with these numbers about their centroids.

        They are means over a box's part, (n, 0, 1 or 4): of xy in 2D, of yz, xz, xy, xyz in 3D.
        """
        D = len(self.ranges)
        means = (
            self._take(indices, np.zeros((len(indices), self.moments.shape[1])), self.moments)
            / self.fraction(indices)[:, None]
        )
        c, found = means[:, :D].T, means[:, D:]
        if D == 1:
            return found
        if D == 2:
            found[:, 0] -= c[0] * c[1]
            return found
        x, y, z = c
        found[:, 3] -= x * found[:, 0] + y * found[:, 1] + z * found[:, 2] - 2.0 * x * y * z
        found[:, :3] -= np.stack([y * z, x * z, x * y], axis=1)
        return found

    def ring_products(self, indices: Indices, r: Reals, width: float) -> Reals:
        """Products of inertia of the rings with the boxes with these numbers as sections, (n, 3).

        A mean of x y about the mass's centroid. Then the distances along both directions from the
        section's centroid to the mass's.

        Parameters
        ----------
        r : (n,) float64
            Radii of the boxes' centres.
        width : float
            Of a box, along the radius.
        """
        whole = np.zeros((len(indices), 5))
        whole[:, 3] = width * width / 12.0
        means = self._take(indices, whole, self.moments) / self.fraction(indices)[:, None]
        x, y, xy, xx, xxy = means.T
        xxy = xxy - y * xx - 2.0 * x * xy + 2.0 * x * x * y
        xy, xx, centroid = xy - x * y, xx - x * x, r + x
        out, along = xx / centroid, xy / centroid
        return np.stack([xy + xxy / centroid - out * along, out, along], axis=1)

    def part(self, ranges: Ranges) -> "VolumeFractions":
        """The same in another part of the lattice; boxes outside of this one are empty."""
        shape, first = tuple(end - begin for begin, end in ranges), [begin for begin, _ in ranges]
        whole = np.zeros(shape, bool)
        here, there = [], []
        for (a, b), (begin, end) in zip(self.ranges, ranges, strict=True):
            low, high = max(a, begin), max(a, begin, min(b, end))
            here.append(slice(low - a, high - a))
            there.append(slice(low - begin, high - begin))
        size = tuple(b - a for a, b in self.ranges)
        whole[tuple(there)] = self.whole.reshape(size)[tuple(here)]
        index = np.array(np.unravel_index(self.indices, size))
        index += np.array([[a - begin] for (a, _), begin in zip(self.ranges, first, strict=True)])
        kept = ((index >= 0) & (index < np.array(shape)[:, None])).all(axis=0)
        indices = np.ravel_multi_index(tuple(index[:, kept]), shape)
        return VolumeFractions(
            ranges, whole.reshape(-1), indices, self.fractions[kept], self.moments[kept]
        )

    def _take(self, indices: Indices, values: Reals, special: Reals) -> Reals:
        """Values of boxes, with special values for the boxes in `indices`."""
        if len(self.indices):
            at = np.minimum(np.searchsorted(self.indices, indices), len(self.indices) - 1)
            found = self.indices[at] == indices
            values[found] = special[at[found]]
        return values
