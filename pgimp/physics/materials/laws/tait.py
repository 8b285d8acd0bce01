"""Tait's equation of state of weakly compressible fluids, p = K/g ((rho/rho0)^g - 1)."""

from math import inf, log, sqrt
from typing import ClassVar

import numpy as np
from pydantic import Field

from pgimp.jit.functions import power
from pgimp.jit.kernel import inlined
from pgimp.physics.materials.base import Material, State
from pgimp.schema.base import NonNegative, Number, Positive

#: Smallest J: no liquid reaches twice its density, and with g = 7 the pressure there is 18 K.
MIN_J = 0.5

VISCOUS_WORK = State("viscous-work", "energy/volume", "work of viscous stresses, by initial volume")

#: The exponent of water, whose power is computed without a logarithm.
_WATER = 7.0


@inlined
def raised(r, exponent):
    """The power r^exponent of positive r; fast for the exponents 1 and 7."""
    if exponent == _WATER:
        square = r * r
        fourth = square * square
        return fourth * square * r
    return r if exponent == 1.0 else power(r, exponent)


@inlined
def pressure(stiffness, exponent, least, r):
    """Pressure at r = rho/rho0, at least `least`, the negative of the greatest tension.

    `stiffness` is K/g.
    """
    return max(stiffness * (raised(r, exponent) - 1.0), least)


@inlined
def sound_squared(stiffness, exponent, density, J):
    """Square of the speed of sound, c^2 = dp/drho; in expanded fluid the value at rest.

    Fluid without pressure transmits no waves, but it may be compressed again at any moment.
    """
    whole = min(J, 1.0)
    return stiffness * exponent / density * raised(1.0 / whole, exponent) * whole


@inlined
def compression(stiffness, exponent, least, J):
    """Energy of a compression to J, per initial volume; for `energy`, scalar only."""
    if least == 0.0:
        J = min(J, 1.0)
    if exponent == 1.0:
        return stiffness * (J - 1.0 - log(J))
    return stiffness * ((J * raised(1.0 / J, exponent) - 1.0) / (exponent - 1.0) + J - 1.0)


class Liquid(Material):
    """Base of fluids with Tait's equation of state."""

    VOLUME_ONLY: ClassVar[bool] = True
    LIQUID: ClassVar[bool] = True
    RESTS: ClassVar[bool] = True
    SPELLINGS: ClassVar[dict[str, str]] = {"shear_viscosity": "shear-viscosity"}

    bulk: Positive = Field(
        description="bulk modulus at rest K, a hundred times the greatest density times velocity "
        "squared, or more; only as great as need be: the step goes with its root [stress]"
    )
    shear_viscosity: NonNegative = Field(
        alias="shear-viscosity", default=0.0, description="shear viscosity mu [stress time]"
    )
    exponent: Number = Field(
        ge=1.0,
        le=20.0,
        default=7.0,
        description="g in p = K/g ((density/initial density)^g - 1); 7 is that of water [1]",
    )
    tension: bool = Field(
        default=False,
        description="whether it can pull, p < 0: a free surface that can draws strings and tears",
    )

    @property
    def flow_speed(self) -> float:
        """See `Material.flow_speed`."""
        return float(sqrt(self.bulk / self.density))

    @property
    def most_filled(self) -> float:
        """See `Material.most_filled`; unlimited for a liquid with tension.

        A little above 1: with a limit of 1, each oscillation would compress the rest.
        """
        return inf if self.tension else 1.01

    @property
    def stiffness(self) -> float:
        """K/g."""
        return self.bulk / self.exponent

    @property
    def least(self) -> float:
        """Least pressure."""
        return -inf if self.tension else 0.0

    def exact_pressure(self, J: np.ndarray) -> np.ndarray:
        """Pressure at volume ratios J."""
        return np.maximum(self.stiffness * (J**-self.exponent - 1.0), self.least)

    def exact_volume(self, pressure: float) -> float:
        """J under a pressure."""
        return float((1.0 + pressure / self.stiffness) ** (-1.0 / self.exponent))

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """See `Material.out_of_range`."""
        return (
            f"is compressed to {J:.3g} of its volume, where a liquid is none (at least {MIN_J:g})",
            f"a greater bulk modulus than {self.bulk:g}: a hundred times the density times the "
            "square of the greatest velocity; smaller steps (time.step); bodies or tools that "
            "begin apart",
        )
