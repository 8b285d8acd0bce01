"""The paper's one-dimensional hyperelastic bar: s = E (F - 1) (41)."""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.physics.materials.base import Material, Young


class Linear1dParameters(NamedTuple):
    """Young's modulus E and initial density."""

    young: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """Axial stress (41); uniaxial, so the lateral stresses are zero."""
        return material.young * (F[0] - 1.0), 0.0, 0.0

    @staticmethod
    def energy(material, F, J, sigma):
        """Strain energy E (F - 1)^2/2 per initial volume."""
        return 0.5 * material.young * (F[0] - 1.0) * (F[0] - 1.0)

    @staticmethod
    def speed(material, F, J):
        """Speed F sqrt(E/rho0) through the deformed bar."""
        return F[0] * sqrt(material.young / material.density)

    @staticmethod
    def initial_speed(material, F, J):
        """Speed sqrt(E/rho0) in the initial configuration; see `pgimp.kernels.update.speed`."""
        return sqrt(material.young / material.density)


class Linear1d(Material):
    """Bar of unit cross-section, stress linear in the stretch; only in one dimension."""

    INERTIA_ALONE: ClassVar[bool] = True
    ELASTIC: ClassVar[bool] = True

    model: Literal["linear-1d"] = Field(description="name of the model")
    young: Young

    DIMENSIONS: ClassVar[tuple[int, ...]] = (1,)

    def parameters(self) -> Linear1dParameters:
        """Parameters of the kernels."""
        return Linear1dParameters(self.young, self.density)
