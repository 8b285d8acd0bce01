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
    """Grid of a checkpoint."""

    #: origin, cell, cells: Low corner of the domain, sides of a cell, number of cells.
    origin: tuple[float, ...]
    cell: tuple[float, ...]
    cells: tuple[int, ...]
    ghost: int  #: Vertices beyond a face.
    fields: tuple[int, ...]  #: Velocity field of each body.


class Saved(NamedTuple):
    """What a frame or a checkpoint says of one of its bodies."""

    checkpoint: bool  #: Whether it is a checkpoint.
    #: number, bodies: Number of the body, and how many there are.
    number: int
    bodies: int
    #: time, step: float, int: When it was written.
    time: float
    step: int
    inertia: float  #: Factor of mass scaling.
    #: dict of str to (int, int): First column and number of components of each state variable in a
    #: checkpoint.
    states: Mapping[str, tuple[int, int]]
    grid: VertexGrid | None  #: Of a checkpoint.

    @property
    def title(self) -> str:
        """Say what it is, and of when."""
        kind = "checkpoint" if self.checkpoint else "frame"
        return f"a {kind} of step {self.step}, t = {self.time:.6g}"


class Block(NamedTuple):
    """A block of particles, from row `first` on."""

    first: int
    #: position, volume: (n, D) and (n,) float64.
    position: Reals
    volume: Reals
    velocity: Reals | None  #: (n, D) float64 or None.
    #: (n, 3, 4 or 6) float64 or None: Components of the dimension, in the order xx, yy, zz, xy, yz,
    #: xz.
    stress: Reals | None
    #: (n, D * D) float64 or None: Velocity gradient, row-major: dv_x/dx, dv_x/dy, ...
    gradient: Reals | None
    #: dict of str to (n, k) float64: State variables of the material, by name: scalars, or as many
    #: components as `stress`.
    states: dict[str, Reals]
    lines: Any  #: callable: Gives the position of a row in the file as text, "row 0" or "line 2".
    #: mapping of str to (n, ...) array: The whole state, by the names of particles' columns; only
    #: of a run's own files.
    columns: Mapping[str, NDArray] = MappingProxyType({})
    saved: Saved | None = None  #: What such a file says of the body.

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
