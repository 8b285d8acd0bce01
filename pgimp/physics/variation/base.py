"""What all ways in which a parameter may vary in space have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, GetJsonSchemaHandler

from pgimp.schema.base import Model, Number
from pgimp.schema.dispatch import Dispatch, Either, plain
from pgimp.schema.messages import got
from pgimp.schema.problems import Problem, problem
from pgimp.schema.registries import COMMENT

Reals = NDArray[np.float64]
Path = tuple[str | int, ...]


class Places(NamedTuple):
    """Places of particles at the start, (n, D), and what a file of particles has besides.

    `columns` has (n,) values by the names of columns.
    """

    x: Reals
    columns: Mapping[str, Reals]


class NoValueError(Exception):
    """There is no value at a place: row of the place, and why."""

    def __init__(self, row: int, text: str) -> None:
        super().__init__(text)
        self.row = row


#: What a parameter may be in place of a number, by the key that says so; the first one counts. The
#: package fills it.
KINDS: dict[str, type[Variation]] = {}


class _ByKind(Dispatch):
    """A mapping whose key says how a parameter varies."""

    what = "variation"

    def validate(self, value: Any) -> Variation:
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

    def write(self, value: Variation) -> Any:
        """See `Dispatch`."""
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Refer to a definition, since variations contain one another."""
        return {"$comment": COMMENT + self.what}


#: What ``{table: ...}`` and so on are validated by.
VARIATION = _ByKind()


class Variation(Model):
    """Base of what a parameter may be in place of a number."""

    times: Annotated[
        Any, Either("a number or another variation", {float: Number, dict: VARIATION, None: None})
    ] = Field(
        default=None,
        description="a number, or another variation, that the values are multiplied with: a random "
        "field of mean 1 times a table is one with a trend; null: none",
    )

    def values(self, places: Places) -> Reals:
        """Values at places, (n,).

        Raises
        ------
        NoValueError
            If there is none at one of them.
        """
        found = self.own_values(places)
        if isinstance(self.times, Variation):
            return found * self.times.values(places)
        return found if self.times is None else found * self.times

    @abstractmethod
    def own_values(self, places: Places) -> Reals:
        """As `values`, without `times`."""

    def _known(self) -> list[tuple[Path, float]]:
        """The numbers that the values are made of, and where they stand, if they are known."""
        return []

    def known(self) -> list[tuple[Path, float]]:
        """Values that it may have, and where in it they stand; none where particles decide."""
        factor = 1.0 if self.times is None else self.times
        if isinstance(factor, Variation):
            return []
        return [(path, factor * value) for path, value in self._known()]

    def _typical(self) -> float | None:
        known = [value for _, value in self._known()]
        return known[len(known) // 2] if known else None

    @property
    def typical(self) -> float | None:
        """A value from the middle of its range; None as long as a file has not been read."""
        found, factor = self._typical(), self.times
        if isinstance(factor, Variation):
            factor = factor.typical
        elif factor is None:
            return found
        return None if found is None or factor is None else found * factor

    def parts(self) -> Iterator[Variation]:
        """Yield it, and what it is multiplied with."""
        yield self
        if isinstance(self.times, Variation):
            yield from self.times.parts()

    def release(self) -> None:
        """Forget what was read from files."""

    def called(self, name: str) -> None:
        """Learn the name of the parameter."""

    @property
    def columns(self) -> list[str]:
        """Columns of a file of particles that it needs, not those of `times`."""
        return []

    def problems(self, dimensions: int) -> Iterator[Problem]:
        """Yield what does not fit the dimensions of a case, below the parameter's key."""
        yield from self._own_problems(dimensions)
        if isinstance(self.times, Variation):
            for found in self.times.problems(dimensions):
                yield found._replace(path=("times", *found.path))

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        yield from ()
