"""Grips: parts of bodies that move as prescribed, or by a given force; the entry in the case."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field, model_validator

from pgimp.geometry.regions import RegionEntry
from pgimp.physics.loads.motion import zero_vector
from pgimp.physics.loads.spring import Spring
from pgimp.schema.base import Model, Name, NonNegative
from pgimp.schema.problems import Problem, raise_problems
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
    velocity: tuple[Component, ...] = zero_vector(
        "velocity [length/time] along each direction: a number, a table over time, "
        "or null where the component is free, or has a force"
    )
    force: tuple[Component, ...] = zero_vector(
        "force [force] along each direction, in place of a velocity there: the particles move as "
        "one, with the velocity that it gives them; a number, a table over time, or null"
    )
    mass: NonNegative = Field(
        default=0.0, description="mass that moves with them where they have a force [mass]"
    )
    spring: Spring | None = Field(
        default=None, description="a spring and dashpot to ground, where they have a force"
    )

    @model_validator(mode="after")
    def _check_motion(self) -> ConstraintEntry:
        found = []
        if not (self.velocity or self.force):
            found.append(Problem(("velocity",), "expected a velocity or a force"))
        for d, (v, f) in enumerate(zip(self.velocity, self.force, strict=False)):
            if v is not None and f is not None:
                text = "expected null here, or a velocity of null: one of the two gives the motion"
                found.append(Problem(("force", d), text))
        if not any(f is not None for f in self.force):
            for key in ("mass", "spring"):
                if getattr(self, key):
                    text = "is for directions with a force; give one, as force: [0.0, null]"
                    found.append(Problem((key,), text))
        raise_problems("constraint", found)
        return self

    @property
    def motion(self) -> tuple[Component, ...]:
        """The prescribed velocity along each direction, None where there is none."""
        return self.velocity or (None,) * len(self.force)

    @property
    def forces(self) -> tuple[Component, ...]:
        """The given force along each direction, None where there is none."""
        return self.force or (None,) * len(self.velocity)

    @property
    def rigid(self) -> tuple[bool, ...]:
        """Along which directions the particles move as one."""
        each = zip(self.motion, self.forces, strict=False)
        return tuple(v is not None or f is not None for v, f in each)

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time."""
        return any(isinstance(component, TimeFunction) for component in self.velocity)

    def parameters(self, start: float, end: float) -> Constraint:
        """Parameters of the kernels for a step from `start` to `end`, without given forces."""
        return Constraint(*prescribed(self.velocity, start, end))

    def displacement(self, t: float) -> tuple[float | None, ...]:
        """Return the displacement prescribed from time 0 to `t`, None for other components."""
        return tuple(
            v.integral(t) if isinstance(v, TimeFunction) else None if v is None else v * t
            for v in self.motion
        )
