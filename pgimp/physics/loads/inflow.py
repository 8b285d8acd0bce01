"""Material that enters at a given velocity: the entry in the case."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field

from pgimp.schema.base import Model, Positive
from pgimp.schema.tables import Varying
from pgimp.schema.time_functions import TimeFunction


class InflowEntry(Model):
    """Keeps the region of a body full of particles that move through it at a given velocity."""

    velocity: tuple[Varying, ...] = Field(
        description="velocity of what enters [length/time] along each direction: a number or a "
        "function of time; of one direction alone, in which it does not change its sign"
    )
    until: Positive | None = Field(
        default=None,
        description="when it ends: nothing enters any more, and what is in the region moves "
        "freely; null: never [time]",
    )

    def values(self, direction: int) -> Iterator[float]:
        """Yield the values of a component, among them the least and the greatest one."""
        component = self.velocity[direction]
        if isinstance(component, TimeFunction):
            yield from (value for _, value in component.rows)
        else:
            yield float(component)

    @property
    def axis(self) -> int:
        """The direction of the stream."""
        return next((d for d in range(len(self.velocity)) if any(self.values(d))), 0)

    @property
    def sign(self) -> float:
        """Whether it streams to higher (1) or to lower (-1) coordinates."""
        return -1.0 if min(self.values(self.axis)) < 0.0 else 1.0

    def travel(self, end: float) -> float:
        """Return how far what enters moves until `end`."""
        t = end if self.until is None else min(end, self.until)
        component = self.velocity[self.axis]
        moved = component.integral(t) if isinstance(component, TimeFunction) else component * t
        return abs(moved)
