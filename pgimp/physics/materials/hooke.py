"""Hypoelastic Hooke's law, integrated after Hughes and Winget (1980) about the mid-point.

The step's velocity gradient L refers to the step's beginning. Referred to the mid-point
configuration it is G = L (1 + dt/2 L)^-1. The strain increment is dt sym(G). The stress is turned
by Q = (1 - dt/2 W)^-1 (1 + dt/2 W), W = skew(G), a rotation to rounding. sym(L) in place of sym(G)
would add a spurious strain of order (dt W)^2/2 in every step of a rotation.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.jit.algebra import (
    add,
    contract,
    inverse,
    isotropic,
    multiply,
    one_plus,
    rotate,
    skew,
    symmetric,
)
from pgimp.physics.materials.base import Material, Poisson, Young, lame


class HookeParameters(NamedTuple):
    """Lame's constants and initial density."""

    lam: float
    mu: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """Q sigma Q^T plus the increment lambda tr(D) 1 + 2 mu D, D = dt sym(G)."""
        G = multiply(L, inverse(one_plus(0.5 * dt, L)))
        W = skew(G)
        Q = multiply(inverse(one_plus(-0.5 * dt, W)), one_plus(0.5 * dt, W))
        D = symmetric(G)
        trace = dt * (D[0] + D[1] + D[2])
        return add(rotate(Q, sigma), isotropic(2.0 * material.mu * dt, D, material.lam * trace))

    @staticmethod
    def energy(material, F, J, sigma):
        """Elastic energy sigma : C^-1 : sigma / 2 of the current stress, per initial volume."""
        trace = sigma[0] + sigma[1] + sigma[2]
        bulk = 3.0 * material.lam + 2.0 * material.mu
        return 0.25 * J / material.mu * (contract(sigma, sigma) - material.lam / bulk * trace**2)

    @staticmethod
    def speed(material, F, J):
        """Longitudinal wave: rho c^2 = lambda + 2 mu with the current density rho0/J."""
        return sqrt((material.lam + 2.0 * material.mu) * J / material.density)


class Hooke(Material):
    """Linear elasticity in rate form, for small strains and any rotation."""

    INERTIA_ALONE: ClassVar[bool] = True
    CARRIES_STRESS: ClassVar[bool] = True
    ELASTIC: ClassVar[bool] = True
    PLANE_STRESS: ClassVar[bool] = True

    model: Literal["hooke"] = Field(description="name of the model")
    young: Young
    poisson: Poisson

    def parameters(self) -> HookeParameters:
        """Parameters of the kernels."""
        return HookeParameters(*lame(self.young, self.poisson), self.density)
