"""When a quantity that is written over time counts: at the end, at its largest, at a time."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pgimp.schema.base import Model, NonNegative, Positive
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems


class TimeMean(Model):
    """A mean over time."""

    mean: tuple[NonNegative, Positive] = Field(
        description="simulated times between which a column is averaged, by the trapezoidal rule "
        "over the lines [time]"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.mean[0] < self.mean[1]:
            text = f"expected a time after {self.mean[0]:.15g}, got {self.mean[1]:.15g}"
            raise_problems("mean", [Problem(("mean", 1), text)])
        return self


At = Annotated[
    str | float | TimeMean,
    Either(
        "end, max, a time or {mean: [FROM, TO]}",
        {str: Literal["end", "max"], float: NonNegative, dict: TimeMean},
    ),
]
"""End, max, a time or a mean, as a case or a study writes it."""

AT = (
    "end: the last line; max: the largest of all lines; a number: the first line "
    "at or after that simulated time; {mean: [1.0, 2.0]}: the mean between two times"
)
"""What these are, for descriptions."""


def last_of(at: str | float | TimeMean) -> float:
    """Return the last time that is needed; 0 if any end will do."""
    at = at.mean[1] if isinstance(at, TimeMean) else at
    return at if isinstance(at, float) else 0.0


def label_of(at: str | float | TimeMean) -> str:
    """Return what follows the name of a column: nothing for the end, ``@max``, ``@1..2``."""
    if isinstance(at, TimeMean):
        return f"@{at.mean[0]:g}..{at.mean[1]:g}"
    return "" if at == "end" else f"@{at}"
