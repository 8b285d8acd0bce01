"""Johnson and Cook's metal behind shocks: with Mie and Gruneisen's pressure.

Flow and damage are as in `pgimp.physics.materials.johnson_cook`.
"""

from math import sqrt
from typing import NamedTuple

from pgimp.jit.algebra import contract, determinant, isotropic, one_plus
from pgimp.jit.choose import choose
from pgimp.jit.kernel import inlined
from pgimp.physics.materials.laws.hencky import distortion_energy
from pgimp.physics.materials.laws.mie_gruneisen import (
    MieGruneisen,
    margin_of,
    pressure_and_energy,
    shock_speed_squared,
)
from pgimp.physics.materials.laws.rate_flow import Damage, Strength, damaged, plastic_step


@inlined
def shocked(material, J, sigma, L, dt, q, before, heat):
    """Pressure, internal energy and temperature after a step.

    `before` has temperature and energy, `heat` comes from plastic flow.
    """
    k, eos = material.strength, material.eos
    warmth, inner = before
    former = J / determinant(one_plus(dt, L))
    p = (sigma[0] + sigma[1] + sigma[2]) * (-1.0 / 3.0)
    now, e = pressure_and_energy(eos, J, former, p, q, heat, inner)
    grown = J - former
    # dT = -gamma T dJ without dissipation, as gamma over the volume is constant.
    warm = warmth * (1.0 - eos.gamma * grown) + k.heating * (heat - q * grown)
    return now, e, warm


class JohnsonCookShockParameters(NamedTuple):
    """With Mie and Gruneisen's pressure, whose internal energy is the last state."""

    strength: Strength
    eos: MieGruneisen
    temperature: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, q, state):
        """Radial return, and the pressure with the step's heat."""
        k = material.strength
        s, _, x, work, _ = plastic_step(k, J, sigma, L, dt, state)
        p, e, warm = shocked(material, J, sigma, L, dt, q, (state[1], state[3]), k.share * work)
        return isotropic(1.0 / J, s, -p), (state[0] + x, warm, state[2] + work, e)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Internal energy without heat of plastic flow, plus energy of distortion, per volume."""
        k = material.strength
        inner = material.density * state[3] - k.share * state[2]
        return inner + distortion_energy(k.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work, and its part that becomes heat."""
        return state[2], 0.0, material.strength.share * state[2]

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave at constant entropy."""
        return sqrt(shock_speed_squared(material.eos, J, state[3], material.strength.shear))

    @staticmethod
    def margin(material, F, J, sigma, state):
        """Of the pressure's range."""
        return margin_of(material.eos, J)


class JohnsonCookShockDamageParameters(NamedTuple):
    """With Mie and Gruneisen's pressure and with damage; then internal energy is the last state."""

    strength: Strength
    damage: Damage
    eos: MieGruneisen
    temperature: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, q, state):
        """Radial return, pressure, then failure, after which there is no tension and no work of it.

        The energy released by failure becomes heat, like plastic work.
        """
        k = material.strength
        s, left, x, work, hot = plastic_step(k, J, sigma, L, dt, state)
        p, e, warm = shocked(material, J, sigma, L, dt, q, (state[1], state[4]), k.share * work)
        r = 1.0 / J
        damage = damaged(material.damage, k, x, hot, -p, left * r, dt, state[3])
        sound = choose(damage < 1.0, 1.0, 0.0)
        held = choose(damage < 1.0, p, max(p, 0.0))
        freed = choose(state[3] < 1.0, 1.0 - sound, 0.0) * (0.25 / k.shear) * contract(s, s)
        heat = k.share * freed
        e = e + (heat + 0.5 * (p - held) * (J - J / determinant(one_plus(dt, L)))) / k.density
        now = (state[0] + x, warm + k.heating * heat, state[2] + work + freed, damage, e)
        return isotropic(r * sound, s, -held), now

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Internal energy without heat of plastic flow, plus energy of distortion, per volume."""
        k = material.strength
        inner = material.density * state[4] - k.share * state[2]
        return inner + distortion_energy(k.shear, J, sigma)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work, and its part that becomes heat."""
        return state[2], 0.0, material.strength.share * state[2]

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave of the undamaged material at constant entropy."""
        return sqrt(shock_speed_squared(material.eos, J, state[4], material.strength.shear))

    @staticmethod
    def margin(material, F, J, sigma, state):
        """Of the pressure's range."""
        return margin_of(material.eos, J)
