"""Coulomb's law: surfaces slide where the tangential impulse exceeds mu times the normal one."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from pydantic import Field, model_validator

from pgimp.jit.kernel import kernel
from pgimp.physics.contact.base import ContactLaw
from pgimp.schema.base import Model, Number
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems

Coefficient = Annotated[Number, Field(ge=0.0)]


class Friction(Model):
    """Coulomb friction whose coefficient falls once surfaces slide."""

    static: Coefficient = Field(description="coefficient until surfaces slide [1]")
    kinetic: Coefficient = Field(description="coefficient while they do, at most the static [1]")

    @model_validator(mode="after")
    def _check_order(self) -> Friction:
        if self.kinetic > self.static:
            text = f"is above the static coefficient, {self.static:.15g}"
            raise_problems("friction", [Problem(("kinetic",), text)])
        return self


AnyFriction = Annotated[
    float | Friction,
    Either("a coefficient or {static: ..., kinetic: ...}", {float: Coefficient, dict: Friction}),
]


def coefficients(friction: float | Friction) -> tuple[float, float]:
    """Static and kinetic coefficient."""
    if isinstance(friction, Friction):
        return float(friction.static), float(friction.kinetic)
    return float(friction), float(friction)


@kernel
def coulomb_part(static, kinetic, cohesion, pressed, sticking):
    """Fraction of the tangential impulse of sticking that Coulomb's law transmits; 1: sticking.

    See `pgimp.physics.contact.base.Sliding`.
    """
    if sticking > static * pressed + cohesion:
        return (kinetic * pressed + cohesion) / sticking
    return 1.0


class CoulombParameters(NamedTuple):
    """Static and kinetic coefficient; see `Sliding`."""

    static: float
    kinetic: float

    @staticmethod
    def only_pressed(law):
        """See `Sliding`."""
        return True

    @staticmethod
    def sliding_part(law, cohesion, pressed, stress, sticking, slip):
        """Transmitted fraction of the tangential impulse of sticking."""
        return coulomb_part(law.static, law.kinetic, cohesion, pressed, sticking)

    @staticmethod
    def slope(law, pressed, stress, slip):
        """Derivative of the tangential impulse by the normal impulse during sliding."""
        return law.kinetic


class Coulomb(ContactLaw):
    """They cannot penetrate, slide under Coulomb's law, and part freely."""

    def parameters(self, entry: Any) -> CoulombParameters:
        """See `ContactLaw.parameters`."""
        return CoulombParameters(*coefficients(entry.friction))
