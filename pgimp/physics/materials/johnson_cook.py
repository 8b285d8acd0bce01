"""Johnson and Cook's metal: hardening, rate, heat by flow, damage, and pressure behind shocks.

sigma_y = (A + B alpha^n)(1 + C ln max(1, alpha'/rate))(1 - T*^m), T* = (T - T0)/(Tm - T0) between
0 and 1. alpha' is the plastic rate of the step itself, found with the flow by Newton's method, so
the stress does not oscillate. Flow heats by dT = beta q dalpha/(rho0 c), without conduction.
Elasticity is as in `pgimp.physics.materials.laws.hencky`.

Damage grows by dalpha/eps_f, eps_f = (d1 + d2 exp(d3 sigma*))(1 + d4 ln max(1, alpha'/rate))
(1 + d5 T*), sigma* the mean over the equivalent stress (Johnson, Cook 1985). At 1 a particle has
failed: it bears pressure only, as rubble, and keeps its mass.

The pressure here is -K ln J / J; `johnson_cook_shock` has the pressure of shocks.
"""

from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import Field, model_validator

from pgimp.jit.algebra import contract, isotropic
from pgimp.jit.choose import choose
from pgimp.jit.functions import log
from pgimp.physics.materials.base import Material, Poisson, State, Young, lame
from pgimp.physics.materials.johnson_cook_shock import (
    JohnsonCookShockDamageParameters,
    JohnsonCookShockParameters,
)
from pgimp.physics.materials.laws.hencky import distortion_energy, elastic_speed
from pgimp.physics.materials.laws.mie_gruneisen import LARGEST, MieGruneisen, MieGruneisenEntry
from pgimp.physics.materials.laws.rate_flow import Damage, Strength, damaged, plastic_step
from pgimp.physics.materials.von_mises import PLASTIC_STRAIN
from pgimp.schema.base import Model, NonNegative, Number, Positive
from pgimp.schema.problems import Problem, raise_problems


