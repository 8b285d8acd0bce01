"""A material from outside the package: a weakly compressible Newtonian fluid, which cannot pull.

    pgimp --import cases/fluid.py my-case.yaml

with ``model: fluid`` in the case, or ``import fluid`` before `pgimp.run` in a program.
"""

from math import log, sqrt
from typing import Literal, NamedTuple

from pydantic import Field

import pgimp
from pgimp.jit.algebra import isotropic, symmetric
from pgimp.physics.materials import Material, NonNegative, Positive


class FluidParameters(NamedTuple):
    """What the kernels see: bulk modulus, shear viscosity, initial density."""

    bulk: float
    shear: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """Pressure K (1/J - 1), none in tension, and the shear 2 mu dev(D)."""
        D = symmetric(L)
        mean = (D[0] + D[1] + D[2]) / 3.0
        pressure = max(material.bulk * (1.0 / J - 1.0), 0.0)
        return isotropic(2.0 * material.shear, D, -pressure - 2.0 * material.shear * mean)

    @staticmethod
    def energy(material, F, J, sigma):
        """Work of the pressure, K (J - 1 - ln J) in compression, per initial volume."""
        J = min(J, 1.0)
        return material.bulk * (J - 1.0 - log(J))

    @staticmethod
    def speed(material, F, J):
        """Sound: c^2 = dp/drho = K/rho0."""
        return sqrt(material.bulk / material.density)


@pgimp.register_material
class Fluid(Material):
    """Weakly compressible Newtonian fluid without tension."""

    model: Literal["fluid"] = Field(description="name of the model")
    bulk: Positive = Field(description="bulk modulus [stress]")
    shear: NonNegative = Field(description="shear viscosity [stress time]")

    def parameters(self) -> FluidParameters:
        """Parameters of the kernels."""
        return FluidParameters(self.bulk, self.shear, self.density)
