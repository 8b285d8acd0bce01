"""A spring and dashpot to ground: the entry in the case."""

from __future__ import annotations

from pydantic import Field, model_validator

from pgimp.schema.base import Model, NonNegative, Vector
from pgimp.schema.problems import Problem, raise_problems


class Spring(Model):
    """A spring and dashpot to ground, alike along each direction in which they can act."""

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


class AnchoredSpring(Spring):
    """A spring and dashpot between the centre of mass of a rigid body and a point of ground."""

    to: Vector | None = Field(
        default=None,
        description="where the spring has no force; null: where the centre is at the start "
        "[length]",
    )
