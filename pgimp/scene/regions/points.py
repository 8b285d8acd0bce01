"""The user's own particles in place of those of the lattice.

Ids follow the rows. Masses are density times volume. For the shapes that have a size, all particles
of a case start with that of the lattice, from `particles_per_cell`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pgimp.case.base import Model
from pgimp.case.paths import FileName
from pgimp.errors import CaseError
from pgimp.scene.pointsfile import Block, blocks
from pgimp.scene.regions.base import Bounds, Lengths, Mask, Plane, Region
from pgimp.scene.regions.base import Points as Positions


class Summary(NamedTuple):
    """What is known of a file of particles without its rows."""

    number: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    volume: float
    least: float
    most: float
    velocity: bool
    stress: bool


class Points(Model, Region):
    """Particles from a file; their size, where the shape has one, is as on the lattice."""

    FROM_FILE: ClassVar[bool] = True
    WHOLE_BODY: ClassVar[bool] = True

    file: FileName = Field(
        description="file of the particles, from the folder of the case: .csv with a line of names "
        "(x,y,z,volume,velocity-x,...,stress-xx,...), or .h5 with datasets position, volume, "
        "velocity, stress"
    )

    def belong(self, dimensions: int) -> None:
        """See `Region.belong`."""
        self.__dict__["dimensions_of_case"] = dimensions

    @property
    def dimensions(self) -> int:
        """Directions of the case."""
        return self.__dict__.get("dimensions_of_case", 3)

    def nothing(self) -> Summary:
        """Return what stands for the file where its particles exist already."""
        D = self.dimensions
        return Summary(0, (np.inf,) * D, (-np.inf,) * D, 0.0, 0.0, 0.0, False, False)

    @cached_property
    def summary(self) -> Summary:
        """What the file holds; it is read once, block by block, and checked.

        Raises
        ------
        CaseError
            If it cannot be read, or a row is no particle.
        """
        D = self.dimensions
        count, volume = 0, 0.0
        low, high = np.full(D, np.inf), np.full(D, -np.inf)
        least, most = np.inf, 0.0
        velocity = stress = False
        for block in blocks(self.file, D):
            self._check(block)
            count += len(block.volume)
            volume += float(block.volume.sum())
            low = np.minimum(low, block.position.min(axis=0))
            high = np.maximum(high, block.position.max(axis=0))
            least, most = min(least, block.volume.min()), max(most, block.volume.max())
            velocity, stress = block.velocity is not None, block.stress is not None
        if not count:
            raise CaseError(f"the file {self.file} holds no particle")
        ends = tuple(low.tolist()), tuple(high.tolist())
        return Summary(count, *ends, volume, float(least), float(most), velocity, stress)

    def _check(self, block: Block) -> None:
        """Refuse what is no particle, with its row."""
        columns = (
            ("position", block.position),
            ("volume", block.volume),
            ("velocity", block.velocity),
            ("stress", block.stress),
        )
        for what, values in columns:
            if values is None:
                continue
            sound = np.isfinite(values.reshape(len(block.volume), -1)).all(axis=1)
            if not sound.all():
                row = int(np.argmin(sound))
                raise CaseError(
                    f"the particles {self.file}: {block.place(row)}: the {what} is not finite"
                )
        if not (block.volume > 0.0).all():
            row = int(np.argmin(block.volume > 0.0))
            raise CaseError(
                f"the particles {self.file}: {block.place(row)}: the volume must be above zero, "
                f"is {block.volume[row]:g}"
            )

    def chosen(self, which: Callable[[Lengths], Mask]) -> Iterator[tuple[NDArray, Block]]:
        """Yield the particles whose coordinate along x is wanted, with their rows in the file."""
        for block in blocks(self.file, self.dimensions):
            rows = np.flatnonzero(which(np.ascontiguousarray(block.position[:, 0])))
            if len(rows):
                yield (
                    block.first + rows,
                    block._replace(
                        position=block.position[rows],
                        volume=block.volume[rows],
                        velocity=None if block.velocity is None else block.velocity[rows],
                        stress=None if block.stress is None else block.stress[rows],
                    ),
                )

    def line(self, row: int) -> str:
        """Say where in the file a row stands; empty if it is there no more."""
        for block in blocks(self.file, self.dimensions):
            if row < block.first + len(block.volume):
                return block.place(row - block.first)
        return ""

    def at(self, axis: int, reach: float) -> str:
        """See `Region.at`; the file is read once more."""
        for block in blocks(self.file, self.dimensions):
            rows = np.flatnonzero(block.position[:, axis] == reach)
            if len(rows):
                x = ", ".join(f"{value:.6g}" for value in block.position[rows[0]])
                return f"the particle at ({x}), {block.place(int(rows[0]))} of {self.file}"
        return ""

    def bounds(self) -> Bounds:
        """See `Region.bounds`; of the particles' positions."""
        return self.summary.low, self.summary.high

    def contains(self, points: Positions) -> Mask:
        """See `Region.contains`; nowhere: particles alone have no inside."""
        return np.zeros(len(points), bool)

    def distance(self, points: Positions) -> Lengths:
        """See `Region.distance`."""
        return np.full(len(points), np.inf)

    def curved(self, points: Positions) -> Lengths:
        """See `Region.curved`."""
        return np.full(len(points), np.inf)

    def planes(self) -> list[Plane]:
        """See `Region.planes`."""
        return []

    def crossings(self, points: Positions, axis: int) -> Lengths:
        """See `Region.crossings`."""
        return np.zeros((len(points), 0))

    def facts(self) -> list[str]:
        """See `Region.facts`."""
        found = self.summary

        def place(x: tuple[float, ...]) -> str:
            return "(" + ", ".join(f"{value:.6g}" for value in x) + ")"

        more = [name for name in ("velocity", "stress") if getattr(found, name)]
        given = f"; with {' and '.join(more)}" if more else ""
        return [
            f"{found.number:,} particles of a file, from {place(found.low)} to "
            f"{place(found.high)}, volume {found.volume:.6g}, of one {found.least:.4g} to "
            f"{found.most:.4g}{given}"
        ]
