"""Data from which fields of particles are computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray


class Source(NamedTuple):
    """Data from which fields are computed.

    Attributes
    ----------
    particles : Particles
        The rank's particles, in storage order with holes.
    rows : ndarray of int64, shape (n,)
        Storage indices of the selected particles.
    dimension : int
        Dimensions of the case: 1, 2 or 3.
    body_material : tuple of int
        The material of each body.
    rank : int
        The rank.
    periods : tuple of (float, float)
        Low end and period of the domain by direction, 0 where it is not periodic; () without any.
    plate : bool
        Whether the particles are parts of a plate, in plane stress.
    """

    particles: Any
    rows: Array
    dimension: int
    body_material: tuple[int, ...]
    rank: int = 0
    periods: tuple[tuple[float, float], ...] = ()
    plate: bool = False

    def take(self, symbol: str) -> Array:
        """Return the selected rows of an array of the particles: (n,) or (n, k)."""
        # Several times faster than indexing with the rows.
        return np.take(getattr(self.particles, symbol), self.rows, axis=0)

    @property
    def stretches(self) -> bool:
        """Whether F has a zz: the particles are rings, or parts of a plate."""
        return self.particles.F.shape[1] > self.dimension**2


def within(x: Array, periods: Sequence[tuple[float, float]]) -> Array:
    """Return positions (n, D) within a periodic domain, see `Source.periods`."""
    for d, (low, period) in enumerate(periods):
        if period > 0.0:
            x[:, d] -= np.floor((x[:, d] - low) / period) * period
    return x
