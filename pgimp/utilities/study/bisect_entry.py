"""The entry `bisect` of a study."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pgimp.schema.base import Model, Number, Positive
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import problem

#: Greatest displacement at rest in cells' shortest edges, unless one is given.
CELLS = 0.1


def _two(value: tuple[float, ...]) -> tuple[float, ...]:
    if len(value) != 2 or value[0] == value[1]:
        raise problem("expected two different numbers: with the first it comes to rest")
    return value


def _path(value: str) -> str:
    if not all(value.split(".")):
        raise problem(
            "expected keys joined by dots, such as time.stages.0.strength-reduction.factor"
        )
    return value


class Bisection(Model):
    """Which value of a key is the last with which the case comes to rest."""

    key: Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(_path)] = Field(
        description="the key of the case that changes from run to run, as --set takes it: "
        "time.stages.0.strength-reduction.factor finds a factor of safety"
    )
    between: Annotated[tuple[Number, ...], AfterValidator(_two)] = Field(
        description="two values: with the first one the case comes to rest, with the second not"
    )
    tolerance: Positive = Field(
        default=0.01, description="distance of the two values at which it ends"
    )
    failure_displacement: Annotated[
        float | Literal["auto"] | None,
        Either("a length, auto or null", {float: Positive, str: Literal["auto"], None: None}),
    ] = Field(
        default="auto",
        alias="failure-displacement",
        description="greatest displacement of a particle in a stage with `equilibrate`, of those "
        "that the key changes, for the case to count as at rest: what moves farther has slid, "
        "though it rests as a heap in the end. auto: a tenth of a cell's shortest edge; null: any "
        "[length]",
    )
    reference: Number | None = Field(
        default=None,
        description="a known result, to which the tables give the relative error; null: none",
    )
