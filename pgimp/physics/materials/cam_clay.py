"""Modified Cam-clay: clay that hardens as it is compacted, and softens as it swells.

With p the pressure, q = sqrt(3 J2), p_c the preconsolidation pressure and volume strains e counted
in compression, v = 1 + void ratio at the start:

    elastic  dp = v p/kappa de,  G constant          (a constant Poisson's ratio would make energy)
    yield    f = (q/M)^2 + p (p - p_c) <= 0,  flow along its normal
    hardens  dp_c = v p_c/(lambda - kappa) de_plastic

A step is implicit, with the logarithms of p and p_c integrated exactly. Its one unknown is t, with
p_c = p (1 + t^2) and q = M t p on the ellipse: the plastic volume strain

    theta(t) = (ln(p_tr/p_c) + ln(1 + t^2))/(v/kappa + v/(lambda - kappa))

gives p = p_tr exp(-v theta/kappa), and normal flow, with the multiplier from q, is

    t theta - M^2/(6 G) (q_tr/M - t p)(1 - t^2) = 0.

The left side is smooth. It changes sign between t = 0 and 1 in compaction, and between t = 1 and
q_tr/(M p_tr) in swelling. Newton's method, bracketed by these, finds the root.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.jit.algebra import determinant, isotropic, one_plus
from pgimp.jit.choose import choose
from pgimp.jit.functions import exp, log
from pgimp.jit.kernel import inlined
from pgimp.physics.materials.base import Material, State
from pgimp.physics.materials.exact.clay import Clay, path_of_clay
from pgimp.physics.materials.laws.friction import PLASTIC_WORK
from pgimp.physics.materials.laws.hencky import distortion_energy, elastic_trial
from pgimp.physics.materials.laws.invariants import TINY, mean, shear_stress
from pgimp.schema.base import Positive
from pgimp.schema.problems import Problem, raise_problems

#: Steps of the bracketed Newton method; more than trial stresses of stable steps need.
_SWEEPS = 16
#: Least pressure, over the initial preconsolidation pressure; less counts as zero.
_MIN_PRESSURE = 1e-9
_SQRT3 = sqrt(3.0)


@inlined
def on_ellipse(A, a, b, c, p, q):
    """Parameter t of the point on the yield ellipse to which a trial stress returns; see above.

    Parameters
    ----------
    A, a, b, c : float
        ln(p_tr/p_c), v/kappa, v/(lambda - kappa), M^2/(6 G).
    p, q : float
        p_tr, q_tr/M.
    """
    wet = A + log(2.0 + 0.0 * A) > 0.0
    last = q / p
    low, high = choose(wet, 0.0 * A, 1.0), choose(wet, 1.0, max(last, 1.0))
    t = min(max(last, low), high)
    for _ in range(_SWEEPS):
        square = t * t
        theta = (A + log(1.0 + square)) / (a + b)
        slope = 2.0 * t / ((1.0 + square) * (a + b))
        now = p * exp(-a * theta)
        over = q - t * now
        value = t * theta - c * over * (1.0 - square)
        falls = now * (1.0 - a * t * slope) * (1.0 - square) + 2.0 * t * over
        rate = theta + t * slope + c * falls
        below = value < 0.0
        low, high = choose(below, t, low), choose(below, high, t)
        next_t = t - value / rate
        inside = (next_t >= low) & (next_t <= high)
        t = choose(inside, next_t, 0.5 * (low + high))
    return t


class CamClayParameters(NamedTuple):
    """M, v/kappa, v/(lambda - kappa), G, initial p_c, void ratio, density."""

    slope: float
    swells: float
    hardens: float
    shear: float
    consolidated: float
    void: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Stress on or within the ellipse; p_c, plastic compaction and plastic work.

        Stresses in the code are Kirchhoff's, J times Cauchy's.
        """
        a, b, M = material.swells, material.hardens, material.slope
        s = elastic_trial(material.shear, J, sigma, L, dt)
        tau = shear_stress(s)
        grown = determinant(one_plus(dt, L))
        least = _MIN_PRESSURE * material.consolidated
        p = max(-mean(sigma) * J / grown, least) * exp(-a * log(grown))
        q, pc = _SQRT3 * tau / M, max(state[0], least)
        A = log(p / pc)
        yields = A + log(1.0 + (q / p) * (q / p)) > 0.0
        t = on_ellipse(A, a, b, M * M / (6.0 * material.shear), p, q)
        theta = choose(yields, (A + log(1.0 + t * t)) / (a + b), 0.0)
        p = p * exp(-a * theta)
        part = choose(yields, t * p / (q + TINY), 1.0)
        work = p * theta + part * (1.0 - part) * tau * tau / material.shear
        stress = isotropic(part / J, s, -p / J)
        return stress, (pc * exp(b * theta), state[1] + theta, state[2] + work)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        return distortion_energy(material.shear, J, sigma) - J * mean(sigma) / material.swells

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work."""
        return state[2], 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave at the clay's greatest pressure, p_c."""
        bulk = material.swells * state[0]
        return sqrt((bulk + 4.0 / 3.0 * material.shear) / material.density)

    @staticmethod
    def margin(material, F, J, sigma, state):
        """The void ratio."""
        return (1.0 + material.void) * J - 1.0


