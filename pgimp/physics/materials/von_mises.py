"""Metals with von Mises' yield condition: linear, saturating or kinematic hardening.

q = sqrt(3/2) |s - beta| <= sigma_y(alpha), with the deviator s of the Kirchhoff stress, the back
stress beta and the plastic strain alpha. sigma_y = yield + H alpha + Q (1 - exp(-b alpha)) (Voce).
Elastic strains are logarithmic (`pgimp.physics.materials.laws.hencky`), the pressure is
-K ln J / J. A step returns radially to the yield surface of its end (backward Euler; Simo, Hughes,
Computational Inelasticity, box 3.2). This is exact wherever the direction of s is constant.

The back stress grows by 2/3 H_k times the plastic strain and turns with the rotation R of F = V R
(Green, Naghdi). In simple shear its shear stress then grows steadily (Dienes 1979). With the spin W
of Jaumann's rate it would oscillate (Nagtegaal, de Jong 1982).
"""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field

from pgimp.jit.algebra import contract, isotropic, rotate
from pgimp.jit.functions import exp, log
from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import plus_scaled
from pgimp.physics.materials.base import Material, Poisson, State, Young, lame
from pgimp.physics.materials.exact.rows import first_leg
from pgimp.physics.materials.laws.hencky import (
    TINY,
    elastic_energy,
    elastic_speed,
    elastic_trial,
    equivalent,
)
from pgimp.physics.materials.laws.polar import polar_rotation
from pgimp.schema.base import Model, Number, Positive
from pgimp.schema.problems import problem

PLASTIC_STRAIN = State(
    "plastic-strain",
    "1",
    "equivalent plastic strain, the integral of sqrt(2/3) |D_p| over time",
    least=0.0,
)
BACK_STRESS = State(
    "back-stress",
    "stress",
    "back stress, of the Kirchhoff stress: the yield surface's centre",
    tensor=True,
)


def _not_softening(value: float) -> float:
    if value < 0.0:
        raise problem(
            f"expected a number of at least 0, got {value:.15g}: a metal that softens flows in a "
            "band of one cell, however small cells are; use `damage` of johnson-cook for failure"
        )
    return value


Hardening = Annotated[Number, AfterValidator(_not_softening)]


class VonMisesParameters(NamedTuple):
    """Elastic constants, yield stress, linear hardening H and initial density."""

    bulk: float
    shear: float
    yield_stress: float
    hardening: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Radial return in closed form."""
        s = elastic_trial(material.shear, J, sigma, L, dt)
        q = equivalent(s)
        stiffness = 3.0 * material.shear
        excess = q - (material.yield_stress + material.hardening * state[0])
        flow = max(excess, 0.0) * (1.0 / (stiffness + material.hardening))
        r = 1.0 / J
        kept = r * (1.0 - stiffness * flow / (q + TINY))
        return isotropic(kept, s, material.bulk * log(J) * r), (state[0] + flow,)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        return elastic_energy(material, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work per initial volume, the integral of the yield stress over alpha."""
        mean = material.yield_stress + 0.5 * material.hardening * state[0]
        return state[0] * mean, 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal elastic wave."""
        return elastic_speed(material, J)


@inlined
def saturating_flow(material, q, alpha, stiffness):
    """Plastic strain of a step: the root x of q - stiffness x = sigma_y(alpha + x), 0 if elastic.

    Four steps of Newton's method from 0. The residual decreases and is convex, so they never pass
    the root. They reach it to rounding if b x < 1 and Q b is well below 3 G.
    """
    H, Q, b = material.hardening, material.saturation, material.rate
    x = 0.0 * q
    for _ in range(4):
        left = Q * exp(-b * (alpha + x))
        excess = q - (material.yield_stress + H * (alpha + x) + Q - left) - stiffness * x
        x = x + max(excess, 0.0) / (stiffness + H + b * left)
    return x


@inlined
def saturating_work(material, alpha):
    """Integral of sigma_y over the plastic strain."""
    linear = material.yield_stress + material.saturation + 0.5 * material.hardening * alpha
    gone = (1.0 - exp(-material.rate * alpha)) / material.rate
    return linear * alpha - material.saturation * gone


class SaturatingParameters(NamedTuple):
    """As `VonMisesParameters`, with saturation Q at rate b."""

    bulk: float
    shear: float
    yield_stress: float
    hardening: float
    saturation: float
    rate: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Radial return by Newton's method."""
        s = elastic_trial(material.shear, J, sigma, L, dt)
        q = equivalent(s)
        stiffness = 3.0 * material.shear
        flow = saturating_flow(material, q, state[0], stiffness)
        r = 1.0 / J
        kept = r * (1.0 - stiffness * flow / (q + TINY))
        return isotropic(kept, s, material.bulk * log(J) * r), (state[0] + flow,)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work per initial volume."""
        return saturating_work(material, state[0]), 0.0, 0.0

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        return elastic_energy(material, J, sigma)

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal elastic wave."""
        return elastic_speed(material, J)


