"""Building blocks of the case file: the model base class and the number types."""

from __future__ import annotations

import re
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    StringConstraints,
    ValidationError,
    model_validator,
)

from pgimp.schema.dispatch import Either
from pgimp.schema.messages import explain
from pgimp.schema.problems import problem, raise_problems

LARGEST_COUNT = 2**53
"""Largest whole number that a float64 counts up to without gaps."""


def _whole(value: object) -> object:
    """Turn 1e3 into 1000: the notation of a whole number does not matter."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def tuples(value: object) -> object:
    """Turn lists into tuples, at any depth of lists, for strict tuple fields."""
    if isinstance(value, list | tuple):
        return tuple(tuples(item) for item in value)
    return value


def chosen(schema: dict[str, Any]) -> None:
    """Document that a key may be left out, and is then chosen."""
    schema.pop("default", None)
    schema["$comment"] = "chosen"
    or_auto(schema)


def or_auto(schema: dict[str, Any]) -> None:
    """Document the word `auto` beside a key's values: it is chosen, as if it were left out."""
    keys = ("type", "items", "const", "enum", "anyOf", "oneOf")
    form = {key: schema.pop(key) for key in keys if key in schema}
    schema["anyOf"] = [*form.pop("anyOf", [form]), {"const": "auto"}]


class Model(BaseModel):
    """Base class of everything in a case: strict types, no unknown keys, frozen, finite numbers.

    A description of a field ends with its unit, if any, in square brackets. Units are length, mass,
    time, and derived ones: ``"Young's modulus [stress]"``.
    """

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        validate_default=True,
        populate_by_name=False,
        defer_build=True,  # no validators for unused parts: saves a sixth of a start
    )

    DIMENSIONS: ClassVar[tuple[int, ...]] = (1, 2, 3)
    """Dimensions of a case in which the entry may be used."""

    SPELLINGS: ClassVar[dict[str, str]] = {}
    """Keys that are accepted for another one, unless both are given."""

    @model_validator(mode="before")
    @classmethod
    def _take_lists(cls, data: object) -> object:
        if isinstance(data, dict):
            other = {key: name for key, name in cls.SPELLINGS.items() if name not in data}
            return {other.get(key, key): tuples(value) for key, value in data.items()}
        return data

    @model_validator(mode="wrap")
    @classmethod
    def _speak(cls, data: object, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Reword validation errors here, where the model and its keys are available."""
        try:
            return handler(data)
        except ValidationError as error:
            if not isinstance(data, dict):
                raise  # the alternatives are handled by the caller
            return raise_problems(cls.__name__, explain(cls, error, data), data)


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

Name = Annotated[str, StringConstraints(strict=True, pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,99}$")]
"""Name of a material or a body."""

_CONTROL = re.compile("[\\x00-\\x1f\\x7f-\\x9f\u2028\u2029]")


def one_line(text: str) -> str:
    """Refuse characters that could move a terminal's cursor or end a file's line."""
    if found := _CONTROL.search(text):
        raise problem(f"expected a line of text, but it has the character U+{ord(found[0]):04X}")
    return text


Label = Annotated[str, StringConstraints(strict=True, max_length=1000), AfterValidator(one_line)]
"""One line of text: no line breaks, no control characters."""


class Steps(Model):
    """A number of time steps."""

    steps: Count = Field(description="interval in steps")


Interval = Annotated[
    float | Steps, Either("a time above zero or {steps: 10}", {float: Positive, dict: Steps})
]
"""How often something happens: a simulated time above zero, or ``{steps: n}``."""
