"""Newtonian fluid, weakly compressible: s = -p 1 + 2 mu dev(D), p by Tait's equation of state.

Expanded fluid without tension, J > 1, consists of fluid and voids. The fluid is 1/J of the volume,
and carries the viscous stress.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.jit.algebra import contract, isotropic, symmetric
from pgimp.physics.materials.base import State
from pgimp.physics.materials.exact.flow import moves, viscous, volumes
from pgimp.physics.materials.laws.tait import (
    MIN_J,
    VISCOUS_WORK,
    Liquid,
    compression,
    pressure,
    sound_squared,
)


class InviscidParameters(NamedTuple):
    """K/g, exponent g, least pressure and initial density."""

    stiffness: float
    exponent: float
    least: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """Pressure from the volume."""
        p = pressure(material.stiffness, material.exponent, material.least, 1.0 / J)
        return isotropic(0.0, symmetric(L), -p)

    @staticmethod
    def energy(material, F, J, sigma):
        """Energy of the compression per initial volume."""
        return compression(material.stiffness, material.exponent, material.least, J)

    @staticmethod
    def speed(material, F, J):
        """Speed of sound."""
        return sqrt(sound_squared(material.stiffness, material.exponent, material.density, J))

    @staticmethod
    def margin(material, F, J, sigma):
        """How far it is from a compression at which it is no liquid."""
        return J - MIN_J


class NewtonianParameters(NamedTuple):
    """K/g, exponent g, least pressure, shear viscosity and initial density."""

    stiffness: float
    exponent: float
    least: float
    mu: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Pressure from the volume, viscous stress from the rate of deformation, and its work."""
        D, r = symmetric(L), 1.0 / J
        twice = 2.0 * material.mu * min(r, 1.0)
        rate = D[0] + D[1] + D[2]
        power = twice * (contract(D, D) - rate * rate * (1.0 / 3.0))
        p = pressure(material.stiffness, material.exponent, material.least, r)
        stress = isotropic(twice, D, -p - twice * rate * (1.0 / 3.0))
        return stress, (state[0] + J * dt * power,)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Energy of the compression per initial volume."""
        return compression(material.stiffness, material.exponent, material.least, J)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Work of the viscous stress."""
        return 0.0, state[0], 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Speed of sound."""
        return sqrt(sound_squared(material.stiffness, material.exponent, material.density, J))

    @staticmethod
    def diffusivity(material, F, J, state):
        """Momentum diffusivity mu/rho, with rho the density of the fluid without voids."""
        return material.mu / material.density * min(J, 1.0)

    @staticmethod
    def margin(material, F, J, sigma, state):
        """How far it is from a compression at which it is no liquid."""
        return J - MIN_J


class Newtonian(Liquid):
    """Weakly compressible Newtonian fluid."""

    LOSSES: ClassVar[tuple[str, ...]] = ("viscous-work",)
    STATE: ClassVar[tuple[State, ...]] = (VISCOUS_WORK,)

    model: Literal["newtonian"] = Field(description="name of the model")

    @property
    def states(self) -> tuple[State, ...]:
        """State variables; none without viscosity."""
        return self.STATE if self.shear_viscosity else ()

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        J = volumes(path, value, self.exact_volume(confine))
        if J is None:
            return None
        part = 1.0 / np.maximum(J, 1.0)
        rates = rate * moves(value)
        return viscous(path, self.exact_pressure(J), part, self.shear_viscosity, rates)

    def parameters(self) -> NewtonianParameters | InviscidParameters:
        """Parameters of the kernels."""
        law = self.stiffness, self.exponent, self.least
        if not self.shear_viscosity:
            return InviscidParameters(*law, self.density)
        return NewtonianParameters(*law, self.shear_viscosity, self.density)
