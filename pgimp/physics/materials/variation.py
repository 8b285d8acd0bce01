"""A parameter of a material that varies in space: by a table, layers, a column, at random.

In place of a number a case has a mapping that says how to get it from the place of a particle at the
start, ``young: {table: [[0.0, 5e6], [10.0, 4e7]], over: depth, surface: 12.0}``. Each is a type here,
with its values at places; what the numbers then do to the material is in
`pgimp.physics.materials.vary`.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, GetJsonSchemaHandler, StringConstraints, model_validator

from pgimp.physics.materials.profile import read_profile
from pgimp.physics.randomfield import EXPONENTIAL, lognormal, waves
from pgimp.schema.base import Model, NonNegative, Number, Positive
from pgimp.schema.dispatch import Dispatch, Either, plain
from pgimp.schema.messages import describe, got
from pgimp.schema.paths import FileName
from pgimp.schema.problems import Problem, problem, raise_problems
from pgimp.schema.registries import COMMENT
from pgimp.schema.sizes import AXES

Reals = NDArray[np.float64]
Path = tuple[str | int, ...]

#: How far beyond the ends of a table, as a part of its length, a place may lie for rounding.
_SLACK = 1e-9


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
        """The numbers that the values are made of, and where they stand, as far as they are known."""
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


class _Along(Variation):
    """What depends on one coordinate."""

    over: Literal["x", "y", "z", "depth"] = Field(
        description="the coordinate: x, y or z; or depth, by which a place lies below `surface`, "
        "along the last direction of the case"
    )
    surface: Number | None = Field(
        default=None, description="with depth: the coordinate at which it is 0 [length]"
    )

    @model_validator(mode="after")
    def _check_surface(self) -> _Along:
        if (self.over == "depth") != (self.surface is not None):
            text = "missing (the coordinate at which the depth is 0)"
            if self.over != "depth":
                text = f"belongs to over: depth, not to {self.over}"
            raise_problems("over", [Problem(("surface",), text, self.over == "depth")])
        return self

    def coordinate(self, x: Reals) -> Reals:
        """Return what the values depend on, (n,)."""
        if self.surface is not None:
            return self.surface - x[:, -1]
        return x[:, AXES.index(self.over)]

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        if self.over not in ("depth", *AXES[:dimensions]):
            yield Problem(("over",), f"the case, {dimensions}D, has no {self.over}")


Rows = tuple[tuple[Number, Number], ...]


def _ascending(key: str, rows: Any) -> None:
    """Refuse rows whose coordinates do not increase."""
    for i in range(1, len(rows)):
        before, after = rows[i - 1][0], rows[i][0]
        if not after > before:
            text = f"the coordinates must increase, but {after!r} follows {before!r}"
            raise_problems(key, [Problem((key, i, 0), text)])


class TableVariation(_Along):
    """Linear between the rows of a table over a coordinate."""

    table: Annotated[
        Any,
        Either("rows [[coordinate, value], ...] or the name of a file", {tuple: Rows, str: FileName}),
    ] = Field(
        description="rows [coordinate, value], the coordinates increasing; or a .csv file, from the "
        "folder of the case, with a line of names: a column named as `over` and one as `column`"
    )
    column: str | None = Field(
        default=None, description="column of the file; null: the one named as the parameter"
    )
    beyond: Literal["refuse", "hold"] = Field(
        default="refuse",
        description="for places beyond the ends of the table: refuse the case, or hold the values "
        "of the ends",
    )

    @model_validator(mode="after")
    def _check_rows(self) -> TableVariation:
        if isinstance(self.table, str):
            return self
        if not self.table:
            raise_problems("table", [Problem(("table",), "expected at least one row, got none")])
        if self.column is not None:
            text = "belongs to the name of a file, not to rows"
            raise_problems("table", [Problem(("column",), text)])
        _ascending("table", self.table)
        return self

    def called(self, name: str) -> None:
        """Learn the name of the parameter, which is that of the file's column if none is given."""
        self.__dict__["parameter"] = name

    def read(self) -> Rows:
        """Read the rows of the file.

        Raises
        ------
        CaseError
            With the file, the line and what is wrong.
        """
        return read_profile(self.table, self.over, self.column or self.__dict__["parameter"])

    @cached_property
    def rows(self) -> Rows:
        """The rows, of the case or of the file."""
        return self.read() if isinstance(self.table, str) else self.table

    @property
    def from_file(self) -> bool:
        """Whether the rows are in a file."""
        return isinstance(self.table, str)

    def _known(self) -> list[tuple[Path, float]]:
        if self.from_file and "rows" not in self.__dict__:
            return []
        path: tuple[Any, ...] = ("table",)
        return [
            (path if self.from_file else (*path, i, 1), value)
            for i, (_, value) in enumerate(self.rows)
        ]

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        t, (at, value) = self.coordinate(places.x), np.array(self.rows, float).T
        slack = _SLACK * (at[-1] - at[0])
        outside = (t < at[0] - slack) | (t > at[-1] + slack)
        if self.beyond == "refuse" and outside.any():
            row = int(np.argmax(outside))
            raise NoValueError(
                row,
                f"lies at {self.over} {t[row]:.6g}, where the table, from {at[0]:g} to {at[-1]:g}, "
                "has no value; give it more rows, or beyond: hold",
            )
        if len(at) == 1:
            return np.full(len(t), value[0])
        t = np.minimum(np.maximum(t, at[0]), at[-1])
        after = np.clip(np.searchsorted(at, t, "right"), 1, len(at) - 1)
        t0, t1, v0, v1 = at[after - 1], at[after], value[after - 1], value[after]
        # At the rows themselves exactly their values.
        return np.where(t == t1, v1, v0 + (v1 - v0) / (t1 - t0) * (t - t0))


