"""Numbers over time: tables, series from files, smooth ramps and sinusoids.

Plain Python arithmetic on float64, one order of operations: the same bits on every rank.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from bisect import bisect_right
from collections.abc import Sequence
from functools import cached_property
from itertools import accumulate, pairwise

from pydantic import BaseModel, Field, model_validator

from pgimp.errors import CaseError
from pgimp.schema.base import Model, Number, Positive
from pgimp.schema.paths import FileName
from pgimp.schema.problems import Problem, problem, raise_problems
from pgimp.schema.profile import read_profile
from pgimp.schema.registries import ByKey
from pgimp.schema.rows import between, neighbours, row_problems

#: Most rows of a series from a file: the case of the run, which has them, is read again to resume.
_MOST_ROWS = 50_000

#: Quarters of a period at which the rows of a sinusoid are.
_MOST_QUARTERS = 1000


class TimeFunction(Model):
    """A number over time, held at both ends."""

    @abstractmethod
    def value(self, t: float) -> float:
        """Return the value at time `t`."""

    @abstractmethod
    def integral(self, t: float) -> float:
        """Return the integral of the value from time 0 to `t`."""

    @property
    @abstractmethod
    def rows(self) -> Sequence[tuple[float, float]]:
        """Instants with the values there, among them the least and the greatest one."""


class Table(TimeFunction):
    """A number over time: linear between the rows, held at both ends."""

    table: tuple[tuple[Number, Number], ...] = Field(
        min_length=1, description="rows [time, value], the times strictly increasing"
    )

    @model_validator(mode="after")
    def _check_rows(self) -> Table:
        raise_problems("Table", list(row_problems([(t, (v,)) for t, v in self.table])))
        return self

    @property
    def rows(self) -> Sequence[tuple[float, float]]:
        """See `TimeFunction`."""
        return self.table

    @property
    def source(self) -> str | None:
        """Name of the file that the rows are from, if any."""
        return self.__dict__.get("file")

    def value(self, t: float) -> float:
        """See `TimeFunction`."""
        (t0, v0), (t1, v1) = neighbours(self.table, t)
        return between(t, t0, t1, v0, v1)

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
        """See `TimeFunction`."""
        return self._from_first_row(t) - self._from_first_row(0.0)


class Series(Model):
    """A column of a file over time, as a table."""

    file: FileName = Field(
        description="a .csv file, from the folder of the case, with a line of names"
    )
    column: str = Field(description="name of the values' column")
    time: str = Field(default="time", description="name of the times' column")
    factor: Number = Field(default=1.0, description="what the values are multiplied by")
    integrate: bool = Field(
        default=False,
        description="true: the values are rates, as accelerations where velocities are meant; "
        "their integral begins with 0",
    )
    baseline: bool = Field(
        default=False,
        description="true: subtract the mean of the rates, so that their integral ends with 0",
    )

    @model_validator(mode="after")
    def _check_baseline(self) -> Series:
        if self.baseline and not self.integrate:
            text = "is of rates: it needs integrate: true"
            raise_problems("Series", [Problem(("baseline",), text)])
        return self

    def table(self) -> Table:
        """Read the file, and return the table.

        Raises
        ------
        CaseError
            With the file, the line and the problem.
        """
        rows = read_profile(self.file, self.time, self.column)
        if len(rows) > _MOST_ROWS:
            text = f"has {len(rows)} rows, of at most {_MOST_ROWS}; thin it out"
            raise CaseError(f"the table {self.file} {text}")
        if not all(math.isfinite(self.factor * v) for _, v in rows):
            raise CaseError(
                f"the table {self.file} times {self.factor:g} is too large for a float64"
            )
        table = Table(table=tuple((t, self.factor * v) for t, v in rows))
        if self.integrate:
            times, last = [t for t, _ in rows], table._integrals[-1]
            mean = last / (times[-1] - times[0]) if self.baseline and len(rows) > 1 else 0.0
            values = [
                whole - mean * (t - times[0])
                for t, whole in zip(times, table._integrals, strict=True)
            ]
            if self.baseline:
                values[-1] = 0.0
            table = Table(table=tuple(zip(times, values, strict=True)))
        table.__dict__["file"] = self.file
        return table


class Ramp(TimeFunction):
    """A smooth step, s^3 (10 - 15 s + 6 s^2): first and second derivative begin and end with 0."""

    start: Number = Field(default=0.0, alias="from", description="the value before")
    to: Number = Field(description="the value after")
    begin: Number = Field(default=0.0, description="when it begins [time]")
    duration: Positive = Field(description="how long it takes [time]")

    @model_validator(mode="after")
    def _check_rise(self) -> Ramp:
        if not math.isfinite(self.to - self.start):
            raise_problems("Ramp", [Problem(("to",), "the rise is too large for a float64")])
        return self

    @property
    def rows(self) -> Sequence[tuple[float, float]]:
        """See `TimeFunction`."""
        instants = [self.begin + self.duration * k / 8 for k in range(9)]
        return tuple((t, self.value(t)) for t in instants)

    def _part(self, t: float) -> float:
        return min(max((t - self.begin) / self.duration, 0.0), 1.0)

    def value(self, t: float) -> float:
        """See `TimeFunction`."""
        s = self._part(t)
        return self.start + (self.to - self.start) * (s * s * s * (10.0 + s * (6.0 * s - 15.0)))

    def _risen(self, t: float) -> float:
        """Integral of the rise from its beginning."""
        s = self._part(t)
        whole = self.duration * (s**4 * (2.5 + s * (s - 3.0)))
        return whole + max(t - self.begin - self.duration, 0.0)

    def integral(self, t: float) -> float:
        """See `TimeFunction`."""
        return self.start * t + (self.to - self.start) * (self._risen(t) - self._risen(0.0))


class Sine(TimeFunction):
    """A sinusoid, mean + amplitude sin(2 pi frequency (t - begin) + phase)."""

    amplitude: Number = Field(description="the amplitude")
    frequency: Positive = Field(le=1e100, description="periods in a unit of time [1/time]")
    phase: Number = Field(default=0.0, description="phase as it begins, in radians")
    mean: Number = Field(default=0.0, description="the value about which it swings")
    begin: Number = Field(default=0.0, description="when it begins; held before [time]")
    end: Number | None = Field(default=None, description="when it ends; null: never [time]")

    @model_validator(mode="after")
    def _check_end(self) -> Sine:
        if not math.isfinite(abs(self.mean) + abs(self.amplitude)):
            text = "the greatest value is too large for a float64"
            raise_problems("Sine", [Problem(("amplitude",), text)])
        if self.end is not None and not self.end > self.begin:
            text = f"it must end after it begins, at {self.begin!r}"
            raise_problems("Sine", [Problem(("end",), text)])
        return self

    @property
    def rows(self) -> Sequence[tuple[float, float]]:
        """See `TimeFunction`."""
        last = math.inf if self.end is None else self.end
        quarter = 0.5 * math.pi
        first = math.ceil(self.phase / quarter)
        rate = 2.0 * math.pi * self.frequency
        instants = (
            self.begin + (k * quarter - self.phase) / rate
            for k in range(first, first + _MOST_QUARTERS)
        )
        times = {self.begin, *(t for t in instants if t < last)}
        if self.end is not None:
            times.add(self.end)
        return tuple((t, self.value(t)) for t in sorted(times))

    def _since(self, t: float) -> float:
        """Time since the beginning, held at both ends."""
        last = math.inf if self.end is None else self.end
        return min(max(t, self.begin), last) - self.begin

    def value(self, t: float) -> float:
        """See `TimeFunction`."""
        angle = 2.0 * math.pi * self.frequency * self._since(t) + self.phase
        return self.mean + self.amplitude * math.sin(angle)

    def _from_beginning(self, t: float) -> float:
        since, rate = self._since(t), 2.0 * math.pi * self.frequency
        swing = math.cos(self.phase) - math.cos(rate * since + self.phase)
        beyond = t - self.begin - since  # time during which the value is held
        return self.mean * since + self.amplitude / rate * swing + beyond * self.value(t)

    def integral(self, t: float) -> float:
        """See `TimeFunction`."""
        return self._from_beginning(t) - self._from_beginning(0.0)


#: Forms of a number over time, by the key that names them; floors above add theirs.
FORMS: dict[str, type[BaseModel]] = {"table": Table, "ramp": Ramp, "sine": Sine, "series": Series}


class OverTime(ByKey):
    """A number over time, ``{table: [[time, value], ..]}`` or ``{ramp: {..}}`` and others."""

    def __init__(self) -> None:
        super().__init__(lambda: FORMS, "function of time")

    def validate(self, value: object) -> BaseModel | None:
        """See `Dispatch`."""
        found = super().validate(value)
        if not isinstance(found, Series):
            return found
        try:
            return found.table()
        except CaseError as error:
            raise problem(str(error)) from None


OVER_TIME = OverTime()

#: What a number that may vary in time may be, for messages.
ALLOWED = "{table: [[time, value], ..]}, {ramp: ..}, {sine: ..}, {series: ..} or {function: ..}"