class KinematicParameters(NamedTuple):
    """As `SaturatingParameters`, with the modulus H_k of the back stress, a state variable."""

    bulk: float
    shear: float
    yield_stress: float
    hardening: float
    saturation: float
    rate: float
    kinematic: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Radial return to the surface about the back stress, turned with the body."""
        s = elastic_trial(material.shear, J, sigma, L, dt)
        back = rotate(polar_rotation(F, L, dt), state[1:])
        xi = plus_scaled(-1.0, back, s)
        q = equivalent(xi)
        stiffness = 3.0 * material.shear
        flow = saturating_flow(material, q, state[0], stiffness + material.kinematic)
        along = flow / (q + TINY)
        s = plus_scaled(-stiffness * along, xi, s)
        back = plus_scaled(material.kinematic * along, xi, back)
        r = 1.0 / J
        return isotropic(r, s, material.bulk * log(J) * r), (state[0] + flow, *back)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy, and the energy stored by the back stress, 3/(4 H_k) beta : beta."""
        back = state[1:]
        return elastic_energy(material, J, sigma) + 0.75 / material.kinematic * contract(back, back)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work per initial volume, without the energy stored by the back stress."""
        return saturating_work(material, state[0]), 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal elastic wave."""
        return elastic_speed(material, J)


class Saturation(Model):
    """Hardening that saturates (Voce)."""

    stress: Positive = Field(description="Q, by which the yield stress grows in the end [stress]")
    rate: Positive = Field(description="b in Q (1 - exp(-b alpha)) [1]")


class VonMises(Material):
    """Metal that flows where its equivalent stress reaches a yield stress, for large strains."""

    INERTIA_ALONE: ClassVar[bool] = True
    CARRIES_STRESS: ClassVar[bool] = True
    CARRIES_PRESSURE: ClassVar[bool] = False
    PLANE_STRESS: ClassVar[bool] = True
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work",)
    STATE: ClassVar[tuple[State, ...]] = (PLASTIC_STRAIN, BACK_STRESS)
    SPELLINGS: ClassVar[dict[str, str]] = {"yield_stress": "yield-stress"}

    model: Literal["von-mises"] = Field(description="name of the model")
    young: Young
    poisson: Poisson
    yield_stress: Positive = Field(alias="yield-stress", description="at the start [stress]")
    hardening: Hardening = Field(
        default=0.0, description="H, growth of the yield stress with the plastic strain [stress]"
    )
    saturation: Saturation | None = Field(
        default=None, description="growth of the yield stress that saturates; null: none"
    )
    kinematic: Hardening = Field(
        default=0.0,
        description="H_k, growth of the back stress, the centre of the yield surface, with the "
        "plastic strain [stress]",
    )

    @property
    def states(self) -> tuple[State, ...]:
        """State variables; the back stress only with kinematic hardening."""
        return self.STATE if self.kinematic else self.STATE[:1]

    def parameters(self) -> VonMisesParameters | SaturatingParameters | KinematicParameters:
        """Parameters of the kernels, only for the hardening in use."""
        lam, mu = lame(self.young, self.poisson)
        elastic = lam + 2.0 / 3.0 * mu, mu, self.yield_stress, self.hardening
        voce = (self.saturation.stress, self.saturation.rate) if self.saturation else (0.0, 1.0)
        if self.kinematic:
            return KinematicParameters(*elastic, *voce, self.kinematic, self.density)
        if self.saturation:
            return SaturatingParameters(*elastic, *voce, self.density)
        return VonMisesParameters(*elastic, self.density)

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`; in closed form without saturation, confinement or a turn."""
        if self.saturation is not None or confine or not first_leg(value).all():
            return None
        lam, G = lame(self.young, self.poisson)
        K = lam + 2.0 / 3.0 * G
        e, sign = np.abs(value), np.sign(value)
        H = self.hardening + self.kinematic
        if path in ("uniaxial-strain", "oedometer", "undrained"):
            trial = (2.0 if path != "undrained" else 3.0) * G * e  # q = 3 G h, h from the strain
            alpha = np.maximum(trial - self.yield_stress, 0.0) / (3.0 * G + H)
            q = trial - 3.0 * G * alpha
            volume = np.zeros_like(e) if path == "undrained" else value
            mean = K * volume * np.exp(-volume)
            sigma = mean + 2.0 / 3.0 * sign * q * np.exp(-volume)
            return {"plastic-strain": alpha, "q": q * np.exp(-volume), "stress-xx": sigma}
        if path == "uniaxial-stress":  # tau = E (e - alpha), and (sigma_y + H alpha) in flow
            alpha = np.maximum(self.young * e - self.yield_stress, 0.0) / (self.young + H)
            tau = sign * self.young * (e - alpha)
            return {"plastic-strain": alpha, "stress-xx": tau * np.exp(-tau / (3.0 * K))}
        if path == "isotropic":
            return {"pressure": -K * value * np.exp(-value), "plastic-strain": 0.0 * e}
        return None