class CamClay(Material):
    """Clay, modified Cam-clay; it begins under a pressure, `pressure` or that of `points`."""

    INERTIA_ALONE: ClassVar[bool] = True
    CARRIES_STRESS: ClassVar[bool] = True
    BEARS_TENSION: ClassVar[bool] = False
    RESTS: ClassVar[bool] = True
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work",)
    SPELLINGS: ClassVar[dict[str, str]] = {"void_ratio": "void-ratio"}
    STATE: ClassVar[tuple[State, ...]] = (
        State(
            "preconsolidation",
            "stress",
            "preconsolidation pressure p_c",
            initial="consolidated",
            least=0.0,
        ),
        State("plastic-compaction", "1", "plastic volume strain, compaction positive"),
        PLASTIC_WORK,
    )

    model: Literal["cam-clay"] = Field(description="name of the model")
    m: Positive = Field(description="slope M of the critical state, q = M p [1]")
    lambda_: Positive = Field(
        alias="lambda", description="slope of the void ratio by ln p in first compression [1]"
    )
    kappa: Positive = Field(description="likewise in swelling, below lambda [1]")
    void_ratio: Positive = Field(alias="void-ratio", description="void ratio at the start [1]")
    shear: Positive = Field(description="shear modulus G, constant [stress]")
    preconsolidation: Positive = Field(
        description="preconsolidation pressure at the start [stress]"
    )
    pressure: Positive | None = Field(
        default=None,
        description="pressure at the start, at most preconsolidation, which is that of null "
        "[stress]",
    )

    @model_validator(mode="after")
    def _check(self) -> "CamClay":
        if self.kappa >= self.lambda_:
            text = f"must be below lambda, {self.lambda_:g}: clay swells by less than it gave way"
            raise_problems("cam-clay", [Problem(("kappa",), text)])
        if self.initial_pressure > self.preconsolidation:
            text = f"is above preconsolidation, {self.preconsolidation:g}, which no clay bears"
            raise_problems("cam-clay", [Problem(("pressure",), text)])
        return self

    @property
    def initial_pressure(self) -> float:
        """See `Material.initial_pressure`."""
        return self.preconsolidation if self.pressure is None else self.pressure

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """See `Material.out_of_range`."""
        return (
            f"is compressed until it has no voids left ({J:.3g} of its volume, preconsolidation "
            f"{state[0]:.3g})",
            "a greater void-ratio, loads within the strength of the clay, smaller steps "
            "(time.step)",
        )

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        v, p = 1.0 + self.void_ratio, (self.preconsolidation, self.initial_pressure)
        clay = Clay(self.m, v / self.kappa, v / self.lambda_, self.shear, *p)
        return path_of_clay(clay, path, value, confine)

    def parameters(self) -> CamClayParameters:
        """Parameters of the kernels."""
        v = 1.0 + self.void_ratio
        elastic, plastic = v / self.kappa, v / (self.lambda_ - self.kappa)
        start = self.preconsolidation, self.void_ratio, self.density
        return CamClayParameters(self.m, elastic, plastic, self.shear, *start)
