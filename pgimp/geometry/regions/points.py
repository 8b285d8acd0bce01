"""The user's own particles in place of lattice particles.

Ids follow the rows. Masses are density times volume. If the shape has a size, all particles of a
case start with the lattice's, from `particles-per-cell`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pgimp.errors import CaseError
from pgimp.geometry.points.block import PAIRS, Block, Saved, States
from pgimp.geometry.points.file import blocks
from pgimp.geometry.points.saved import Wanted
from pgimp.geometry.regions.base import Bounds, Lengths, Mask, Plane, Region
from pgimp.geometry.regions.base import Points as Positions
from pgimp.schema.base import Model, Name
from pgimp.schema.paths import FileName

#: Mean stress, over the greatest stress of a file, below which it is rounding.
_ROUNDING = 1e-9


class Summary(NamedTuple):
    """Summary of a file of particles, without its rows.

    `means` are the means of the first components of `states`. Of a run's own file, `saved` is what
    it says of the body, and `lowest` the lowest id if the ids have no gap, else -1.
    """

    number: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    volume: float
    least: float
    most: float
    velocity: bool
    stress: bool
    gradient: bool
    states: tuple[str, ...]
    means: tuple[float, ...] = ()
    lowest: int = -1
    saved: Saved | None = None


class Points(Model, Region):
    """Particles from a file; their size, where the shape has one, is as on the lattice."""

    FROM_FILE: ClassVar[bool] = True
    WHOLE_BODY: ClassVar[bool] = True

    file: FileName = Field(
        description="file of the particles, from the folder of the case: .csv with a line of names "
        "(x,y,z,volume,velocity-x,...,stress-xx,...,velocity-gradient-xx,...), or .h5 with "
        "datasets position, volume, velocity, stress, velocity-gradient, or .vtu or .vtp of VTK "
        "with such arrays at its points; all also with the state variables of the body's "
        "material, and with columns that its parameters are to be taken from, by their names; or "
        "a frame (frames/particles-*.h5) or a checkpoint (checkpoints/step-*.h5) of a run, from "
        "whose whole state the body goes on"
    )
    body: Name | None = Field(
        default=None,
        description="body of a frame or a checkpoint to go on with; by default the one of the same "
        "name, or the only one",
    )

    def belong(self, dimensions: int) -> None:
        """See `Region.belong`."""
        self.__dict__["dimensions_of_case"] = dimensions

    @property
    def dimensions(self) -> int:
        """Directions of the case."""
        return self.__dict__.get("dimensions_of_case", 3)

    def expect(self, states: States, wanted: Wanted | None = None) -> None:
        """Set what the file may have: columns by name, or the whole state that a body needs."""
        self.__dict__["states_of_material"], self.__dict__["wanted"] = states, wanted

    def _blocks(self, most: int | None = None) -> Iterator[Block]:
        states = self.__dict__.get("states_of_material")
        return blocks(self.file, self.dimensions, most, states, self.__dict__.get("wanted"))

    def nothing(self) -> Summary:
        """Return the summary in place of the file if its particles exist already."""
        D = self.dimensions
        return Summary(0, (np.inf,) * D, (-np.inf,) * D, 0.0, 0.0, 0.0, False, False, False, ())

    @cached_property
    def summary(self) -> Summary:
        """Summary of the file, see `read`."""
        return self.read()

    def read(self, most: int | None = None) -> Summary:
        """Read the file once, block by block, and check it.

        Parameters
        ----------
        most : int, optional
            Particles that memory can hold.

        Raises
        ------
        CaseError
            If it cannot be read, has more than `most` particles, or a row is no particle.
        """
        D = self.dimensions
        count, volume = 0, 0.0
        low, high = np.full(D, np.inf), np.full(D, -np.inf)
        least, largest = np.inf, 0.0
        velocity = stress = gradient = False
        states: tuple[str, ...] = ()
        sums: Lengths = np.zeros(0)
        (first, last), saved = (2**62, -1), None
        for block in self._blocks(most):
            self._check(block)
            count += len(block.volume)
            volume += float(block.volume.sum())
            low = np.minimum(low, block.position.min(axis=0))
            high = np.maximum(high, block.position.max(axis=0))
            least, largest = min(least, block.volume.min()), max(largest, block.volume.max())
            velocity, stress = block.velocity is not None, block.stress is not None
            gradient, states = block.gradient is not None, tuple(block.states)
            if saved := block.saved:
                ids = block.columns["id"]
                first, last = min(first, int(ids.min())), max(last, int(ids.max()))
            sums = np.array([table[:, 0].sum() for table in block.states.values()]) + (
                sums if len(sums) else 0.0
            )
        if not count:
            raise CaseError(f"the file {self.file} holds no particle")
        if gradient and not velocity:
            raise CaseError(
                f"the particles {self.file} have a velocity gradient, but no velocity; give both"
            )
        ends = tuple(low.tolist()), tuple(high.tolist())
        sizes = float(least), float(largest)
        means = tuple((sums / count).tolist())
        found = Summary(count, *ends, volume, *sizes, velocity, stress, gradient, states, means)
        lowest = first if last - first + 1 == count else -1
        return found._replace(lowest=lowest, saved=saved)

    def _check(self, block: Block) -> None:
        """Refuse rows that are no particles, with the row."""
        columns = [
            ("position", block.position),
            ("volume", block.volume),
            ("velocity", block.velocity),
            ("stress", block.stress),
            ("velocity gradient", block.gradient),
        ]
        for name, table in block.states.items():
            names = [name] if table.shape[1] == 1 else [f"{name}-{pair}" for pair in PAIRS]
            columns += zip(names, table.T, strict=False)
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

    def chosen(self, which: Callable[[Block], Mask]) -> Iterator[tuple[NDArray, Block]]:
        """Yield selected particles, with their rows in the file, or among those of the body."""
        for block in self._blocks():
            rows = np.flatnonzero(which(block))
            if len(rows):
                yield block.first + rows, block.take(rows)

    def mean_stress(self, tension: bool = False) -> tuple[str, float] | None:
        """Name the first particle with a mean stress, and its value; the file is read again.

        With `tension` only means above 0 count.
        """
        most = 0.0
        for block in self._blocks():
            if block.stress is not None:
                most = max(most, np.abs(block.stress).max())
        for block in self._blocks():
            if block.stress is not None:
                means = block.stress[:, :3].mean(axis=1)
                rows = np.flatnonzero((means if tension else np.abs(means)) > _ROUNDING * most)
                if len(rows):
                    return self._named(block, int(rows[0])), float(means[rows[0]])
        return None

    def below(self, state: str, least: float) -> tuple[str, float] | None:
        """Name the first particle with a state below `least`, and its value; rereads the file."""
        for block in self._blocks():
            values = block.states[state][:, 0]
            rows = np.flatnonzero(values < least)
            if len(rows):
                return self._named(block, int(rows[0])), float(values[rows[0]])
        return None

    def _named(self, block: Block, row: int) -> str:
        """Name a particle by its position, and by its row in the file."""
        x = ", ".join(f"{value:.6g}" for value in block.position[row])
        return f"the particle at ({x}), {block.place(row)} of {self.file}"

    def lines(self, rows: Sequence[int]) -> list[str]:
        """Positions of ascending rows in the file, as text; fewer if the file is now shorter."""
        found: list[str] = []
        for block in self._blocks():
            while len(found) < len(rows) and rows[len(found)] < block.first + len(block.volume):
                found.append(block.place(rows[len(found)] - block.first))
            if len(found) == len(rows):
                break
        return found

    def at(self, axis: int, reach: float) -> str:
        """See `Region.at`; the file is read once more."""
        for block in self._blocks():
            rows = np.flatnonzero(block.position[:, axis] == reach)
            if len(rows):
                return self._named(block, int(rows[0]))
        return ""

    def bounds(self) -> Bounds:
        """See `Region.bounds`; for the particles' positions."""
        return self.summary.low, self.summary.high

    def contains(self, points: Positions) -> Mask:
        """See `Region.contains`; nowhere, as particles have no inside."""
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

        if found.saved:
            return [
                f"{found.number:,} particles, mass and whole state, of {found.saved.title}; from "
                f"{place(found.low)} to {place(found.high)}, volume {found.volume:.6g}"
            ]
        names = {"velocity": "velocity", "stress": "stress", "gradient": "velocity gradient"}
        more = [name for key, name in names.items() if getattr(found, key)]
        more += found.states
        given = f"; with {', '.join(more)}" if more else ""
        return [
            f"{found.number:,} particles of a file, from {place(found.low)} to "
            f"{place(found.high)}, volume {found.volume:.6g}, of one {found.least:.4g} to "
            f"{found.most:.4g}{given}"
        ]
