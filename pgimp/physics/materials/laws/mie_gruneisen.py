"""Mie and Gruneisen's pressure of shocked solids, about the Hugoniot U_s = c0 + s u_p.

The pressure is p = p_H (1 - gamma eta/2) + gamma rho0 e with eta = 1 - J and the internal energy e
per mass. The Hugoniot is p_H = rho0 c0^2 eta/(1 - s eta)^2, in tension p_H = rho0 c0^2 eta. In a
step e grows by the heat h of plastic flow, the work of the mean pressure and of the viscous q,

    rho0 (e' - e) = h - ((p + p')/2 + q) (J' - J),

which is linear in p'.
"""

from typing import NamedTuple

from pydantic import Field

from pgimp.jit.choose import choose
from pgimp.jit.kernel import inlined
from pgimp.schema.base import Model, NonNegative, Positive

#: Largest s eta for which the pressure is computed; at 1 it is infinite.
LARGEST = 0.95


class MieGruneisen(NamedTuple):
    """rho0 c0^2, s, gamma, and initial density."""

    stiffness: float
    s: float
    gamma: float
    density: float


class MieGruneisenEntry(Model):
    """Mie and Gruneisen's equation of state."""

    c0: Positive = Field(description="c0 in U_s = c0 + s u_p, of shocks [length/time]")
    s: NonNegative = Field(description="s in it [1]")
    gamma: NonNegative = Field(description="Gruneisen's gamma at the initial density [1]")


@inlined
def _cold(eos, J):
    """Pressure without internal energy, and its derivative by eta."""
    eta = 1.0 - J
    squeezed = max(eta, 0.0)
    held = min(eos.s * squeezed, LARGEST)
    r = 1.0 / (1.0 - held)
    hugoniot = eos.stiffness * eta * r * r
    slope = eos.stiffness * choose(eta > 0.0, (1.0 + held) * r * r * r, 1.0)
    half = 1.0 - 0.5 * eos.gamma * eta
    return hugoniot * half, slope * half - 0.5 * eos.gamma * hugoniot


@inlined
def pressure_and_energy(eos, J, before, p, q, heat, e):
    """Pressure and internal energy after a step.

    Parameters
    ----------
    eos : MieGruneisen
        The constants.
    J, before : float
        Volume ratio after and before the step.
    p, q : float
        Pressure before the step, viscous pressure in it.
    heat : float
        Heat of plastic flow, per initial volume.
    e : float
        Internal energy per mass before the step.
    """
    grown = J - before
    cold, _ = _cold(eos, J)
    known = eos.density * e + heat - (0.5 * p + q) * grown
    now = (cold + eos.gamma * known) / (1.0 + 0.5 * eos.gamma * grown)
    return now, (known - 0.5 * now * grown) / eos.density


@inlined
def shock_speed_squared(eos, J, e, shear):
    """Squared speed of longitudinal waves, J^2 (-dp/dJ at constant entropy) + 4/3 G."""
    cold, slope = _cold(eos, J)
    p = cold + eos.gamma * eos.density * e
    stiff = max(slope + eos.gamma * p, 0.1 * eos.stiffness)
    return (J * J * stiff + 4.0 / 3.0 * shear) / eos.density


@inlined
def margin_of(eos, J):
    """Distance of a particle from the end of the equation's range."""
    return LARGEST - eos.s * (1.0 - J)