class LayersVariation(_Along):
    """Constant in layers along a coordinate."""

    layers: Rows = Field(
        min_length=1,
        description="rows [coordinate, value]: where a layer begins and its value, up to where the "
        "next begins; the last has no end",
    )

    @model_validator(mode="after")
    def _check_rows(self) -> LayersVariation:
        _ascending("layers", self.layers)
        return self

    def _known(self) -> list[tuple[Path, float]]:
        return [(("layers", i, 1), value) for i, (_, value) in enumerate(self.layers)]

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        t, (begin, value) = self.coordinate(places.x), np.array(self.layers, float).T
        slack = _SLACK * max(abs(begin[0]), begin[-1] - begin[0])
        if (before := t < begin[0] - slack).any():
            row = int(np.argmax(before))
            raise NoValueError(
                row,
                f"lies at {self.over} {t[row]:.6g}, before the first layer, which begins at "
                f"{begin[0]:g}; let it begin earlier",
            )
        return value[np.maximum(np.searchsorted(begin, t, "right") - 1, 0)]


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
        """Take the mean of the column."""
        self.__dict__["mean"] = mean

    def _typical(self) -> float | None:
        return self.__dict__.get("mean")

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        return places.columns[self.column]


class RandomField(Model):
    """Statistics of a random field; the same on any number of ranks."""

    mean: Number = Field(description="mean of the values")
    cov: NonNegative | None = Field(
        default=None, description="coefficient of variation, the standard deviation over the mean"
    )
    deviation: NonNegative | None = Field(
        default=None, description="standard deviation, instead of `cov`"
    )
    distribution: Literal["lognormal", "normal"] = Field(
        default="lognormal",
        description="of the values at a point; lognormal ones have the sign of the mean",
    )
    correlation: Annotated[
        float | tuple[float, ...],
        Either(
            "a length, or one for each direction",
            {
                float: Positive,
                tuple: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=3)],
            },
        ),
    ] = Field(
        description="correlation length l, or one for each direction; for exponential half of the "
        "scale of fluctuation [length]"
    )
    covariance: Literal["exponential", "gaussian"] = Field(
        default=EXPONENTIAL,
        description="correlation of the values (of their logarithms if lognormal) at two points: "
        "exp(-r) or exp(-r^2), r^2 the sum of (distance/l)^2 over the directions",
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**53)] = Field(
        default=0,
        description="which of all such fields: parameters with the same seed, lengths, covariance "
        "and modes are fully correlated, with another seed they are independent",
    )
    modes: Annotated[int, Field(strict=True, ge=16, le=100_000)] = Field(
        default=1000,
        description="waves that a field is a sum of: correlations are off by up to 1/sqrt(2 modes)",
    )

    @model_validator(mode="after")
    def _check(self) -> RandomField:
        if (self.cov is None) == (self.deviation is None):
            text = "give one of cov and deviation"
            raise_problems("random", [Problem((), f"{text}, the scatter of the values")])
        if self.mean == 0.0 and (self.cov is not None or self.distribution == "lognormal"):
            text = "0 has no coefficient of variation; give a deviation, of distribution: normal"
            raise_problems("random", [Problem(("mean",), text)])
        return self

    @property
    def scatter(self) -> float:
        """Standard deviation over the size of the mean."""
        return self.cov if self.cov is not None else (self.deviation or 0.0) / abs(self.mean)

    def lengths(self, dimensions: int) -> tuple[float, ...]:
        """Correlation lengths along all directions."""
        found = self.correlation
        return found if isinstance(found, tuple) else (float(found),) * dimensions

    def values(self, x: Reals) -> Reals:
        """Values at places, (n, D)."""
        lengths = self.lengths(x.shape[1])
        g = waves(self.covariance, lengths, self.seed, self.modes).at(x)
        if self.distribution == "lognormal":
            return lognormal(g, self.mean, self.scatter)
        deviation = self.deviation if self.cov is None else self.cov * abs(self.mean)
        assert deviation is not None
        return self.mean + deviation * g


class RandomVariation(Variation):
    """A random field."""

    random: RandomField = Field(description="its statistics, and which one it is")
    between: tuple[Number, Number] | None = Field(
        default=None, description="least and greatest value; what lies beyond gets these"
    )

    @model_validator(mode="after")
    def _check(self) -> RandomVariation:
        if self.between is not None and not self.between[0] < self.between[1]:
            text = "expected two numbers, the first below the second"
            raise_problems("between", [Problem(("between",), text)])
        return self

    def _typical(self) -> float | None:
        least, most = self.between or (-math.inf, math.inf)
        return min(max(self.random.mean, least), most)

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        found = self.random.values(places.x)
        if self.between is None:
            return found
        return np.minimum(np.maximum(found, self.between[0]), self.between[1])

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        found = self.random.correlation
        if isinstance(found, tuple) and len(found) != dimensions:
            text = f"expected a length, or {dimensions}, one a direction, got {describe(found)}"
            yield Problem(("random", "correlation"), text)


#: What a parameter may be in place of a number, by the key that says so; the first one counts.
KINDS: dict[str, type[Variation]] = {
    "table": TableVariation,
    "layers": LayersVariation,
    "random": RandomVariation,
    "column": FromColumn,
}
