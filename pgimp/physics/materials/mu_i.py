"""Grains that flow: friction mu(I) of the inertial number I.

After Dunatunga and Kamrin, Continuum modelling and simulation of granular flows through their many
phases, J. Fluid Mech. 779, 483-513 (2015).

With p the pressure, tau the root of J2 and I = rate d sqrt(rho_s/p),

    tau = mu(I) p,  mu(I) = mu_s + (mu_2 - mu_s)/(I0/I + 1)  where the grains flow.

In a step from the elastic trial stress tau_tr, rate = (tau_tr - tau)/(G dt), so that tau solves

    tau^2 - b tau + h = 0,  b = mu_2 p + tau_tr + a,  h = mu_2 p tau_tr + mu_s p a,
    a = G dt I0 sqrt(p/rho_s)/d,

a closed form, stable at any rate. Grains farther apart than at the start, J > 1, do not touch and
have no stress. p = K (1/J - 1) depends only on the volume, so a heap does not swell.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.jit.algebra import isotropic
from pgimp.jit.choose import choose
from pgimp.jit.functions import log
from pgimp.physics.materials.base import Material, Poisson, State, Young, lame
from pgimp.physics.materials.exact.flow import isotropic_columns, sheared, volumes
from pgimp.physics.materials.laws.friction import PLASTIC_WORK
from pgimp.physics.materials.laws.hencky import distortion_energy, elastic_trial
from pgimp.physics.materials.laws.invariants import TINY, shear_stress
from pgimp.physics.materials.laws.tait import MIN_J
from pgimp.schema.base import NonNegative, Positive
from pgimp.schema.problems import Problem, raise_problems


class MuIParameters(NamedTuple):
    """Moduli K and G, mu_s and mu_2, I0 sqrt(1/rho_s)/d, density."""

    bulk: float
    shear: float
    still: float
    fast: float
    inertia: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Stress of grains at rest or flowing, zero for separated grains; plastic shear."""
        s = elastic_trial(material.shear, J, sigma, L, dt)  # J times Cauchy's
        trial = shear_stress(s) / J
        p = material.bulk * max(1.0 / J - 1.0, 0.0)
        least, most = material.still * p, material.fast * p
        a = material.shear * dt / J * material.inertia * sqrt(p)
        b = most + trial + a
        h = most * trial + least * a
        flowing = 2.0 * h / (b + sqrt(max(b * b - 4.0 * h, 0.0)) + TINY)
        tau = choose(trial > least, flowing, trial)
        slip = J * (trial - tau) / material.shear
        stress = isotropic(tau / (J * (trial + TINY)), s, -p)
        return stress, (state[0] + slip, state[1] + J * tau * slip)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        J0 = min(J, 1.0)
        volume = material.bulk * (J0 - 1.0 - log(J0))
        return volume + distortion_energy(material.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Work of friction."""
        return state[1], 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave; separated grains have the speed of touching grains."""
        return sqrt((material.bulk + 4.0 / 3.0 * material.shear) / material.density)

    @staticmethod
    def margin(material, F, J, sigma, state):
        """Distance from the greatest compression of grains."""
        return J - MIN_J


class MuI(Material):
    """Dry grains that flow, with the friction of the inertial number."""

    VOLUME_ONLY: ClassVar[bool] = True
    RESTS: ClassVar[bool] = True
    CARRIES_STRESS: ClassVar[bool] = True
    CARRIES_PRESSURE: ClassVar[bool] = False
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work",)
    SPELLINGS: ClassVar[dict[str, str]] = {
        "mu_s": "mu-s",
        "mu_2": "mu-2",
        "grain_density": "grain-density",
    }
    STATE: ClassVar[tuple[State, ...]] = (
        State("plastic-shear", "1", "sum of the plastic shear strain, as of simple shear"),
        PLASTIC_WORK,
    )

    model: Literal["mu-i"] = Field(description="name of the model")
    young: Young
    poisson: Poisson
    mu_s: NonNegative = Field(alias="mu-s", description="coefficient of friction at rest [1]")
    mu_2: Positive = Field(alias="mu-2", description="coefficient of friction of fast flow [1]")
    i0: Positive = Field(description="inertial number at which it is half-way between them [1]")
    grain: Positive = Field(description="diameter of a grain [length]")
    grain_density: Positive = Field(
        alias="grain-density", description="density of the grains, above `density` [mass/volume]"
    )

    @model_validator(mode="after")
    def _check(self) -> "MuI":
        if self.mu_2 < self.mu_s:
            text = f"is below the coefficient at rest, mu-s = {self.mu_s:g}: flow would run away"
            raise_problems("mu-i", [Problem(("mu-2",), text)])
        if self.grain_density < self.density:
            text = f"is below the density of the heap, {self.density:g}, with the voids in it"
            raise_problems("mu-i", [Problem(("grain-density",), text)])
        return self

    @property
    def needs_pressure(self) -> bool:
        """See `Material.needs_pressure`."""
        return True

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """See `Material.out_of_range`."""
        return (
            f"is compressed to {J:.3g} of its volume, which grains are not (at least {MIN_J:g})",
            f"a greater modulus than young: {self.young:g}, a hundred times the greatest pressure; "
            "smaller steps (time.step)",
        )

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        lam, G = lame(self.young, self.poisson)
        K = lam + 2.0 / 3.0 * G
        before = K / (K + confine)
        J = volumes(path, value, before)
        if J is None or path not in ("isotropic", "simple-shear"):
            return None
        if path == "isotropic":
            return isotropic_columns(K * np.maximum(1.0 / J - 1.0, 0.0))
        if confine == 0.0:
            return isotropic_columns(0.0 * J)
        number = rate * self.grain * sqrt(self.grain_density / confine)  # I, if all is plastic

        def law(part: float) -> float:
            rise = (self.mu_2 - self.mu_s) * part * number / (self.i0 + part * number)
            return confine * (self.mu_s + rise)

        return sheared(value, confine, G, before, self.mu_s * confine, law)

    @property
    def flow_speed(self) -> float:
        """See `Material.flow_speed`."""
        lam, mu = lame(self.young, self.poisson)
        return float(sqrt((lam + 2.0 * mu) / self.density))

    @property
    def most_filled(self) -> float:
        """See `Material.most_filled`."""
        return 1.01

    def parameters(self) -> MuIParameters:
        """Parameters of the kernels."""
        lam, mu = lame(self.young, self.poisson)
        inertia = self.i0 / (self.grain * sqrt(self.grain_density))
        return MuIParameters(lam + 2.0 / 3.0 * mu, mu, self.mu_s, self.mu_2, inertia, self.density)
