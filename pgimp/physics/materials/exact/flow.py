"""Exact curves of fluids, gases and grains, `Material.exact_path`.

Elastic simple shear by g: principal logarithmic strains +-h and a shear stress 2 G h/cosh(h) with
h = arsinh(g/2). In steady flow at a rate the elastic strain is constant. With tau the root of
J2 and h = tau/(2 G) it is turned by tan(angle) = exp(-2 h), so that

    plastic rate = rate/cosh(tau/G),  shear stress = tau/cosh(tau/G),

and the normal stress along the flow exceeds the mean by tau tanh(tau/G). G and tau refer to
Kirchhoff's stress.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.physics.materials.exact.rows import Array, first_leg

#: Shear, in multiples of tau/G, after which the initial transient has decayed to about 1e-15.
_FADED = 40.0
_ROUNDS = 100


def isotropic_columns(pressure: Array) -> dict[str, Array]:
    """Columns of a purely isotropic stress."""
    normal = dict.fromkeys(("stress-xx", "stress-yy", "stress-zz"), -pressure)
    none = dict.fromkeys(("stress-xy", "q"), np.zeros_like(pressure))
    return {"pressure": pressure} | normal | none


def volumes(path: str, value: Array, before: float) -> Array | None:
    """Return J along a path of given volumes, None for other paths; `before` is J at the start."""
    if path in ("isotropic", "uniaxial-strain", "oedometer"):
        return before * np.exp(value)
    if path in ("simple-shear", "undrained"):
        return before + 0.0 * value
    return None


def moves(value: Array) -> Array:
    """Sign of a path's rate in the step before each row, 0 at its start."""
    return np.sign(np.diff(value, prepend=value[0]))


def viscous(path: str, pressure: Array, part: Array, mu: float, rates: Array) -> dict[str, Array]:
    """Columns of a Newtonian fluid that fills `part` of the volume."""
    columns = isotropic_columns(pressure)
    if path == "simple-shear":
        shear = mu * part * rates
        return columns | {"stress-xy": shear, "q": np.sqrt(3.0) * np.abs(shear)}
    if path == "isotropic":
        return columns
    along = mu * part * rates * (2.0 if path == "undrained" else 4.0 / 3.0)
    return columns | {
        "stress-xx": along - pressure,
        "stress-yy": -0.5 * along - pressure,
        "stress-zz": -0.5 * along - pressure,
        "q": 1.5 * np.abs(along),
    }


def sheared(
    value: Array, pressure: float, G: float, J: float, least: float, law: Callable[[float], float]
) -> dict[str, Array]:
    """Columns of simple shear: elastic, then steady flow; nan between them and after a turn.

    Parameters
    ----------
    value : (n,) float64
        Shear.
    pressure, G, J : float
        Pressure, shear modulus (of Kirchhoff's stress), volume ratio.
    least : float
        Shear stress at the beginning of flow.
    law : callable
        Takes the plastic part of the rate; returns the shear stress of flow.
    """
    g, sign = np.abs(value), np.sign(value)
    h = np.arcsinh(0.5 * g)
    elastic = 2.0 * G * h / J <= least
    tau = law(1.0)
    for _ in range(_ROUNDS):
        tau = law(1.0 / np.cosh(J * tau / G))
    steady = g >= g[elastic].max(initial=0.0) + _FADED * J * max(tau, least) / G
    root = np.where(elastic, 2.0 * G * h / J, tau)
    turned = np.where(elastic, 1.0 / np.cosh(h), 1.0 / np.cosh(J * tau / G))
    along = root * np.sqrt(1.0 - turned**2)
    known = first_leg(value) & (elastic | steady)
    columns = {
        "stress-xy": sign * root * turned,
        "q": np.sqrt(3.0) * root,
        "pressure": pressure + 0.0 * g,
        "stress-xx": along - pressure,
        "stress-yy": -along - pressure,
        "stress-zz": 0.0 * g - pressure,
    }
    return {name: np.where(known, column, np.nan) for name, column in columns.items()}
