"""A spring and dashpot to ground: the entry in the case."""

from __future__ import annotations

from pydantic import Field, model_validator

from pgimp.schema.base import Model, NonNegative
from pgimp.schema.problems import Problem, raise_problems


class Spring(Model):
    """A spring and dashpot to ground, alike along each direction that a force controls."""

    stiffness: NonNegative = Field(
        description="force by displacement since the start [force/length]"
    )
    dashpot: NonNegative = Field(default=0.0, description="force by velocity [force time/length]")

    @model_validator(mode="after")
    def _check_any(self) -> Spring:
        if not (self.stiffness or self.dashpot):
            text = "expected a stiffness above 0, or a dashpot: this spring has no force"
            raise_problems("Spring", [Problem(("stiffness",), text)])
        return self
