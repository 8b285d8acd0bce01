"""Angle at which loose soil comes to rest, against the angle of friction of the case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import asin, atan, cos, degrees, radians, sin, sqrt, tan
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.physics.materials.drucker_prager import DruckerPrager
from pgimp.physics.materials.laws.friction import Soil, cone_of
from pgimp.physics.materials.mu_i import MuI
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.supports import AXES, greatest
from pgimp.schema.pages import page

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Degrees between two angles that make a difference in a run-out.
_APART = 0.5
#: Cells from a floor within which a body lies on it.
_AT = 0.5


def rest_slope(soil: Soil) -> float:
    """Tangent of the slope at which a soil without cohesion shears in plane strain.

    With the sines S of friction and s of dilation in the plane it is S cos(dilation)/(1 - S s), of
    a slip plane along which nothing stretches (Davis, 1968). Without dilation that is S. A cone of
    slope alpha that flows with slope d has S = alpha r/(1 - alpha d/3), s = d/r, r = sqrt(1 - d
    d/3): see `pgimp.physics.materials.laws.friction.cone_of`.
    """
    S, s = sin(radians(soil.friction_angle)), sin(radians(soil.dilation_angle))
    if isinstance(soil, DruckerPrager):
        alpha, d, _ = cone_of(soil, soil.match)
        root = sqrt(1.0 - d * d / 3.0)
        S, s = alpha * root / (1.0 - alpha * d / 3.0), d / root
    return S * cos(asin(s)) / (1.0 - S * s)


def notes(case: Case, bodies: Sequence[BodyFacts]) -> Iterator[str]:
    """Yield notes on loose soils under gravity: where they rest, and how to get an angle.

    Parameters
    ----------
    bodies : sequence of BodyFacts
        Its bodies.
    """
    g = greatest(case.gravity, case.dimensions)
    if case.dimensions == 1 or case.axisymmetric or not g.any():  # what spreads round has hoops
        return
    loose: dict[str, list[BodyFacts]] = {}
    for body in bodies:
        name = case.bodies[body.name].material
        if isinstance(case.materials[name], MuI | Soil) and case.materials[name].flow_speed > 0.0:
            loose.setdefault(name, []).append(body)
    for name, own in loose.items():
        material: Any = case.materials[name]
        if isinstance(material, MuI):
            if not material.variations and np.count_nonzero(g) == 1:  # no chute
                yield _creeps(name, material)
        elif not {("friction_angle",), ("dilation_angle",)} & set(material.variations):
            yield f"materials.{name}: {_rests(material)}"
        yield from _floors(case, own, g, name)


def _rests(soil: Soil) -> str:
    """Where a soil rests, and which parameters would have it rest at its angle of friction."""
    phi, psi = soil.friction_angle, soil.dilation_angle
    slope = rest_slope(soil)
    angle = degrees(atan(slope))
    text = f"slopes and heaps of it rest at {angle:.3g} degrees (tan {slope:.3g})"
    if abs(angle - phi) < _APART:
        return text
    why = f"sheared with dilation-angle: {psi:g}, not at friction-angle: {phi:g}"
    wanted = tan(radians(phi))
    if wanted >= 1.0:
        return f"{text}, {why}"
    flow = isinstance(soil, DruckerPrager) and soil.match != "plane-strain-flow"
    match = "match: plane-strain-flow, " * flow
    how = f"take {match}friction-angle: {degrees(asin(wanted)):.3g} and dilation-angle: 0"
    how = f"; if {phi:g} is the angle of repose, {how}"
    return f"{text}, {why}{how} ({page('soils-and-fluids.md#soils')})"


def _creeps(name: str, material: MuI) -> str:
    slope = material.mu_s
    return (
        f"materials.{name}: slopes of it stop at {degrees(atan(slope)):.3g} degrees (mu-s), and "
        f"creep on from there ({page('soils-and-fluids.md#soils')})"
    )


def _floors(case: Case, bodies: Sequence[BodyFacts], g: np.ndarray, name: str) -> Iterator[str]:
    """Yield a note on a floor that holds what lies on it, so that the lowest cells shear."""
    down = int(np.argmax(g))
    if np.count_nonzero(g) > 1:
        return
    value: Any = case.gravity
    first = value.rows if hasattr(value, "rows") else [(0.0, value)]
    below = min(first, key=lambda row: row[1][down])[1][down] < 0.0
    face = f"{AXES[down]}-{'min' if below else 'max'}"
    condition = case.boundaries.get(face)
    if condition is None or not condition.sticks:
        return
    cell, origin, corner = case.grid.cell[down], case.grid.origin[down], case.grid.corner[down]
    gaps = [one.low[down] - origin if below else corner - one.high[down] for one in bodies]
    open_sides = any(
        one.low[d] > case.grid.origin[d] + cell or one.high[d] < case.grid.corner[d] - cell
        for one in bodies
        for d in range(case.dimensions)
        if d != down
    )
    if min(gaps) <= _AT * cell and open_sides:
        yield (
            f"boundaries.{face}: a fixed floor holds the lowest vertices, so that '{name}' shears "
            "in the lowest row of cells and runs out farther; as a floor take {unilateral: "
            "{friction: ..}} with the tangent of its angle"
        )
