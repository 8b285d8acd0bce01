"""Rubber that softens where it has been stretched: a material that remembers, for ``--import``.

The energy W of a neo-Hookean solid is never given back in full: the part d of the stress is lost,
d = damage * W_peak/(W_peak + toughness), with the greatest W that a particle has seen (after
Simo 1987, Computer Methods in Applied Mechanics and Engineering 60).
"""

from math import log, sqrt
from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

import pgimp
from pgimp.jit.algebra import isotropic, largest_stretch_squared, left_cauchy_green
from pgimp.physics.materials import Material, Poisson, Positive, State, Young, lame


class SofteningParameters(NamedTuple):
    """Lame's constants, energies and the density."""

    lam: float
    mu: float
    damage: float
    toughness: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Stress, and the state at the end of the step."""
        b, ln = left_cauchy_green(F), log(J)
        shear, volume = b[0] + b[1] + b[2] - 3.0 - 2.0 * ln, ln * ln
        energy = 0.5 * (material.mu * shear + material.lam * volume)
        peak = max(state[0], energy)
        damage = material.damage * peak / (peak + material.toughness)
        r = (1.0 - damage) / J
        sigma = isotropic(material.mu * r, b, (material.lam * ln - material.mu) * r)
        return sigma, (peak, damage)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Energy that can be given back, per initial volume."""
        b, ln = left_cauchy_green(F), log(J)
        shear, volume = b[0] + b[1] + b[2] - 3.0 - 2.0 * ln, ln * ln
        return 0.5 * (1.0 - state[1]) * (material.mu * shear + material.lam * volume)

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave in the sound material, where it is fastest."""
        s2 = largest_stretch_squared(left_cauchy_green(F))
        along = material.mu + material.lam * (1.0 - log(J))
        return sqrt((material.mu * s2 + max(along, 0.0)) / material.density)


@pgimp.register_material
class Softening(Material):
    """Rubber that loses stiffness by the greatest energy that it has held."""

    STATE: ClassVar[tuple[State, ...]] = (
        State("peak-energy", "energy/volume", "greatest energy of the sound material so far"),
        State("damage", "1", "part of the stress that is lost"),
    )

    model: Literal["softening"] = Field(description="name of the model")
    young: Young
    poisson: Poisson
    damage: Positive = Field(lt=1.0, description="part of the stress that can be lost [1]")
    toughness: Positive = Field(description="energy at which half of that is lost [energy/volume]")

    def parameters(self):
        """Parameters of the kernels."""
        lam, mu = lame(self.young, self.poisson)
        return SofteningParameters(lam, mu, self.damage, self.toughness, self.density)
