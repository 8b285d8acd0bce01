"""Bingham's fluid: rigid below a yield stress, viscous above it, p by Tait's equation of state.

Below the yield stress the fluid is elastic, with a shear modulus G so high that it hardly deforms.
With tau the root of J2, the elastic trial stress tau_tr of a step
(`pgimp.physics.materials.laws.hencky`) relaxes towards the yield stress,

    tau = (tau_tr + (G dt/mu) tau_y)/(1 + G dt/mu)  where tau_tr > tau_y,

implicit Euler for d tau/dt = G (rate - (tau - tau_y)/mu). The plug is exact, and the viscosity
does not limit the step. In steady flow tau = tau_y + mu rate for any G.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.jit.algebra import isotropic
from pgimp.physics.materials.base import Positive, State
from pgimp.physics.materials.exact.flow import isotropic_columns, sheared, volumes
from pgimp.physics.materials.laws.hencky import distortion_energy, elastic_trial
from pgimp.physics.materials.laws.invariants import TINY, shear_stress
from pgimp.physics.materials.laws.tait import (
    MIN_J,
    VISCOUS_WORK,
    Liquid,
    compression,
    pressure,
    sound_squared,
)
from pgimp.schema.problems import Problem, raise_problems

#: Default of the shear modulus, over the bulk modulus.
_STIFF = 0.5


class BinghamParameters(NamedTuple):
    """K/g, exponent g, least pressure, G, viscosity, yield stress and initial density."""

    stiffness: float
    exponent: float
    least: float
    shear: float
    mu: float
    strength: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Pressure from the volume, and deviator, elastic up to the yield stress."""
        s = elastic_trial(material.shear, J, sigma, L, dt)  # Kirchhoff stress, J times Cauchy's
        trial = shear_stress(s)
        whole = min(J, 1.0)  # without voids
        mu, strength = material.mu * whole, material.strength * whole
        elastic = material.shear * dt
        tau = min(trial, (mu * trial + elastic * strength) / (mu + elastic))
        r = 1.0 / J
        p = pressure(material.stiffness, material.exponent, material.least, r)
        work = state[0] + tau * (trial - tau) / material.shear
        return isotropic(r * tau / (trial + TINY), s, -p), (work,)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Energy of the compression and of the elastic shear per initial volume."""
        volume = compression(material.stiffness, material.exponent, material.least, J)
        return volume + distortion_energy(material.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Work of the stress in flow."""
        return 0.0, state[0], 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave: K + 4 G/3."""
        square = sound_squared(material.stiffness, material.exponent, material.density, J)
        return sqrt(square + 4.0 / 3.0 * material.shear / material.density)

    @staticmethod
    def margin(material, F, J, sigma, state):
        """Distance from the greatest compression of a liquid."""
        return J - MIN_J


class Bingham(Liquid):
    """Fluid with a yield stress: mud, fresh concrete, paste, lava."""

    CARRIES_STRESS: ClassVar[bool] = True
    CARRIES_PRESSURE: ClassVar[bool] = False
    LOSSES: ClassVar[tuple[str, ...]] = ("viscous-work",)
    STATE: ClassVar[tuple[State, ...]] = (VISCOUS_WORK,)
    SPELLINGS: ClassVar[dict[str, str]] = {**Liquid.SPELLINGS, "yield_stress": "yield-stress"}

    model: Literal["bingham"] = Field(description="name of the model")
    yield_stress: Positive = Field(
        alias="yield-stress", description="shear stress below which it does not flow [stress]"
    )
    shear: Positive | None = Field(
        default=None,
        description="shear modulus G below the yield stress, which only has to be so high that "
        "yield-stress/G and shear-viscosity/G, strain and time, are small; null: half of bulk "
        "[stress]",
    )

    @model_validator(mode="after")
    def _check(self) -> "Bingham":
        if self.yield_stress > self.modulus:
            text = (
                f"the fluid would be sheared by {self.yield_stress / self.modulus:.2g} before it "
                f"flows: take a shear modulus (shear, now {self.modulus:g}) a hundred times the "
                "yield stress, or a greater bulk modulus"
            )
            raise_problems("bingham", [Problem(("yield-stress",), text)])
        return self

    @property
    def modulus(self) -> float:
        """Shear modulus."""
        return _STIFF * self.bulk if self.shear is None else self.shear

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        before = self.exact_volume(confine)
        J = volumes(path, value, before)
        if J is None or path not in ("isotropic", "simple-shear"):
            return None
        pressure = self.exact_pressure(J)
        if path == "isotropic":
            return isotropic_columns(pressure)
        strength, mu = self.yield_stress, self.shear_viscosity

        def law(part: float) -> float:
            return strength + mu * rate * part

        return sheared(value, float(pressure[0]), self.modulus, before, strength, law)

    def parameters(self) -> BinghamParameters:
        """Parameters of the kernels."""
        volume = self.stiffness, self.exponent, self.least
        shear = self.modulus, self.shear_viscosity, self.yield_stress
        return BinghamParameters(*volume, *shear, self.density)
