"""Checks of bodies in the initial configuration: what they can be combined with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

_INSTEAD = "; take configuration: current"


def check_configuration(
    method: Any,
    materials: Mapping[str, Any],
    bodies: Mapping[str, Any],
    tools: Mapping[str, Any],
    boundaries: Mapping[str, Any],
    escape: Mapping[str, str],
    contact: Sequence[Any],
) -> Problems:
    """Check that all bodies have the same configuration, and that the case is one for it."""
    initial = [name for name, body in bodies.items() if body.configuration == "initial"]
    if not initial:
        return
    first = initial[0]
    for name, body in bodies.items():
        if body.configuration != "initial":
            yield Problem(
                ("bodies", name, "configuration"),
                f"is current, and that of '{first}' initial; all bodies of a case have the same: "
                f"let '{name}' be initial too, or all be current",
            )
    for name in initial:
        law = materials.get(bodies[name].material)
        if law is not None and law.VOLUME_ONLY:
            yield Problem(
                ("bodies", name, "configuration"),
                f"'{bodies[name].material}' flows, and keeps no deformation; the initial "
                "configuration is for solids: take current",
            )
    if method.volumetric == "mean" and len(method.particles_per_cell) > 1:
        yield Problem(
            ("method", "volumetric"),
            f"mean is for the current configuration, and '{first}' is in the initial one; take "
            "pointwise, or configuration: current",
        )
    for name in tools:
        text = f"a rigid body meets nothing in the initial configuration, as '{first}' is{_INSTEAD}"
        yield Problem(("bodies", name, "rigid"), text)
    if contact:
        text = f"bodies in the initial configuration, as '{first}', do not meet yet{_INSTEAD}"
        yield Problem(("contact", 0), text)
    for face, entry in boundaries.items():
        if entry.approaches or entry.releases:
            yield Problem(
                ("boundaries", face),
                f"holds what comes against it; of bodies in the initial configuration, as "
                f"'{first}', a face holds what lies on it at the start, and does not let go: take "
                "fixed, slip or {velocity: ..}, or configuration: current",
            )
    for face in escape:
        yield Problem(
            ("escape", face),
            f"bodies in the initial configuration, as '{first}', may leave the domain, and stay "
            "what they are; leave it out",
        )
    if not method.tracked:
        yield Problem(
            ("method", "volume"),
            f"is for the current configuration; in the initial one, as of '{first}', forces are "
            "computed from the initial volume and the first Piola-Kirchhoff stress, exactly: leave "
            "it out",
        )
