"""The fraction of each lattice box that a body fills, in a part of the lattice."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ranges = list[tuple[int, int]]
Places = NDArray[np.int64]
Reals = NDArray[np.float64]


class VolumeFractions(NamedTuple):
    """Boxes of a part of the lattice that lie in a body.

    Attributes
    ----------
    ranges : list of (int, int)
        The part of the lattice: first box and end by direction; its boxes are numbered in C order.
    whole : bool, one for each box
        Boxes that lie inside entirely, except those of `places`.
    places : (n,) int64
        Numbers of boxes with a fraction other than 0 and 1, ascending.
    fractions : (n,) float64
        Volume of their parts inside, over that of a box.
    moments : (n, D) float64
        Integrals over their parts of the position relative to the box's centre, over the volume
        of a box.
    """

    ranges: Ranges
    whole: NDArray[np.bool_]
    places: Places
    fractions: Reals
    moments: Reals

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Boxes with a particle."""
        exists = self.whole.copy()
        exists[self.places] = True
        return exists

    def fraction(self, places: Places) -> Reals:
        """Fractions of the boxes with these numbers, (n,)."""
        return self._take(places, self.whole[places].astype(float), self.fractions)

    def moment(self, places: Places) -> Reals:
        """Moments of the boxes with these numbers, (n, D)."""
        return self._take(places, np.zeros((len(places), self.moments.shape[1])), self.moments)

    def _take(self, places: Places, values: Reals, special: Reals) -> Reals:
        """Replace the values of boxes that are in `places`."""
        if len(self.places):
            at = np.minimum(np.searchsorted(self.places, places), len(self.places) - 1)
            found = self.places[at] == places
            values[found] = special[at[found]]
        return values
