"""A block of particles from a user's file, in the form common to both formats."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]

#: Rows per block.
BLOCK = 200_000

#: Components of a symmetric tensor, and their number by dimension.
PAIRS = ("xx", "yy", "zz", "xy", "yz", "xz")
STRESS = {1: 3, 2: 4, 3: 6}

#: State variables of a material by name: whether they are symmetric tensors, else scalars.
States = Mapping[str, bool]


class VertexGrid(NamedTuple):
    """Grid of a checkpoint.

    Attributes
    ----------
    origin, cell, cells : tuples
        Low corner of the domain, sides of a cell, number of cells.
    ghost : int
        Vertices beyond a face.
    fields : tuple of int
        Velocity field of each body.
    """

    origin: tuple[float, ...]
    cell: tuple[float, ...]
    cells: tuple[int, ...]
    ghost: int
    fields: tuple[int, ...]


class Saved(NamedTuple):
    """What a frame or a checkpoint says of one of its bodies.

    Attributes
    ----------
    checkpoint : bool
        Whether it is a checkpoint.
    number, bodies : int, int
        Number of the body, and how many there are.
    time, step : float, int
        When it was written.
    inertia : float
        Factor of mass scaling.
    states : dict of str to (int, int)
        First column and number of components of each state variable in a checkpoint.
    grid : VertexGrid or None
        Of a checkpoint.
    """

    checkpoint: bool
    number: int
    bodies: int
    time: float
    step: int
    inertia: float
    states: Mapping[str, tuple[int, int]]
    grid: VertexGrid | None

    @property
    def title(self) -> str:
        """Say what it is, and of when."""
        kind = "checkpoint" if self.checkpoint else "frame"
        return f"a {kind} of step {self.step}, t = {self.time:.6g}"


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
