"""Prescribed motion of a part of a body: the entry in the case."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from pgimp.geometry.regions import RegionEntry
from pgimp.schema.base import Model, Name
from pgimp.schema.tables import Component, prescribed
from pgimp.schema.time_functions import TimeFunction


class Constraint(NamedTuple):
    """A constraint in one step: held components, velocity at its end, mean acceleration."""

    held: tuple[bool, bool, bool]
    velocity: tuple[float, float, float]
    rate: tuple[float, float, float]


class ConstraintEntry(Model):
    """Holds the particles of a body that are in a region at the start, and moves them."""

    body: Name = Field(description="name of the body")
    region: RegionEntry = Field(
        description="its particles with their centre in here at the start are held"
    )
    velocity: tuple[Component, ...] = Field(
        description="velocity [length/time] along each direction: a number, a table over time, "
        "or null where the component is free"
    )

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time."""
        return any(isinstance(component, TimeFunction) for component in self.velocity)

    def parameters(self, start: float, end: float) -> Constraint:
        """Parameters of the kernels for a step from `start` to `end`."""
        return Constraint(*prescribed(self.velocity, start, end))

    def displacement(self, t: float) -> tuple[float | None, ...]:
        """Return the displacement prescribed from time 0 to `t`, None for free components."""
        return tuple(
            v.integral(t) if isinstance(v, TimeFunction) else None if v is None else v * t
            for v in self.velocity
        )
