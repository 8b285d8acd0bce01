"""Friction of soils: angles of the case, and the cone of Drucker and Prager that fits them.

p is the pressure, tau the root of J2; the cone is tau = alpha p + k.
"""

from math import cos, inf, radians, sin, sqrt, tan
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from pgimp.physics.materials.base import Material, Poisson, State, Young, lame
from pgimp.schema.base import NonNegative
from pgimp.schema.problems import Problem, raise_problems

PLASTIC_WORK = State("plastic-work", "energy/volume", "plastic work, by initial volume")

Match = Literal["plane-strain", "plane-strain-flow", "compression", "extension"]


def slope(angle: float, match: Match) -> float:
    """Slope of the cone for an angle of friction, or of dilation, in degrees.

    In plane strain it assumes flow along the normal; see `cone_of` for other flow.
    """
    a = radians(angle)
    if match in ("plane-strain", "plane-strain-flow"):
        return 3.0 * tan(a) / sqrt(9.0 + 12.0 * tan(a) ** 2)
    side = 3.0 - sin(a) if match == "compression" else 3.0 + sin(a)
    return 6.0 * sin(a) / (sqrt(3.0) * side)


def cone_of(soil: "Soil", match: Match) -> tuple[float, float, float]:
    """Slope alpha of the cone, slope of its flow, strength k without pressure.

    With the slope d of flow, plane strain flow has s_zz = -2 d tau/3. Half the difference of the
    principal stresses in the plane is then tau sqrt(1 - d d/3); their mean pressure is p - d tau/3.
    With ``plane-strain-flow`` these are on Mohr and Coulomb's line,

        alpha = sin(phi)/D, k = c cos(phi)/D, D = sqrt(1 - d d/3) + d sin(phi)/3;

    which equals ``plane-strain`` for a flow along the normal.
    """
    a = radians(soil.friction_angle)
    flow = slope(soil.dilation_angle, match)
    if match == "plane-strain-flow":
        part = sqrt(1.0 - flow * flow / 3.0) + flow * sin(a) / 3.0
        return sin(a) / part, flow, soil.cohesion * cos(a) / part
    alpha = slope(soil.friction_angle, match)
    if match == "plane-strain":
        return alpha, flow, 3.0 * soil.cohesion / sqrt(9.0 + 12.0 * tan(a) ** 2)
    side = 3.0 - sin(a) if match == "compression" else 3.0 + sin(a)
    return alpha, flow, 6.0 * soil.cohesion * cos(a) / (sqrt(3.0) * side)


class Soil(Material):
    """Base of soils with cohesion, friction and dilation."""

    INERTIA_ALONE: ClassVar[bool] = True
    RESTS: ClassVar[bool] = True
    SPELLINGS: ClassVar[dict[str, str]] = {
        "friction_angle": "friction-angle",
        "dilation_angle": "dilation-angle",
    }

    young: Young
    poisson: Poisson
    cohesion: NonNegative = Field(description="shear strength without pressure, c [stress]")
    friction_angle: NonNegative = Field(
        alias="friction-angle", lt=90.0, description="angle of internal friction [degrees]"
    )
    dilation_angle: NonNegative = Field(
        alias="dilation-angle",
        default=0.0,
        lt=90.0,
        description="angle of dilation, at most that of friction: shear makes the soil swell, "
        "without end [degrees]",
    )
    tension: NonNegative | None = Field(
        default=None,
        description="greatest tension that it bears, at most cohesion/tan(friction-angle), which "
        "is that of null [stress]",
    )

    @property
    def apex(self) -> float:
        """Isotropic tension at the apex of the strength, from friction and cohesion."""
        if self.friction_angle == 0.0:
            return inf if self.cohesion > 0.0 else 0.0
        return self.cohesion / tan(radians(self.friction_angle))

    @property
    def greatest_tension(self) -> float:
        """Greatest tension of the soil."""
        return self.apex if self.tension is None else self.tension

    @property
    def flow_speed(self) -> float:
        """See `Material.flow_speed`; soil with any tensile strength is not loose."""
        if self.greatest_tension > 0.0 or any(path[0] == "cohesion" for path in self._variations):
            return 0.0
        lam, mu = lame(self.young, self.poisson)
        return sqrt((lam + 2.0 * mu) / self.density)

    @property
    def needs_pressure(self) -> bool:
        """See `Material.needs_pressure`; true without cohesion."""
        return self.cohesion == 0.0

    @model_validator(mode="after")
    def _check(self) -> "Soil":
        if self.cohesion == 0.0 and self.friction_angle == 0.0:
            text = "without friction (friction-angle: 0) it must be above 0: the soil has no other "
            raise_problems("soil", [Problem(("cohesion",), f"{text}strength")])
        if self.dilation_angle > self.friction_angle:
            text = (
                f"is above the friction-angle, {self.friction_angle:g}: such a soil would make "
                "energy from nothing; sand has about friction-angle - 30, clay 0"
            )
            raise_problems("soil", [Problem(("dilation-angle",), text)])
        if self.tension is not None and self.tension > self.apex * (1.0 + 1e-12):
            text = (
                "a soil without cohesion bears none; leave it out, or give it a cohesion"
                if self.cohesion == 0.0
                else f"is above cohesion/tan(friction-angle) = {self.apex:.6g}, the most that "
                "cohesion and friction bear"
            )
            raise_problems("soil", [Problem(("tension",), text)])
        return self
