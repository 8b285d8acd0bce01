"""Checks of absorbing faces."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.physics.boundaries.base import Boundary
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_absorbing(geometry: str, boundaries: Mapping[str, Boundary]) -> Problems:
    """Check that waves leave through absorbing faces as plane ones."""
    for face, entry in boundaries.items():
        if entry.absorbs and geometry == "axisymmetric" and face.startswith("x"):
            yield Problem(
                ("boundaries", face),
                "absorbing is for plane waves, and along the radius waves are none: take slip or "
                "leave it open, farther away; y-min and y-max may absorb",
            )
