"""Measures of a study file: numbers taken from the history of a run."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from pgimp.schema.base import Model, NonNegative, Number, Positive, one_line
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems

LIMIT = "limit"
"""The reference that is extrapolated from the runs."""

Text = Annotated[
    str, StringConstraints(strict=True, min_length=1, max_length=1000), AfterValidator(one_line)
]


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


class Measure(Model):
    """A number taken from the history of a run."""

    column: Text = Field(description="a column of history.csv")
    at: Annotated[
        str | float | TimeMean,
        Either(
            "end, max, a time or {mean: [FROM, TO]}",
            {str: Literal["end", "max"], float: NonNegative, dict: TimeMean},
        ),
    ] = Field(
        default="end",
        description="end: the last line; max: the largest of all lines; a number: the first line "
        "at or after that simulated time; {mean: [1.0, 2.0]}: the mean between two times",
    )
    reference: Annotated[
        float | str, Either("a number or limit", {float: Number, str: Literal["limit"]})
    ] = Field(
        default=0.0,
        description="what is subtracted before the absolute value is taken; limit: what the "
        "values of a curve tend to as x shrinks, extrapolated from its three least, or two",
    )
    relative: bool = Field(
        default=False, description="whether the difference is divided by the reference"
    )

    @model_validator(mode="after")
    def _reference_to_divide_by(self) -> Self:
        if self.relative and self.reference == 0.0:
            raise_problems(
                "measure", [Problem(("relative",), "needs a reference other than 0")], self
            )
        return self

    @property
    def label(self) -> str:
        """Name in tables."""
        if isinstance(self.at, TimeMean):
            return f"{self.column}@{self.at.mean[0]:g}..{self.at.mean[1]:g}"
        return self.column if self.at == "end" else f"{self.column}@{self.at}"

    @property
    def last(self) -> float:
        """Last time that it needs; 0 if any end will do."""
        at = self.at.mean[1] if isinstance(self.at, TimeMean) else self.at
        return at if isinstance(at, float) else 0.0


AnyMeasure = Annotated[
    str | Measure,
    Either("a column of history.csv or {column: NAME, ...}", {str: Text, dict: Measure}),
]


def measure_of(entry: str | Measure) -> Measure:
    """Return the measure of a column's name, or the measure itself."""
    return Measure(column=entry) if isinstance(entry, str) else entry
