"""Base of all kinds of variation of a parameter in space."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue

from pgimp.schema.base import Model, Number
from pgimp.schema.dispatch import Dispatch, Either, plain
from pgimp.schema.messages import got
from pgimp.schema.problems import Problem, problem
from pgimp.schema.registries import COMMENT

Reals = NDArray[np.float64]
Path = tuple[str | int, ...]


class Places(NamedTuple):
    """Initial positions of particles, (n, D), and further columns of a file of particles.

    `columns` has (n,) values by the names of columns.
    """

    x: Reals
    columns: Mapping[str, Reals]


class NoValueError(Exception):
    """There is no value at a position: row of the position, and the reason."""

    def __init__(self, row: int, text: str) -> None:
        super().__init__(text)
        self.row = row


#: Kinds of variation by their key in the case; the first key present counts. The package fills it.
KINDS: dict[str, type[Variation]] = {}


class _ByKind(Dispatch):
    """A mapping whose key names the kind of variation."""

    what = "variation"

    def validate(self, value: object) -> Variation:
        """See `Dispatch`."""
        if isinstance(value, Variation):
            return value
        kinds = ", ".join(KINDS)
        if not isinstance(value, Mapping):
            raise problem(f"expected a number, or a mapping with one of {kinds}; {got(value)}")
        for name, kind in KINDS.items():
            if name in value:
                return kind.model_validate(value)
        raise problem(f"expected a number, or a mapping with one of {kinds}; {got(value)}")

    def write(self, value: Variation) -> object:
        """See `Dispatch`."""
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Refer to a definition, since variations contain one another."""
        return {"$comment": COMMENT + self.what}


#: Validator of ``{table: ...}`` and the other kinds.
VARIATION = _ByKind()


class Variation(Model):
    """Base of the variations in place of a parameter's number."""

    times: Annotated[
        float | Variation | None,
        Either("a number or another variation", {float: Number, dict: VARIATION, None: None}),
    ] = Field(
        default=None,
        description="a number, or another variation, that the values are multiplied with: a random "
        "field of mean 1 times a table is one with a trend; null: none",
    )

    def values(self, places: Places) -> Reals:
        """Values at positions, (n,).

        Raises
        ------
        NoValueError
            If there is no value at one of the positions.
        """
        found = self.own_values(places)
        if isinstance(self.times, Variation):
            return found * self.times.values(places)
        return found if self.times is None else found * self.times

    @abstractmethod
    def own_values(self, places: Places) -> Reals:
        """As `values`, without `times`."""

    def _known(self) -> list[tuple[Path, float]]:
        """Numbers that define the values, with their paths, as far as known."""
        return []

    def known(self) -> list[tuple[Path, float]]:
        """Possible values, with their paths in the variation; none if particles define them."""
        factor = 1.0 if self.times is None else self.times
        if isinstance(factor, Variation):
            return []
        return [(path, factor * value) for path, value in self._known()]

    def _typical(self) -> float | None:
        known = [value for _, value in self._known()]
        return known[len(known) // 2] if known else None

    @property
    def typical(self) -> float | None:
        """A value from the middle of the range; None until a file has been read."""
        found, factor = self._typical(), self.times
        if isinstance(factor, Variation):
            factor = factor.typical
        elif factor is None:
            return found
        return None if found is None or factor is None else found * factor

    def parts(self) -> Iterator[Variation]:
        """Yield the variation itself, and the variations that multiply it."""
        yield self
        if isinstance(self.times, Variation):
            yield from self.times.parts()

    def release(self) -> None:
        """Free the data from files."""

    def called(self, name: str) -> None:
        """Set the name of the parameter."""

    @property
    def columns(self) -> list[str]:
        """Columns of a file of particles that it needs, without the columns for `times`."""
        return []

    def problems(self, dimensions: int) -> Iterator[Problem]:
        """Yield problems with the dimensions of a case; paths below the parameter's key."""
        yield from self._own_problems(dimensions)
        if isinstance(self.times, Variation):
            for found in self.times.problems(dimensions):
                yield found._replace(path=("times", *found.path))

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        yield from ()
