"""Drucker and Prager's soil: tau <= alpha p + k, with dilation, apex and tension cut-off.

p is the pressure and tau the root of J2. The trial stress of
`pgimp.physics.materials.laws.hencky` returns to the cone along the flow of the cone with the angle
of dilation,

    dl = max(0, tau_tr - alpha p_tr - k)/(G + K alpha alpha'),  tau = tau_tr - G dl,
    p = p_tr + K alpha' dl.

t is the greatest tension of the soil. Where p is then below -t, the stress returns to p = -t and
tau <= k - alpha t. This is the apex, unless the tension is cut off before it. The volume by which
the soil opens there is a state variable, and has to close before pressure rises again. Otherwise
loose soil would grow each time that it is pulled apart (Tampubolon et al., ACM Trans. Graph. 36,
2017).
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.jit.algebra import determinant, isotropic, one_plus
from pgimp.jit.choose import choose
from pgimp.jit.functions import log
from pgimp.physics.materials.base import State, lame
from pgimp.physics.materials.exact.friction import cone, path_of_soil
from pgimp.physics.materials.laws.friction import PLASTIC_WORK, Match, Soil, cone_of
from pgimp.physics.materials.laws.hencky import distortion_energy, elastic_trial
from pgimp.physics.materials.laws.invariants import TINY, mean, shear_stress

#: Tension of a cone without an apex.
_BOUNDLESS = 1e200


class DruckerPragerParameters(NamedTuple):
    """Moduli K and G, slopes of strength and flow, strength k, greatest tension, density."""

    bulk: float
    shear: float
    alpha: float
    flow: float
    k: float
    tension: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Stress on or within the cone; open volume, plastic shear and plastic work.

        Stresses in the code are Kirchhoff's, J times Cauchy's, with the strength J k.
        """
        bulk, shear, alpha, least = material.bulk, material.shear, material.alpha, -material.tension
        k, least = material.k * J, least * J
        s = elastic_trial(shear, J, sigma, L, dt)
        tau = shear_stress(s)
        grown = determinant(one_plus(dt, L))
        p = -mean(sigma) * J / grown - bulk * (log(grown) + state[0])
        # On the cone, or within it:
        slip = max(tau - alpha * p - k, 0.0) / (shear + bulk * alpha * material.flow)
        p_cone = p + bulk * material.flow * slip
        # At the greatest tension, the soil opens until the elastic pressure equals it:
        slip_open = max(tau - (k + alpha * least), 0.0) / shear
        p_open = p + bulk * material.flow * slip_open
        opens = p_open < least
        slip = choose(opens, slip_open, slip)
        gap = choose(opens, (least - p_open) / bulk, 0.0)
        p = choose(opens, least, p_cone)
        kept = tau - shear * slip
        work = kept * slip - p * (material.flow * slip + gap - state[0])
        stress = isotropic(kept / (J * (tau + TINY)), s, -p / J)
        return stress, (gap, state[1] + slip, state[2] + work)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy per initial volume."""
        p = J * mean(sigma)
        return distortion_energy(material.shear, J, sigma) + 0.5 * p * p / material.bulk

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work."""
        return state[2], 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave: rho0 c^2 = (K + 4 G/3)(1 - ln J) in compression."""
        modulus = material.bulk + 4.0 / 3.0 * material.shear
        return sqrt(modulus * (1.0 - log(min(J, 1.0))) / material.density)


class DruckerPrager(Soil):
    """Soil or concrete with a smooth cone of strength; elastic as hooke within it."""

    CARRIES_STRESS: ClassVar[bool] = True
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work",)
    STATE: ClassVar[tuple[State, ...]] = (
        State("gap", "1", "tension-crack volume, over the volume of soil", least=0.0),
        State("plastic-shear", "1", "sum of the plastic shear strain, as of simple shear"),
        PLASTIC_WORK,
    )

    model: Literal["drucker-prager"] = Field(description="name of the model")
    match: Match = Field(
        default="plane-strain",
        description="stresses in which the cone has the strength of Mohr and Coulomb: "
        "plane-strain, where it flows along its normal; plane-strain-flow, where it flows by "
        "dilation-angle, right for sand that shears; compression and extension, triaxial",
    )

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        line = cone(*cone_of(self, self.match))
        return path_of_soil(self, (line, line), path, value, confine)

    def parameters(self) -> DruckerPragerParameters:
        """Parameters of the kernels."""
        lam, mu = lame(self.young, self.poisson)
        alpha, flow, k = cone_of(self, self.match)
        tension = min(self.greatest_tension, k / alpha if alpha > 0.0 else _BOUNDLESS)
        return DruckerPragerParameters(
            lam + 2.0 / 3.0 * mu, mu, alpha, flow, k, tension, self.density
        )
