"""Exact curves of modified Cam-clay, `Material.exact_path`: isotropic, and undrained about x.

Kirchhoff's stress throughout, as in `pgimp.physics.materials.cam_clay`. Isotropic: ln p falls by
v/kappa per volume strain, and in first compression, where p = p_c, by v/lambda. Undrained: the
volume is constant, so elastic swelling balances plastic compaction,

    p = p_y ((1 + (eta_y/M)^2)/(1 + (eta/M)^2))^Lambda,  eta = q/p,  Lambda = 1 - kappa/lambda.

The plastic shear strain is the integral of 2 eta/(M^2 - eta^2) over the plastic compaction. In
closed form it is 2 Lambda kappa/(v M) (artanh(eta/M) - arctan(eta/M)), arcoth on the dry side.
"""

from __future__ import annotations

from math import log, sqrt
from typing import NamedTuple

import numpy as np

from pgimp.physics.materials.exact.rows import Array, first_leg

_HALVINGS = 100
#: artanh(eta/M) from which eta equals M to rounding.
_ALL = 20.0


class Clay(NamedTuple):
    """M, v/kappa, v/lambda, G, preconsolidation pressure and pressure at the start."""

    slope: float
    swells: float
    compacts: float
    shear: float
    consolidated: float
    pressure: float


def path_of_clay(clay: Clay, path: str, value: Array, confine: float) -> dict[str, Array] | None:
    """Return the exact columns of a clay, see `Material.exact_path`."""
    first = -log(clay.consolidated / clay.pressure) / clay.swells  # ln J at first yield
    # ln J where Cauchy's pressure is the confining pressure.
    before = -log(confine / clay.pressure) / (clay.swells + 1.0)
    if before < first:
        before = first - (log(confine / clay.consolidated) + first) / (clay.compacts + 1.0)
    if path == "isotropic":
        volume = before + value
        p, consolidated, compaction = _isotropic(clay, first, volume)
        p = p * np.exp(-volume)
        return {
            "pressure": p,
            "q": 0.0 * p,
            "stress-xx": -p,
            "preconsolidation": consolidated,
            "plastic-compaction": compaction,
        }
    if path == "undrained":
        return _undrained(clay, first, before, value)
    return None


def _isotropic(clay: Clay, first: float, volume: Array) -> tuple[Array, Array, Array]:
    """Pressure, preconsolidation pressure and plastic compaction, in any order of volumes."""
    most = np.maximum(first - np.minimum.accumulate(volume), 0.0)
    compaction = most * (1.0 - clay.compacts / clay.swells)
    p = clay.pressure * np.exp(-clay.swells * (volume + compaction))
    return p, clay.consolidated * np.exp(clay.compacts * most), compaction


def _undrained(clay: Clay, first: float, before: float, value: Array) -> dict[str, Array]:
    """Curves of shear at constant volume, up to the critical state; nan beyond a snap-back."""
    M, stiffness, e = clay.slope, 3.0 * clay.shear, np.abs(value)
    start = _isotropic(clay, first, np.array([before]))
    p0, consolidated, compaction = (float(each[0]) for each in start)
    x0 = sqrt(max(consolidated / p0 - 1.0, 0.0))
    wet, part = x0 < 1.0, 1.0 - clay.compacts / clay.swells
    factor = 2.0 * part / (clay.swells * M)

    def stress(y: Array) -> tuple[Array, Array, Array]:
        """eta/M, p, and shear strain since yield, for y = artanh(eta/M) or arcoth."""
        x = np.tanh(y) if wet else 1.0 / np.tanh(y)
        p = p0 * ((1.0 + x0 * x0) / (1.0 + x * x)) ** part
        strain = factor * (y - y0 - np.arctan(x) + np.arctan(x0))
        return x, p, strain + M * (x * p - x0 * p0) / stiffness

    y0 = float(np.arctanh(x0 if wet else 1.0 / x0)) if x0 != 1.0 else np.inf
    yields = e > M * x0 * p0 / stiffness
    if np.isfinite(y0):
        trial = stress(y0 + np.linspace(0.0, _ALL, 2001))[2]
        known = first_leg(value) & (~yields | bool((np.diff(trial) > 0.0).all()))
        beyond = e - M * x0 * p0 / stiffness
        low, high = np.full_like(e, y0), y0 + 2.0 + (e + M * x0 * p0 / stiffness) / factor
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            short = stress(middle)[2] < beyond
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        x, p, _ = stress(high)
    else:  # It yields at the critical state, and stays there.
        x, p, known = np.ones_like(e), np.full_like(e, p0), first_leg(value)
    q = np.where(yields, M * x * p, stiffness * e)
    p = np.where(yields, p, p0)
    J = np.exp(before)
    columns = {
        "pressure": p / J,
        "q": q / J,
        "stress-xx": (np.sign(value) * 2.0 / 3.0 * q - p) / J,
        "preconsolidation": np.where(yields, p * (1.0 + x * x), consolidated),
        "plastic-compaction": compaction + np.log(p0 / p) / clay.swells,
    }
    return {name: np.where(known, column, np.nan) for name, column in columns.items()}
