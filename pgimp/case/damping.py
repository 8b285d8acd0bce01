"""Damping of motion, for static solutions and for vibrations that die away."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pgimp.schema.base import Model, Number, Positive
from pgimp.schema.problems import problem


class Damping(Model):
    """Damping of all bodies: one of its kinds, or several together."""

    mass: Positive | None = Field(
        default=None,
        description="mass-proportional: forces -c m v at the vertices, c being this rate, so that "
        "a free motion falls as exp(-c t), and a vibration of the angular frequency w as "
        "exp(-c t/2); critical at c = 2 w [1/time]",
    )
    local: Annotated[Number, Field(gt=0, lt=1)] | None = Field(
        default=None,
        description="local (Cundall's): the part of the unbalanced force at a vertex, component by "
        "component, that acts against the velocity there; it needs no frequency, and leaves motion "
        "with balanced forces as it is [1]",
    )
    kinetic: bool = Field(
        default=False,
        description="kinetic: when the kinetic energy of all bodies has passed a peak, all "
        "velocities become zero",
    )

    @model_validator(mode="after")
    def _damps(self) -> Damping:
        if self.mass is None and self.local is None and not self.kinetic:
            raise problem("expected one of {mass: RATE}, {local: PART}, {kinetic: true}")
        return self
