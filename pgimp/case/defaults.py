"""Defaults of a case that depend on its other entries."""

from __future__ import annotations

from typing import Any

from pgimp.case.staging.inflow import with_constraints


def with_defaults(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in the vectors that are zero by default, and the condition on an axis."""
    dimensions = data.get("dimensions")
    if isinstance(dimensions, bool) or dimensions not in (1, 2, 3):
        return data
    zeros = (0.0,) * int(dimensions)
    data = with_constraints(data)
    data = dict(data)
    if isinstance(data.get("grid"), dict):
        data["grid"] = {"origin": zeros, **data["grid"]}
        faces, origin = data.get("boundaries", {}), data["grid"]["origin"]
        if data.get("geometry") == "axisymmetric" and isinstance(faces, dict):
            if isinstance(origin, list | tuple) and list(origin[:1]) == [0.0]:
                data["boundaries"] = {"x-min": "slip", **faces}
    bodies = data.get("bodies")
    if isinstance(bodies, dict):
        data["bodies"] = {
            name: {"velocity": zeros, **body}
            if isinstance(body, dict) and "rigid" not in body
            else body
            for name, body in bodies.items()
        }
        for body in data["bodies"].values():
            motion = body.get("velocity") if isinstance(body, dict) else None
            if isinstance(motion, dict) and "function" not in motion:
                body["velocity"] = {"translation": zeros, **motion}
    return data
