"""Measures of a study file: numbers taken from the history of a run."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from pgimp.schema.base import Model, Number, one_line
from pgimp.schema.dispatch import Either
from pgimp.schema.instants import AT, At, label_of, last_of
from pgimp.schema.problems import Problem, raise_problems

LIMIT = "limit"
"""The reference that is extrapolated from the runs."""

Text = Annotated[
    str, StringConstraints(strict=True, min_length=1, max_length=1000), AfterValidator(one_line)
]


class Measure(Model):
    """A number taken from the history of a run."""

    column: Text = Field(description="a column of history.csv")
    at: At = Field(default="end", description=AT)
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
        return f"{self.column}{label_of(self.at)}"

    @property
    def last(self) -> float:
        """Last time that it needs; 0 if any end will do."""
        return last_of(self.at)


AnyMeasure = Annotated[
    str | Measure,
    Either("a column of history.csv or {column: NAME, ...}", {str: Text, dict: Measure}),
]


def measure_of(entry: str | Measure) -> Measure:
    """Return the measure of a column's name, or the measure itself."""
    return Measure(column=entry) if isinstance(entry, str) else entry
