"""Fields of particles: their declaration, and the data from which they are computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray

#: Components of a symmetric tensor.
TENSOR = "xx yy zz xy yz xz"


class Fills(NamedTuple):
    """What each body's particles fill at most: without the voids of what flows."""

    most: Array  #: (bodies,) float64: Greatest J without voids; infinite where there is no limit.
    #: (bodies,) int64: State column of the gap by which a particle has opened; -1 for others.
    gap: Array


class Source(NamedTuple):
    """Data from which fields are computed."""

    particles: Any  #: Particles: The rank's particles, in storage order with holes.
    rows: Array  #: ndarray of int64, shape (n,): Storage indices of the selected particles.
    dimension: int  #: Dimensions of the case: 1, 2 or 3.
    body_material: tuple[int, ...]  #: The material of each body.
    rank: int = 0
    #: tuple of (float, float): Low end and period of the domain by direction, 0 where it is not
    #: periodic; () without any.
    periods: tuple[tuple[float, float], ...] = ()
    plate: bool = False  #: Whether the particles are parts of a plate, in plane stress.
    #: Takes particles and rows; returns the strain energy per initial volume.
    energy: Callable[[Any, Array], Array] | None = None
    #: Columns of the selected particles in place of those of `particles`.
    instead: Mapping[str, Array] = MappingProxyType({})
    fills: Fills | None = None  #: Voids that do not count in volumes; None if there are none.

    def take(self, symbol: str) -> Array:
        """Return the selected rows of an array of the particles: (n,) or (n, k)."""
        if symbol in self.instead:
            return self.instead[symbol].copy()
        # Several times faster than indexing with the rows.
        return np.take(getattr(self.particles, symbol), self.rows, axis=0)

    def energies(self) -> Array:
        """Return the strain energy per initial volume of the selected particles, (n,)."""
        assert self.energy is not None
        if not self.instead:
            return self.energy(self.particles, self.rows)
        own = self.particles._replace(**{name: self.take(name) for name in self.particles._fields})
        return self.energy(own, np.arange(len(self.rows)))

    @property
    def stretches(self) -> bool:
        """Whether F has a zz: the particles are rings, or parts of a plate."""
        return self.particles.F.shape[1] > self.dimension**2


def volume(source: Source) -> Array:
    """Return the volume without voids; an area in 2D but of rings and plates, a length in 1D."""
    V = source.take("V")
    if source.fills is None:
        return V
    own = source.take("body")
    V = np.minimum(V, source.fills.most[own] * source.take("V0"))
    gap = source.fills.gap[own]
    opened = np.flatnonzero(gap >= 0)
    V[opened] *= np.exp(-source.take("state")[opened, gap[opened]])
    return V


def within(x: Array, periods: Sequence[tuple[float, float]]) -> Array:
    """Return positions (n, D) within a periodic domain, see `Source.periods`."""
    for d, (low, period) in enumerate(periods):
        if period > 0.0:
            x[:, d] -= np.floor((x[:, d] - low) / period) * period
    return x


class Field(NamedTuple):
    """A quantity of a particle: its function, meaning and format in frames."""

    #: Takes a `Source`; returns an array of shape (n,) or (n, columns).
    values: Callable[[Source], Array]
    meaning: str  #: With the unit in square brackets where there is one.
    components: str = ""  #: Names of the components in order; empty for a scalar.
    kind: str = "Scalar"  #: The attribute type that XDMF readers need.
    dtype: str = "<f8"  #: Type in the file.

    @property
    def columns(self) -> int:
        """Number of components; 0 for a scalar."""
        return len(self.components.split())
