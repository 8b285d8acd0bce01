"""Exact curves of soils with friction along paths about the x-axis, `Material.exact_path`.

On such paths the Kirchhoff stress has the mean K theta, with theta the elastic volume strain. Its
axial minus lateral part is 2 G m, with m the axial minus lateral elastic strain, in amount. The
cones of Drucker and Prager and of Mohr and Coulomb are then lines, w 2 G m + z K theta <= c J.
Plastic flow adds d times as much to the volume as it takes from m. With given total strains this
is one linear equation; with a given lateral stress, one equation for theta.
"""

from __future__ import annotations

from math import cos, inf, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

from pgimp.physics.materials.base import lame
from pgimp.physics.materials.exact.rows import Array, first_leg, solved
from pgimp.physics.materials.laws.friction import Soil

#: Strains below which there is only rounding.
_NONE = 1e-15


class Line(NamedTuple):
    """Strength and flow in compression (side -1) or extension (+1) along the axis."""

    #: w, z, c: Coefficients of the line, see the head of this file.
    w: float
    z: float
    c: float
    d: float  #: Plastic volume strain over the plastic part of m.
    share: float  #: ``plastic-shear`` over the plastic part of m.
    mean: bool  #: Whether the greatest tension limits the mean stress, or every principal stress.


def cone(alpha: float, flow: float, k: float) -> Line:
    """Drucker and Prager's tau <= alpha p + k, with tau = 2 G m/sqrt(3)."""
    return Line(1.0 / sqrt(3.0), alpha, k, 2.0 * flow / sqrt(3.0), 2.0 / sqrt(3.0), True)


def edge(soil: Soil, side: float) -> Line:
    """Mohr and Coulomb's edge, where two principal stresses equal the lateral stress."""
    angle = radians(soil.friction_angle)
    S, s = sin(angle), sin(radians(soil.dilation_angle))
    strength = 2.0 * soil.cohesion * cos(angle)
    return Line(1.0 + side * S / 3.0, 2.0 * S, strength, 4.0 * s / (3.0 + side * s), 1.0, False)


def path_of_soil(
    soil: Soil, lines: tuple[Line, Line], path: str, value: Array, confine: float
) -> dict[str, Array] | None:
    """Return the exact columns of a soil, see `Material.exact_path`.

    Parameters
    ----------
    soil : Soil
        The entry.
    lines : pair of Line
        In compression and in extension.
    path, value, confine
        See `Material.exact_path`.
    """
    lam, G = lame(soil.young, soil.poisson)
    K, tension = lam + 2.0 / 3.0 * G, soil.greatest_tension
    # ln J where all principal stresses are -confine: -K ln J = confine J.
    before = float(
        solved(lambda x: (K * x + confine * np.exp(x), K + confine * np.exp(x)), np.zeros(1))[0]
    )
    volume = before + value
    if path == "isotropic":
        p = np.maximum(-K * volume * np.exp(-volume), -tension)
        gap = 0.0 * p
        if tension < inf:
            gap = np.maximum(volume - tension * np.exp(volume) / K, 0.0)
        return {"pressure": p, "q": 0.0 * p, "stress-xx": -p, "gap": gap}
    side = 1.0 if value[1] > 0.0 else -1.0
    line, e = lines[int(side > 0.0)], np.abs(value)
    if path in ("triaxial", "uniaxial-stress"):
        found = _stressed(soil, line, side, before, confine, e)
    elif path in ("uniaxial-strain", "oedometer"):
        found = _strained(G, K, line, side, tension, volume, e)
    elif path == "undrained":
        found = _strained(G, K, line, side, tension, 0.0 * value + before, 1.5 * e)
    else:
        return None
    known = first_leg(value)
    return {name: np.where(known, column, np.nan) for name, column in found.items()}


def _strained(
    G: float, K: float, line: Line, side: float, tension: float, volume: Array, M: Array
) -> dict[str, Array]:
    """Curves for given total strains: volume strain, and axial minus lateral strain M."""
    J = np.exp(volume)
    over = line.w * 2.0 * G * M + line.z * K * volume - line.c * J
    slip = np.maximum.accumulate(np.maximum(over, 0.0) / (line.w * 2.0 * G + line.z * K * line.d))
    m, elastic, gap = M - slip, volume - line.d * slip, 0.0 * M
    mean = K * elastic
    if line.mean:
        opens = mean > tension * J
        capped = np.where(opens, tension, 0.0) * J
        held = np.minimum(M, (line.c * J - line.z * capped) / (line.w * 2.0 * G))
        m, mean = np.where(opens, held, m), np.where(opens, capped, mean)
        slip = M - m
        gap = np.where(opens, volume - mean / K - line.d * slip, 0.0)
        known = np.ones_like(opens)
    else:
        greatest = mean + (4.0 if side > 0.0 else 2.0) / 3.0 * G * m
        known = np.logical_and.accumulate((greatest <= tension * J) & (m >= 0.0))
    q = np.where(np.abs(m) < _NONE, 0.0, 2.0 * G * m / J)
    mean = np.where(np.abs(mean) < _NONE * K, 0.0, mean)
    columns = {
        "stress-xx": mean / J + side * 2.0 / 3.0 * q,
        "pressure": -mean / J,
        "q": q,
        "plastic-shear": line.share * slip,
        "gap": gap,
    }
    return {name: np.where(known, column, np.nan) for name, column in columns.items()}


def _stressed(
    soil: Soil, line: Line, side: float, before: float, confine: float, e: Array
) -> dict[str, Array]:
    """Curves at a constant lateral stress: an elastic line, then a plateau of Cauchy's stress."""
    lam, G = lame(soil.young, soil.poisson)
    K, tension = lam + 2.0 / 3.0 * G, soil.greatest_tension

    # Elastic: 2 G m = side 3 (K theta + confine J), and m = side (3 axial - volume)/2.
    def elastic(x: Array) -> tuple[Array, Array]:
        J = np.exp(x)
        m = 0.5 * (3.0 * e - side * (x - before))
        return (
            side * 3.0 * (K * x + confine * J) - 2.0 * G * m,
            side * (3.0 * (K + confine * J) + G),
        )

    volume = solved(elastic, before + 0.0 * e)
    q = G * (3.0 * e - side * (volume - before)) * np.exp(-volume)
    # w q + z (side q/3 - confine) = c on the line.
    most = (line.c + line.z * confine) / (line.w + side * line.z / 3.0)
    bound = (3.0 if line.mean else 1.0) * (confine + tension)
    opens = side > 0.0 and bound < most
    most = bound if opens else most
    flows = q > most
    p = confine - side * most / 3.0

    def plastic(x: Array) -> tuple[Array, Array]:
        """Total minus elastic volume strain, minus d times the plastic part of m."""
        J = np.exp(x)
        slip = 0.5 * (3.0 * e - side * (x - before)) - 0.5 * most / G * J
        return (
            x + p / K * J - line.d * slip,
            1.0 + p / K * J + line.d * (0.5 * side + 0.5 * most / G * J),
        )

    q = np.where(flows, most, q)
    columns = {"stress-xx": side * q - confine, "pressure": confine - side * q / 3.0, "q": q}
    if opens:  # Opening depends on the history.
        unknown = np.where(flows, np.nan, 0.0)
        return columns | {"det-F": np.exp(volume) + unknown, "plastic-shear": unknown}
    volume = np.where(flows, solved(plastic, volume), volume)
    J = np.exp(volume)
    slip = 0.5 * (3.0 * e - side * (volume - before)) - 0.5 * q / G * J
    return columns | {"det-F": J, "plastic-shear": line.share * np.where(flows, slip, 0.0)}
