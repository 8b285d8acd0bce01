"""The start of a run: the state in which it begins at time 0."""

from __future__ import annotations

from collections.abc import Mapping
from math import radians, sin
from typing import Annotated, Any, Literal

from pydantic import Field

from pgimp.physics.loads.own_stress import OwnStress
from pgimp.schema.base import Count, Model, Name, NonNegative, Number
from pgimp.schema.dispatch import Either, WithKey

#: K0 by Jaky, for ground that was never loaded otherwise.
JAKY = "1-sin-phi"

Ratio = Annotated[
    float | Literal["1-sin-phi"],
    Either("a number or 1-sin-phi", {float: NonNegative, str: Literal["1-sin-phi"]}),
]


def friction_angle(material: Any) -> float | None:
    """Angle of internal friction of a material, in degrees; None without one."""
    angle: float | None = getattr(material, "friction_angle", None)
    return angle


class InitialStress(Model):
    """The stress of the weight above each particle, as level ground at rest has it."""

    k0: Annotated[
        float | str | Mapping[str, float | str],
        Either(
            "a number, 1-sin-phi, or {BODY: ...}",
            {float: NonNegative, str: Literal["1-sin-phi"], dict: dict[Name, Ratio]},
        ),
    ] = Field(
        description="horizontal over vertical stress: a number; 1-sin-phi (Jaky), by the "
        "friction-angle of the material; or by body, {sand: 1-sin-phi, rock: 1.0}; fluids have "
        "their pressure [1]"
    )
    ocr: Annotated[Number, Field(ge=1.0)] | None = Field(
        default=None,
        description="overconsolidation ratio of cam-clay: its preconsolidation is that which just "
        "bears the stress, times this; null: as the material says [1]",
    )
    surcharge: tuple[Name, ...] = Field(
        default=(),
        description="names of tractions that have lain on the ground for long: where they press on "
        "surfaces that face upwards, their values at time 0 add to the weight above",
    )

    def begins(self, body: str) -> bool:
        """Whether a body begins with the stress."""
        return True

    def ratio(self, body: str, material: Any) -> float:
        """Return k0 of a body and its material."""
        value = self.k0[body] if isinstance(self.k0, Mapping) else self.k0
        if value == JAKY:
            return 1.0 - sin(radians(friction_angle(material) or 0.0))
        return float(value)


class Settle(Model):
    """Steps before time 0 until all bodies are at rest under the loads of time 0."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=1e-4,
        description="at rest is where the sum over the vertices of the magnitude of the unbalanced "
        "force is below this part of twice that of the loads (weight, tractions, given forces), "
        "which is that of a column's loads and of what bears them; or of a hundredth of the forces "
        "of stresses, if that is more; with body-force, of these; and where less than ten times "
        "this part of the way is left [1]",
    )
    steps: Count = Field(
        default=100000,
        description="most steps; without rest after them, or where forces no longer come nearer to "
        "balance, the run ends with an error",
    )


class StartEntry(Model):
    """The start of a run."""

    stress: Annotated[
        InitialStress | OwnStress | None,
        Either(
            "{k0: ...}, {function: ...} or null",
            {dict: WithKey("function", OwnStress, InitialStress), None: None},
        ),
    ] = Field(
        default=None,
        description="geostatic: bodies begin with the stress of the weight above each particle, or "
        "with that of a function of one's own, and with what of deformation and state belongs to "
        "it; before `equilibrate`. null: none",
    )

    equilibrate: Settle | None = Field(
        default=None,
        description="before time 0 the run comes to rest under the loads of time 0, in steps as "
        "long as is stable, with a damping that finds its own strength; then time, velocities, "
        "displacements and history begin at 0, with the stresses found. {} takes the defaults; "
        "null: none",
    )
