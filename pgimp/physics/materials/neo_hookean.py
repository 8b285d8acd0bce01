"""Compressible neo-Hookean solid: s = mu/J (b - 1) + lambda ln J / J 1, b = F F^T."""

from math import log, sqrt
from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.jit.algebra import (
    cofactor,
    inverse,
    isotropic,
    largest_stretch_squared,
    left_cauchy_green,
)
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.physics.materials.base import Material, Poisson, Young, lame


class NeoHookeanParameters(NamedTuple):
    """Lame's constants and initial density."""

    lam: float
    mu: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """Cauchy stress."""
        r = 1.0 / J
        c = (material.lam * log(J) - material.mu) * r
        return isotropic(material.mu * r, left_cauchy_green(F), c)

    @staticmethod
    def piola(material, F, J):
        """First Piola-Kirchhoff stress P = mu F + (lambda ln J - mu)/J cof F."""
        t = (material.lam * log(J) - material.mu) / J
        return plus_scaled(t, cofactor(F), scaled(material.mu, F))

    @staticmethod
    def energy(material, F, J, sigma):
        """Strain energy mu/2 (tr b - 3) - mu ln J + lambda/2 (ln J)^2 per initial volume."""
        b = left_cauchy_green(F)
        ln = log(J)
        return (
            0.5 * material.mu * (b[0] + b[1] + b[2] - 3.0)
            - material.mu * ln
            + 0.5 * material.lam * ln * ln
        )

    @staticmethod
    def speed(material, F, J):
        """Longitudinal wave along the largest stretch s: rho0 c^2 = mu (s^2+1) + lambda (1-ln J).

        The acoustic tensor of direction n is mu |F^T n|^2 1 + (mu + lambda (1-ln J)) n (x) n. Where
        its second part is negative the shear wave, mu s^2, is the faster one.
        """
        s2 = largest_stretch_squared(left_cauchy_green(F))
        along = material.mu + material.lam * (1.0 - log(J))
        return sqrt((material.mu * s2 + max(along, 0.0)) / material.density)

    @staticmethod
    def initial_speed(material, F, J):
        """Longitudinal wave in the initial configuration; see `pgimp.kernels.update.speed`.

        With n along F^-T N the acoustic tensor is mu 1 + (mu + lambda (1-ln J)) |F^-T N|^2 n (x) n.
        """
        r2 = largest_stretch_squared(left_cauchy_green(inverse(F)))
        along = material.mu + material.lam * (1.0 - log(J))
        return sqrt((material.mu + r2 * max(along, 0.0)) / material.density)


class NeoHookean(Material):
    """Compressible neo-Hookean solid, for large elastic deformation."""

    INERTIA_ALONE: ClassVar[bool] = True
    ELASTIC: ClassVar[bool] = True
    PLANE_STRESS: ClassVar[bool] = True

    model: Literal["neo-hookean"] = Field(description="name of the model")
    young: Young
    poisson: Poisson

    def parameters(self) -> NeoHookeanParameters:
        """Parameters of the kernels."""
        return NeoHookeanParameters(*lame(self.young, self.poisson), self.density)
