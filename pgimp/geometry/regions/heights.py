"""The ground below a grid of heights: terrain, closed by sides and a bottom."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field, model_validator

from pgimp.errors import CaseError
from pgimp.geometry.regions.enclosed import Enclosed
from pgimp.schema.base import Model, Number, Positive, Vector
from pgimp.schema.paths import FileName
from pgimp.schema.problems import Problem, raise_problems

if TYPE_CHECKING:
    from pgimp.geometry.mesh.tree import Surface


class Nodes(Model):
    """Where the nodes of an array are."""

    origin: Vector = Field(description="place of the first node: x, in 3D x and y [length]")
    spacing: tuple[Positive, ...] = Field(
        min_length=1, max_length=2, description="distance of the nodes likewise [length]"
    )


class Part(Model):
    """A part of a grid of heights."""

    min: Vector = Field(description="low end: x, in 3D x and y [length]")
    max: Vector = Field(description="high end likewise, above min [length]")

    @model_validator(mode="after")
    def _ordered(self) -> Part:
        if len(self.min) == len(self.max):
            raise_problems(
                "part",
                [
                    Problem(("max", i), f"must be above min, {low:.15g}, got {high:.15g}")
                    for i, (low, high) in enumerate(zip(self.min, self.max, strict=True))
                    if not low < high
                ],
            )
        return self


class Heights(Enclosed):
    """Ground below a grid of heights (ESRI ASCII or an array of NumPy), down to a bottom."""

    WHAT: ClassVar[str] = "the heights"

    file: FileName = Field(
        description="file of the heights, from the folder of the case: .asc (ESRI ASCII) or .npy, "
        "an array by x, in 3D by x and y, with `nodes`; in 2D also rows of x and height"
    )
    scale: Positive = Field(
        default=1.0, description="factor of all lengths, such as 0.3048 from feet to m [1]"
    )
    bottom: Number = Field(
        description="where the ground ends below, in the coordinates of the case [length]"
    )
    nodes: Nodes | None = Field(
        default=None, description="where the nodes of an array are; null: the file says it"
    )
    window: Part | None = Field(
        default=None,
        description="what of it is taken, in the coordinates of the case; null: all, of an .asc to "
        "the edges of its cells, of an array from the first to the last node",
    )
    translate: Vector | None = Field(
        default=None,
        description="displacement, after scaling, such as from a survey's coordinates; null: none "
        "[length]",
    )

    def misfits(self, dimensions: int) -> Iterator[tuple[tuple[str, ...], str]]:
        """See `Region.misfits`."""
        horizontal = dimensions - 1
        for key in ("nodes", "window"):
            entry = getattr(self, key)
            for name in type(entry).model_fields if entry is not None else ():
                if len(getattr(entry, name)) != horizontal:
                    what = "x" if horizontal == 1 else "x and y"
                    yield (key, name), f"expected {what}, got {list(getattr(entry, name))}"

    @cached_property
    def surface(self) -> Surface:
        """See `Enclosed.surface`."""
        from pgimp.geometry.terrain.close import ground_below, part_of
        from pgimp.geometry.terrain.read import Heights as Grid
        from pgimp.geometry.terrain.read import read_heights

        horizontal = self.dimensions - 1
        origin, spacing = (self.nodes.origin, self.nodes.spacing) if self.nodes else (None, None)
        move = np.zeros(self.dimensions) if self.translate is None else self.translate
        ends: list[tuple[float, float] | None] = [None, None]
        if self.window is not None:
            for d, pair in enumerate(zip(self.window.min, self.window.max, strict=True)):
                low, high = ((end - move[d]) / self.scale for end in pair)
                ends[d] = low, high
        try:
            found = read_heights(self.file, horizontal, origin, spacing, ends)
            axes = [self.scale * x + dx for x, dx in zip(found.axes, move[:-1], strict=True)]
            found = Grid(tuple(axes), self.scale * found.values + move[-1])
            if self.window is not None:
                found = part_of(found, self.window.min, self.window.max)
            return ground_below(found, self.bottom)
        except CaseError as error:
            named = f"{error}".startswith("cannot read ")  # with the file
            raise CaseError(f"{error}" if named else f"{self.WHAT} {self.file} {error}") from None
