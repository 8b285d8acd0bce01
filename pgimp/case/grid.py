"""The grid: its entry in the case."""

from __future__ import annotations

from pydantic import Field

from pgimp.physics.loads.motion import zero_vector
from pgimp.schema.base import Model, Positive, Vector
from pgimp.schema.sizes import whole


class Grid(Model):
    """Regular grid; its faces are the boundary of the domain."""

    origin: Vector = zero_vector("low corner of the domain [length]")
    size: tuple[Positive, ...] = Field(
        min_length=1,
        max_length=3,
        description="extent of the domain along each direction, whole cells [length]",
    )
    cell: tuple[Positive, ...] = Field(
        min_length=1, max_length=3, description="size of a cell along each direction [length]"
    )

    @property
    def cells(self) -> tuple[int, ...]:
        """Number of cells along each direction."""
        return tuple(whole(size, cell)[0] for size, cell in zip(self.size, self.cell, strict=True))

    @property
    def corner(self) -> tuple[float, ...]:
        """High corner of the domain [length]."""
        return tuple(low + size for low, size in zip(self.origin, self.size, strict=True))
