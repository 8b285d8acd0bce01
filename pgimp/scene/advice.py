"""Advice on the initial configuration, for ``pgimp check``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pgimp.scene import nearness
from pgimp.scene.facts import BodyFacts
from pgimp.scene.sanity import strains

#: Displacement in cells, and strain, from which the configuration makes a difference.
_FAR, _MUCH = 0.5, 0.05


def advice(case: Any, bodies: Sequence[BodyFacts]) -> list[str]:
    """Return whether bodies that move, turn or stretch would do better in the initial one.

    That is for elastic bodies whose contacts are those that hold them from the start, or that work
    there, too.
    """
    if not all(_fits(case, body) for body in case.bodies.values()):
        return []
    if case.escape or nearness.meet(case):
        return []
    if case.method.volumetric == "mean" or "contact" in case.output.grid:
        return []
    cell, end = min(case.grid.cell), case.time.end
    moved = [
        body.name
        for body in bodies
        if body.top_speed * end > _FAR * cell or max(strains(case, body).values()) > _MUCH
    ]
    if not moved:
        return []
    them = "it moves" if len(moved) == 1 else "they move"
    return [
        f"bodies: {', '.join(map(repr, moved[:3]))}{' and others' * (len(moved) > 3)}: elastic, "
        f"and {them} or deform: with configuration: initial vibrations and spin last, nothing can "
        "tear, and steps need not be shorter as bodies move"
    ]


def _fits(case: Any, body: Any) -> bool:
    """Whether a body is elastic, and not in the initial configuration yet."""
    return body.configuration == "current" and case.materials[body.material].ELASTIC
