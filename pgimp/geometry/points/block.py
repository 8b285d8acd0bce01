"""A block of particles from a user's file, in the form common to both formats."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pgimp.geometry.points.saved import Saved

Reals = NDArray[np.float64]

#: Rows per block.
BLOCK = 200_000

#: Components of a symmetric tensor, and their number by dimension.
PAIRS = ("xx", "yy", "zz", "xy", "yz", "xz")
STRESS = {1: 3, 2: 4, 3: 6}

#: State variables of a material by name: whether they are symmetric tensors, else scalars.
States = Mapping[str, bool]


class Block(NamedTuple):
    """A block of particles, from row `first` on.

    Attributes
    ----------
    position, volume : (n, D) and (n,) float64
    velocity : (n, D) float64 or None
    stress : (n, 3, 4 or 6) float64 or None
        Components of the dimension, in the order xx, yy, zz, xy, yz, xz.
    gradient : (n, D * D) float64 or None
        Velocity gradient, row-major: dv_x/dx, dv_x/dy, ...
    states : dict of str to (n, k) float64
        State variables of the material, by name: scalars, or as many components as `stress`.
    lines : callable
        Gives the position of a row in the file as text, "row 0" or "line 2".
    columns : mapping of str to (n, ...) array
        The whole state, by the names of particles' columns; only of a run's own files.
    saved : Saved or None
        What such a file says of the body.
    """

    first: int
    position: Reals
    volume: Reals
    velocity: Reals | None
    stress: Reals | None
    gradient: Reals | None
    states: dict[str, Reals]
    lines: Any
    columns: Mapping[str, NDArray] = MappingProxyType({})
    saved: Saved | None = None

    def place(self, row: int) -> str:
        """Position of a row of the block in the file, as text."""
        return self.lines(row)

    def take(self, rows: NDArray[np.int64]) -> Block:
        """The block with only the given rows."""

        def of(values: Reals | None) -> Reals | None:
            return None if values is None else values[rows]

        return self._replace(
            position=self.position[rows],
            volume=self.volume[rows],
            velocity=of(self.velocity),
            stress=of(self.stress),
            gradient=of(self.gradient),
            states={name: values[rows] for name, values in self.states.items()},
            columns={name: values[rows] for name, values in self.columns.items()},
        )
