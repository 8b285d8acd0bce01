"""A parameter from a column of a file of particles."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from pgimp.physics.variation.base import Places, Reals, Variation


class FromColumn(Variation):
    """A column of the file of particles that the body is made of."""

    column: Annotated[str, StringConstraints(strict=True, pattern=r"^[a-z][a-z0-9_-]{0,99}$")] = (
        Field(
            description="name of a column (or dataset) of the body's `points`, in small letters: "
            "each particle's value"
        )
    )

    @property
    def columns(self) -> list[str]:
        """See `Variation`."""
        return [self.column]

    def learn(self, mean: float) -> None:
        """Set the mean of the column."""
        self.__dict__["mean"] = mean

    def release(self) -> None:
        """See `Variation`."""
        self.__dict__.pop("mean", None)

    def _typical(self) -> float | None:
        return self.__dict__.get("mean")

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        return places.columns[self.column]
