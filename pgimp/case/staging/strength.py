"""Strength reduction in a stage: cohesion and friction of soils over a factor of safety."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import atan, degrees, radians, tan
from typing import Any

from pydantic import Field

from pgimp.schema.base import Model, Name, Positive
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem

#: Names of the parameters of strength, as cases have them.
COHESION, FRICTION, DILATION, TENSION = "cohesion", "friction-angle", "dilation-angle", "tension"


class Strength(Model):
    """By what factor soils are weaker than the case has them."""

    factor: Positive = Field(
        description="cohesion, tension and the tangent of friction-angle are over this; "
        "dilation-angle stays, but is at most the friction-angle [1]"
    )
    materials: tuple[Name, ...] | None = Field(
        default=None,
        description="names of the materials; null: all that have a cohesion and a friction-angle",
    )

    def names(self, materials: Mapping[str, Any]) -> tuple[str, ...]:
        """Names of the materials that it is for."""
        if self.materials is not None:
            return self.materials
        return tuple(name for name, entry in materials.items() if _is_soil(entry))


def _is_soil(entry: Any) -> bool:
    return hasattr(entry, "cohesion") and hasattr(entry, "friction_angle")


def strength_problems(strength: Strength | None, materials: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problems of a strength, by paths in the stage; `materials` are the case's."""
    if strength is None:
        return
    soils = [name for name, entry in materials.items() if _is_soil(entry)]
    if not soils:
        yield Problem(
            ("strength-reduction",),
            "divides cohesion and friction-angle, and no material has both: take mohr-coulomb or "
            "drucker-prager, or let the stage change a parameter (materials)",
        )
        return
    for i, name in enumerate(strength.materials or ()):
        if name not in materials:
            text = unknown("material", name, materials)
        elif name not in soils:
            text = (
                f"'{name}' is {materials[name].model}, which has no cohesion and friction-angle; "
                f"there are: {', '.join(soils)}"
            )
        else:
            continue
        yield Problem(("strength-reduction", "materials", i), text)
    for name in strength.names(materials):
        if name in materials and materials[name].variations:
            yield Problem(
                ("strength-reduction",),
                f"'{name}' varies in space: its parameters are the particles' own from the start, "
                "and cannot change in a stage",
            )


def weakened(
    strength: Strength | None, data: Mapping[str, Any], materials: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the case of a stage with the weaker soils, as plain data.

    Parameters
    ----------
    strength : Strength, optional
        The stage's.
    data : mapping
        The case without it, from `Case.model_dump`.
    materials : mapping
        The case's materials, by which the soils are known.
    """
    if strength is None:
        return dict(data)
    F, entries = strength.factor, dict(data["materials"])
    for name in strength.names(materials):
        entry = entries[name] = dict(entries[name])
        # Of what is no number the check of the entry tells.
        for key in (COHESION, TENSION):
            if isinstance(entry.get(key), float | int):
                entry[key] = entry[key] / F
        friction = entry.get(FRICTION)
        if isinstance(friction, float | int) and 0.0 <= friction < 90.0:
            entry[FRICTION] = reduced_angle(friction, F)
            dilation = entry.get(DILATION)
            if isinstance(dilation, float | int) and dilation <= friction:
                entry[DILATION] = min(dilation, entry[FRICTION])
    return {**data, "materials": entries}


def reduced_angle(angle: float, factor: float) -> float:
    """Return the angle in degrees whose tangent is that of `angle` over `factor`."""
    return degrees(atan(tan(radians(angle)) / factor)) if factor != 1.0 else angle