class JohnsonCookParameters(NamedTuple):
    """With the pressure -K ln J / J and without damage."""

    strength: Strength
    temperature: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Radial return with the step's own rate."""
        k = material.strength
        s, _, x, work, _ = plastic_step(k, J, sigma, L, dt, state)
        r = 1.0 / J
        warm = state[1] + k.share * k.heating * work
        return isotropic(r, s, k.bulk * log(J) * r), (state[0] + x, warm, state[2] + work)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        k, ln = material.strength, log(J)
        return 0.5 * k.bulk * ln * ln + distortion_energy(k.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work, and its part that becomes heat."""
        k = material.strength
        return state[2], 0.0, (state[1] - k.start) / k.heating

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal elastic wave."""
        return elastic_speed(material.strength, J)


class JohnsonCookDamageParameters(NamedTuple):
    """With the pressure -K ln J / J and with damage, the last state."""

    strength: Strength
    damage: Damage
    temperature: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Radial return, then failure; the energy released by failure counts as plastic work."""
        k = material.strength
        s, q, x, work, hot = plastic_step(k, J, sigma, L, dt, state)
        r = 1.0 / J
        ln = log(J)
        mean = k.bulk * ln * r
        damage = damaged(material.damage, k, x, hot, mean, q * r, dt, state[3])
        sound = choose(damage < 1.0, 1.0, 0.0)
        held = choose(damage < 1.0, mean, min(mean, 0.0))
        # Elastic energy released by failure.
        stretched = max(ln, 0.0)
        stored = 0.25 / k.shear * contract(s, s) + 0.5 * k.bulk * stretched * stretched
        freed = choose(state[3] < 1.0, 1.0 - sound, 0.0) * stored
        warm = state[1] + k.share * k.heating * (work + freed)
        now = (state[0] + x, warm, state[2] + work + freed, damage)
        return isotropic(r * sound, s, held), now

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume; zero for stretched rubble."""
        k, ln = material.strength, log(J)
        ln = choose(state[3] < 1.0, ln, min(ln, 0.0))
        return 0.5 * k.bulk * ln * ln + distortion_energy(k.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work, and its part that becomes heat."""
        k = material.strength
        return state[2], 0.0, (state[1] - k.start) / k.heating

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal elastic wave of the undamaged material."""
        return elastic_speed(material.strength, J)


class DamageEntry(Model):
    """Constants of the strain at failure."""

    d1: Number = Field(description="d1, strain at failure without d2 [1]")
    d2: Number = Field(default=0.0, description="d2, of the part that tension takes away [1]")
    d3: Number = Field(
        default=0.0,
        description="d3 in exp(d3 sigma*), sigma* the mean over the equivalent stress, tension "
        "positive: below 0 where tension is worse [1]",
    )
    d4: Number = Field(default=0.0, description="d4, of the rate [1]")
    d5: Number = Field(default=0.0, description="d5, of the temperature [1]")

    @model_validator(mode="after")
    def _check(self) -> "DamageEntry":
        if self.d1 + self.d2 <= 0.0:
            text = "d1 + d2, the strain at failure in shear, must be above 0; leave `damage` out"
            raise_problems("damage", [Problem(("d1",), f"{text} for a metal that never fails")])
        return self


class EquationOfState(Model):
    """The pressure behind shocks."""

    mie_gruneisen: MieGruneisenEntry = Field(
        alias="mie-gruneisen", description="Mie and Gruneisen's, about the Hugoniot"
    )

    SPELLINGS: ClassVar[dict[str, str]] = {"mie_gruneisen": "mie-gruneisen"}


class JohnsonCook(Material):
    """Metal at high rates: hardening, rate, heating by flow, failure, shocks."""

    CARRIES_STRESS: ClassVar[bool] = True
    CARRIES_PRESSURE: ClassVar[bool] = False
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work", "heat")
    STATE: ClassVar[tuple[State, ...]] = (
        PLASTIC_STRAIN,
        State("temperature", "temperature", "temperature", initial=0.0),
        State("plastic-work", "energy/volume", "plastic work per initial volume"),
        State("damage", "1", "damage; at 1 it has failed and bears pressure only", least=0.0),
        State("internal-energy", "energy/mass", "internal energy e"),
    )
    SPELLINGS: ClassVar[dict[str, str]] = {
        "reference_rate": "reference-rate",
        "specific_heat": "specific-heat",
        "taylor_quinney": "taylor-quinney",
    }

    model: Literal["johnson-cook"] = Field(description="name of the model")
    young: Young
    poisson: Poisson
    a: Positive = Field(description="A, yield stress at the start [stress]")
    b: NonNegative = Field(default=0.0, description="B in B alpha^n [stress]")
    n: Positive = Field(default=1.0, le=2.0, description="n in it [1]")
    c: NonNegative = Field(default=0.0, description="C in 1 + C ln(rate/reference-rate) [1]")
    m: Positive = Field(default=1.0, description="m in 1 - T*^m [1]")
    reference_rate: Positive = Field(
        alias="reference-rate",
        default=1.0,
        description="plastic rate up to which C has no effect [1/time]",
    )
    specific_heat: Positive = Field(
        alias="specific-heat", description="c [energy/(mass temperature)]"
    )
    temperature: Number = Field(
        description="T0, at the start, and where T* is 0; absolute with `eos`, which heats what is "
        "compressed in proportion to it [temperature]"
    )
    melting: Number = Field(description="Tm, where it has no strength left [temperature]")
    taylor_quinney: Number = Field(
        alias="taylor-quinney",
        default=0.9,
        ge=0.0,
        le=1.0,
        description="part of the plastic work that becomes heat [1]",
    )
    damage: DamageEntry | None = Field(default=None, description="failure; null: none")
    eos: EquationOfState | None = Field(
        default=None, description="equation of state; null: the pressure is -K ln J / J"
    )

    @model_validator(mode="after")
    def _check(self) -> "JohnsonCook":
        if self.melting <= self.temperature:
            text = f"expected more than the temperature at the start, {self.temperature:.15g}"
            raise_problems("johnson-cook", [Problem(("melting",), text)])
        if self.eos is not None and self.temperature < 0.0:
            text = (
                f"{self.temperature:.15g} is no absolute temperature: with an equation of state "
                "compression heats in proportion to it; take kelvin, for melting too"
            )
            raise_problems("johnson-cook", [Problem(("temperature",), text)])
        return self

    @property
    def states(self) -> tuple[State, ...]:
        """State variables: damage and internal energy only if the entry uses them."""
        strain, temperature, work, damage, energy = self.STATE
        found = [strain, temperature._replace(initial="temperature"), work]
        return (*found, *([damage] if self.damage else []), *([energy] if self.eos else []))

    @property
    def TAKES_VISCOUS_PRESSURE(self) -> bool:  # type: ignore[override]
        """Whether viscous pressure heats the material: with an equation of state."""
        return self.eos is not None

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """See `Material.out_of_range`."""
        s = self.eos.mie_gruneisen.s if self.eos else 0.0
        return (
            f"is compressed to {J:.3g} times its volume, where Mie and Gruneisen's pressure ends "
            f"(s (1 - J) = {s * (1.0 - J):.3g}, at most {LARGEST:g})",
            "smaller steps (time.step), artificial viscosity (viscosity: {linear: 0.2, quadratic: "
            "2.0}), a slower impact",
        )

    def parameters(self) -> Any:
        """Parameters of the kernels, only for the features that the entry uses."""
        lam, mu = lame(self.young, self.poisson)
        elastic = lam + 2.0 / 3.0 * mu, mu, self.density
        flow = self.a, self.b, self.n, self.c, self.m, self.reference_rate
        softening = self.temperature, 1.0 / (self.melting - self.temperature)
        heating = 1.0 / (self.density * self.specific_heat), self.taylor_quinney
        strength = Strength(*elastic, *flow, *softening, *heating)
        if self.damage:
            given = self.damage
            damage = Damage(given.d1, given.d2, given.d3, given.d4, given.d5)
        if self.eos is None:
            if self.damage is None:
                return JohnsonCookParameters(strength, self.temperature, self.density)
            return JohnsonCookDamageParameters(strength, damage, self.temperature, self.density)
        law = self.eos.mie_gruneisen
        eos = MieGruneisen(self.density * law.c0**2, law.s, law.gamma, self.density)
        if self.damage is None:
            return JohnsonCookShockParameters(strength, eos, self.temperature, self.density)
        return JohnsonCookShockDamageParameters(
            strength, damage, eos, self.temperature, self.density
        )
