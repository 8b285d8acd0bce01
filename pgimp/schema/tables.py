"""Vectors and prescribed velocities over time, of numbers in `pgimp.schema.time_functions`."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field, GetJsonSchemaHandler, TypeAdapter, model_serializer, model_validator

from pgimp.schema.base import Model, Number, Vector
from pgimp.schema.dispatch import Dispatch, Either, plain
from pgimp.schema.problems import raise_problems
from pgimp.schema.rows import between, neighbours, row_problems
from pgimp.schema.sizes import Problems, length
from pgimp.schema.time_functions import ALLOWED, OVER_TIME, Table, TimeFunction


class VectorFunction(Model):
    """A vector over time, held at both ends."""

    @abstractmethod
    def value(self, t: float) -> tuple[float, ...]:
        """Return the value at time `t`, shape (D,)."""

    @abstractmethod
    def integral(self, t: float) -> tuple[float, ...]:
        """Return the integral of the value from time 0 to `t`, shape (D,)."""

    @property
    @abstractmethod
    def rows(self) -> Sequence[tuple[float, tuple[float, ...]]]:
        """Instants with the values there, see `TimeFunction.rows`."""


class VectorTable(VectorFunction):
    """A vector over time: linear between the rows, held at both ends."""

    table: tuple[tuple[Number, Vector], ...] = Field(
        min_length=1, description="rows [time, [one number a direction]], the times increasing"
    )

    @model_validator(mode="after")
    def _check_rows(self) -> VectorTable:
        raise_problems("VectorTable", list(row_problems(self.table)))
        return self

    @property
    def rows(self) -> Sequence[tuple[float, tuple[float, ...]]]:
        """See `VectorFunction`."""
        return self.table

    def value(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        (t0, v0), (t1, v1) = neighbours(self.table, t)
        return tuple(between(t, t0, t1, a, b) for a, b in zip(v0, v1, strict=True))

    @cached_property
    def _components(self) -> tuple[Table, ...]:
        """The table of each component."""
        return tuple(
            Table(table=tuple((t, v[d]) for t, v in self.table))
            for d in range(len(self.table[0][1]))
        )

    def integral(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        return tuple(component.integral(t) for component in self._components)


Varying = Annotated[
    float | TimeFunction, Either(f"a number, {ALLOWED}", {float: Number, dict: OVER_TIME})
]
"""A number, constant or over time."""

MayVary = Annotated[
    float | TimeFunction | None,
    Either(f"a number, null or {ALLOWED}", {float: Number, dict: OVER_TIME, None: None}),
]
"""A number, constant or over time, or none."""

Component = Annotated[
    float | TimeFunction | None,
    Either(f"a number, null (free), {ALLOWED}", {float: Number, dict: OVER_TIME, None: None}),
]
"""One component of a prescribed velocity."""


class Components(VectorFunction):
    """A vector of which some components vary in time."""

    components: tuple[Varying, ...]

    @model_serializer
    def _as_list(self) -> tuple[Any, ...]:
        return tuple(
            OVER_TIME.write(each) if isinstance(each, TimeFunction) else each
            for each in self.components
        )

    def value(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        return tuple(c.value(t) if isinstance(c, TimeFunction) else c for c in self.components)

    def integral(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        return tuple(
            c.integral(t) if isinstance(c, TimeFunction) else c * t for c in self.components
        )

    @property
    def rows(self) -> Sequence[tuple[float, tuple[float, ...]]]:
        """See `VectorFunction`."""
        every = [c.rows for c in self.components if isinstance(c, TimeFunction)]
        times = sorted({t for rows in every for t, _ in rows})
        return tuple((t, self.value(t)) for t in times)


class _Entries(Dispatch):
    """A list of numbers, some of which may vary in time."""

    def __init__(self) -> None:
        some = Annotated[tuple[Varying, ...], Field(min_length=1, max_length=3)]
        self.constant, self.varying = TypeAdapter(Vector), TypeAdapter(some)

    def validate(self, value: object) -> object:
        """See `Dispatch`."""
        entries = value if isinstance(value, list | tuple) else ()
        if not any(isinstance(entry, dict | TimeFunction) for entry in entries):
            return self.constant.validate_python(value)
        return Components(components=self.varying.validate_python(tuple(entries)))

    def write(self, value: object) -> object:
        """See `Dispatch`."""
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        return handler(self.varying.core_schema)


VaryingVector = Annotated[
    tuple[float, ...] | VectorFunction | None,
    Either(
        "one number a direction or {table: [[time, [..]], ...]}",
        {tuple: _Entries(), dict: VectorTable, None: None},
    ),
]
"""A vector, constant or over time."""

Held = tuple[bool, bool, bool]
Triple = tuple[float, float, float]


def entries_of(value: object) -> Iterator[tuple[tuple[str | int, ...], tuple[float, ...]]]:
    """Yield the vectors that a constant or varying one has, with their paths."""
    if isinstance(value, VectorFunction):
        table = isinstance(value, VectorTable)
        for i, (_, row) in enumerate(value.rows):
            yield (("table", i, 1) if table else ()), row
    elif isinstance(value, tuple):
        yield (), value


def lengths(path: tuple[str | int, ...], value: object, dimensions: int) -> Problems:
    """Check that a vector, constant or over time, has one entry a direction."""
    found = {}
    for at, row in entries_of(value):
        for each in length((*path, *at), row, dimensions):
            found[each.path] = each
    yield from found.values()


def prescribed(
    velocity: Sequence[float | TimeFunction | None], start: float, end: float
) -> tuple[Held, Triple, Triple]:
    """Return the held components in a step, their values at its end, and their rates over it.

    Values and rates of free components are zero.
    """
    held, values, rates = [False] * 3, [0.0] * 3, [0.0] * 3
    for d, component in enumerate(velocity):
        if component is None:
            continue
        held[d] = True
        if isinstance(component, TimeFunction):
            values[d] = component.value(end)
            if end > start:
                rates[d] = (values[d] - component.value(start)) / (end - start)
        else:
            values[d] = float(component)
    return (
        (held[0], held[1], held[2]),
        (values[0], values[1], values[2]),
        (rates[0], rates[1], rates[2]),
    )
