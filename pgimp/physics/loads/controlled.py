"""A load that a function of one's own sets while the run goes on."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from pgimp.schema.base import Name, Number
from pgimp.schema.time_functions import TimeFunction


class Level:
    """The present value of a controlled load, since when it has it, and its integral until then."""

    def __init__(self, value: float, since: float = 0.0, passed: float = 0.0) -> None:
        self.value, self.since, self.passed = value, since, passed

    def set(self, value: float, t: float) -> None:
        """Set the value from a time on."""
        self.passed += self.value * (t - self.since)
        self.value, self.since = value, t


class Controlled(TimeFunction):
    """A number that is constant until a program sets it, after a step (`pgimp.Each`)."""

    control: Name = Field(description="name by which the program sets it")
    start: Number = Field(default=0.0, description="the value at the start")

    def follow(self, level: Level) -> None:
        """Take the value from a level from now on."""
        self.__dict__["level"] = level

    @property
    def _level(self) -> Level:
        found: Level | None = self.__dict__.get("level")
        return Level(float(self.start)) if found is None else found

    def value(self, t: float) -> float:
        """See `TimeFunction`."""
        return self._level.value

    def integral(self, t: float) -> float:
        """See `TimeFunction`."""
        level = self._level
        return level.passed + level.value * (t - level.since)

    @property
    def rows(self) -> Sequence[tuple[float, float]]:
        """See `TimeFunction`; what a program will set is not known."""
        return ((0.0, float(self.start)),)
