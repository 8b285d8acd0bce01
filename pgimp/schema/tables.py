"""Values from a table over time: linear between rows, constant beyond both ends.

Plain Python arithmetic on float64, one order of operations: the same bits on every rank.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Annotated, TypeVar

from pydantic import Field, model_validator

from pgimp.schema.base import Model, Number, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems

V = TypeVar("V")


def _neighbours(rows: Sequence[tuple[float, V]], t: float) -> tuple[tuple[float, V], ...]:
    """Return the rows before and after `t`, the same row twice beyond the ends."""
    after = bisect_right(rows, t, key=lambda row: row[0])
    return rows[max(after - 1, 0)], rows[min(after, len(rows) - 1)]


def _between(t: float, t0: float, t1: float, v0: float, v1: float) -> float:
    if t0 == t1:
        return v0
    return v0 + (v1 - v0) / (t1 - t0) * (t - t0)


def _row_problems(rows: Sequence[tuple[float, tuple[float, ...]]]) -> list[Problem]:
    """Return problems between rows: times that do not increase, overflow between values."""
    problems = []
    for i in range(1, len(rows)):
        (t0, v0), (t1, v1) = rows[i - 1], rows[i]
        if t1 <= t0:
            text = f"the times of a table must increase, but {t1!r} follows {t0!r}"
            problems.append(Problem(("table", i, 0), text))
        elif len(v0) != len(v1):
            text = f"expected {len(v0)} values as in the row before, got {len(v1)}"
            problems.append(Problem(("table", i, 1), text))
        elif not all(
            math.isfinite(_between(t1, t0, t1, a, b)) for a, b in zip(v0, v1, strict=True)
        ):
            text = "the change from the row before is too large for a float64"
            problems.append(Problem(("table", i), text))
    return problems


class Table(Model):
    """A number over time: linear between the rows, held at both ends."""

    table: tuple[tuple[Number, Number], ...] = Field(
        min_length=1, description="rows [time, value], the times strictly increasing"
    )

    @model_validator(mode="after")
    def _check_rows(self) -> Table:
        raise_problems("Table", _row_problems([(t, (v,)) for t, v in self.table]))
        return self

    def value(self, t: float) -> float:
        """Return the value at time `t`."""
        (t0, v0), (t1, v1) = _neighbours(self.table, t)
        return _between(t, t0, t1, v0, v1)

    @cached_property
    def _integrals(self) -> tuple[float, ...]:
        """Integrals of the value from the first row to each row."""
        pieces = ((t1 - t0) * (0.5 * v0 + 0.5 * v1) for (t0, v0), (t1, v1) in pairwise(self.table))
        return tuple(accumulate(pieces, initial=0.0))

    def _from_first_row(self, t: float) -> float:
        row = max(bisect_right(self.table, t, key=lambda row: row[0]) - 1, 0)
        start, value = self.table[row]
        return self._integrals[row] + (t - start) * (0.5 * value + 0.5 * self.value(t))

    def integral(self, t: float) -> float:
        """Return the integral of the value from time 0 to `t`."""
        return self._from_first_row(t) - self._from_first_row(0.0)


class VectorTable(Model):
    """A vector over time: linear between the rows, held at both ends."""

    table: tuple[tuple[Number, Vector], ...] = Field(
        min_length=1, description="rows [time, [one number a direction]], the times increasing"
    )

    @model_validator(mode="after")
    def _check_rows(self) -> VectorTable:
        raise_problems("VectorTable", _row_problems(self.table))
        return self

    def value(self, t: float) -> tuple[float, ...]:
        """Return the value at time `t`, shape (D,)."""
        (t0, v0), (t1, v1) = _neighbours(self.table, t)
        return tuple(_between(t, t0, t1, a, b) for a, b in zip(v0, v1, strict=True))

    @cached_property
    def _components(self) -> tuple[Table, ...]:
        """The table of each component."""
        return tuple(
            Table(table=tuple((t, v[d]) for t, v in self.table))
            for d in range(len(self.table[0][1]))
        )

    def integral(self, t: float) -> tuple[float, ...]:
        """Return the integral of the value from time 0 to `t`, shape (D,)."""
        return tuple(component.integral(t) for component in self._components)


VaryingVector = Annotated[
    tuple[float, ...] | VectorTable | None,
    Either(
        "one number a direction or {table: [[time, [..]], ...]}",
        {tuple: Vector, dict: VectorTable, None: None},
    ),
]
"""A vector, constant or over time."""

Component = Annotated[
    float | Table | None,
    Either(
        "a number, null (free) or {table: [[time, value], ...]}",
        {float: Number, dict: Table, None: None},
    ),
]
"""One component of a prescribed velocity."""

Held = tuple[bool, bool, bool]
Triple = tuple[float, float, float]


def prescribed(
    velocity: Sequence[float | Table | None], start: float, end: float
) -> tuple[Held, Triple, Triple]:
    """Return the held components in a step, their values at its end, and their rates over it.

    Values and rates of free components are zero.
    """
    held, values, rates = [False] * 3, [0.0] * 3, [0.0] * 3
    for d, component in enumerate(velocity):
        if component is None:
            continue
        held[d] = True
        if isinstance(component, Table):
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
