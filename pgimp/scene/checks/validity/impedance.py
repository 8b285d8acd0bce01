"""Stress that a tool sends into a body by its speed alone, against the body's strength."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, radians, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pgimp.physics.rigid import Motion
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.supports import greatest
from pgimp.scene.checks.units import scales
from pgimp.scene.scene import Scene
from pgimp.schema.time_functions import TimeFunction

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Part of the strength from which this pressure is worth a word, and that which may be left of it.
_SHOWS, _LEFT, _LITTLE = 0.1, 0.2, 0.02
#: What is left of the pressure after N travel times of a wave, times N: strip footings on clay and
#: on soil with friction, of 1 to 1024 times the density, were too strong by 0.1 to 0.5 of it.
_SPREADS = 0.5


class Sent(NamedTuple):
    """What a tool sends into a body."""

    text: str  #: A sentence.
    #: Whether so much of it is left at the end of the run that the resistance is no static one.
    lasts: bool


def sent(stages: Sequence[Case], scene: Scene, bodies: Sequence[BodyFacts]) -> list[Sent]:
    """Return what is sent by each tool and grip, if a word is due.

    A face that moves at v into material of density rho and wave speed c meets a pressure of rho c v
    at once, whatever the strength. It spreads as waves go to and fro.

    Parameters
    ----------
    stages : sequence of Case
        The cases of all stages.
    scene : Scene
        Of the first stage; its densities have the factor of mass scaling.
    bodies : sequence of BodyFacts
        The bodies of the scene.
    """
    found: dict[str, Sent] = {}
    scaled = scene.case.time.mass_scaling != 1.0  # is meant to be slow
    for body in bodies:
        strength = strength_of(scene.case, body)
        for key, speed in _tools(stages, scene, body) if strength > 0.0 else ():
            pressure = body.density * body.wave_speed * speed
            transits = stages[-1].time.end * body.wave_speed / body.extent
            left = min(_SPREADS / transits, 1.0) * pressure
            lasts = left > _LEFT * strength
            if lasts or (scaled and pressure > _SHOWS * strength):
                text = _text(scene.case, (key, speed), body, (pressure, left, strength), transits)
                found.setdefault(key, Sent(text, lasts))
    return list(found.values())


def strength_of(case: Case, body: BodyFacts) -> float:
    """Stress that a body bears in compression, 0 if not known or without bound.

    The yield stress of metals. Of soil the difference of the principal stresses at which it
    fails, under the weight above its middle.
    """
    material = case.materials[case.bodies[body.name].material]

    def number(name: str) -> float | None:
        if name.replace("_", "-") in body.varies:
            return body.varies[name.replace("_", "-")][1]
        value: Any = getattr(material, name, None)
        return float(value) if isinstance(value, float | int) else None

    for name in ("yield_stress", "a"):
        if "plastic-work" in material.LOSSES and (value := number(name)):
            return value
    cohesion, angle = number("cohesion"), number("friction_angle")
    if cohesion is None or angle is None:
        return 0.0
    g = greatest(case.gravity, case.dimensions)
    pressure = 0.5 * body.density * float(np.max(g * body.sizes))
    S, C = sin(radians(angle)), cos(radians(angle))
    return 2.0 * (cohesion * C + pressure * S) / (1.0 - S)


def _tools(stages: Sequence[Case], scene: Scene, body: BodyFacts) -> Iterator[tuple[str, float]]:
    """Yield keys and greatest speeds of what is moved against a body, or moves a part of it."""
    pairs, number = scene.interaction.pairs, scene.body_names.index(body.name)
    rigid = scene.interaction.rigid_bodies
    for k, (name, entry) in enumerate(zip(rigid.names, rigid.entries, strict=True)):
        meets = pairs is None or pairs.entry[number, len(scene.body_names) + k] != 0
        if meets and isinstance(entry.rigid, Motion):
            yield f"bodies.{name}.rigid", entry.rigid.greatest()[0]
    for case in stages:
        for name, grip in case.constraints.items():
            if grip.body == body.name and grip.along:
                speeds = [
                    max(abs(v) for _, v in each.rows)
                    if isinstance(each, TimeFunction)
                    else abs(each or 0.0)
                    for each in grip.along
                ]
                yield f"constraints.{name}", float(np.linalg.norm(speeds))


def _text(
    case: Case,
    tool: tuple[str, float],
    body: BodyFacts,
    numbers: tuple[float, float, float],
    transits: float,
) -> str:
    (key, speed), (pressure, left, strength) = tool, numbers
    unit = " Pa" if scales(case.units) == (1.0, 1.0, 1.0) else ""
    factor = case.time.mass_scaling
    scaled = f" with mass-scaling: {factor:g}" if factor != 1.0 else ""
    text = (
        f"{key}: at {speed:.3g} it sends {pressure:.3g}{unit} into '{body.name}' by inertia alone "
        f"(density times wave speed times velocity{scaled}), whose strength is about "
        f"{strength:.2g}{unit}; after {transits:.2g} travel times of a wave about {left:.2g}{unit} "
        "are left of it in the resistance, by what footings have shown"
    )
    less = _LITTLE * strength / left
    if less >= 1.0:
        return text
    lower = f", or mass-scaling: {max(factor * less, 1.0):.2g}" if factor > 1.0 else ""
    return f"{text}; slow enough is {speed * less**0.5:.2g}, in a run as much longer{lower}"
