"""Building blocks of the case file: the model base class and the number types."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StringConstraints,
    Tag,
    model_validator,
)

LARGEST_COUNT = 2**53
"""Largest whole number that a float64 counts up to without gaps."""


def _whole(value: Any) -> Any:
    """Turn 1e3 into 1000: a whole number is the same however it is written."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def _tuples(value: Any) -> Any:
    """Turn lists into tuples, at any depth of lists, so that strict tuple fields take them."""
    if isinstance(value, list | tuple):
        return tuple(_tuples(item) for item in value)
    return value


class Model(BaseModel):
    """Base class of everything in a case: strict types, no unknown keys, frozen, finite numbers.

    A description of a field ends with its unit in square brackets where it has one, in terms of
    length, mass, time, and what derives from them: ``"Young's modulus [stress]"``.
    """

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        validate_default=True,
        populate_by_name=False,
    )

    DIMENSIONS: ClassVar[tuple[int, ...]] = (1, 2, 3)
    """Dimensions of a case in which the entry may be used."""

    @model_validator(mode="before")
    @classmethod
    def _take_lists(cls, data: Any) -> Any:
        if isinstance(data, dict):
            return {key: _tuples(value) for key, value in data.items()}
        return data


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
"""A finite float64; whole numbers are taken too, text and true or false never."""

Positive = Annotated[Number, Field(gt=0)]
"""A number above zero."""

NonNegative = Annotated[Number, Field(ge=0)]
"""A number of at least zero."""

Count = Annotated[int, Field(strict=True, ge=1, le=LARGEST_COUNT), BeforeValidator(_whole)]
"""A whole number of at least one; 1e3 and 1000.0 are 1000."""

Vector = Annotated[tuple[Number, ...], Field(strict=True, min_length=1, max_length=3)]
"""One number a direction of the case."""

Name = Annotated[str, StringConstraints(strict=True, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")]
"""Name of a material or a body."""


class Steps(Model):
    """A number of time steps."""

    steps: Count = Field(description="every so many steps")


def _interval_kind(value: Any) -> str:
    return "<steps>" if isinstance(value, dict | Steps) else "<time>"


Interval = Annotated[
    Annotated[Positive, Tag("<time>")] | Annotated[Steps, Tag("<steps>")],
    Discriminator(_interval_kind),
]
"""How often something happens: a simulated time above zero, or ``{steps: n}``."""
