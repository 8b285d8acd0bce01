"""Loads on any part of a body's surface: their parameters for kernels."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import NamedTuple

from pydantic import Field

from pgimp.schema.base import Model, Positive
from pgimp.schema.tables import Varying
from pgimp.schema.time_functions import TimeFunction


def surface_width(dimensions: int) -> int:
    """Numbers of a particle's part of a surface: area, area vector, and its first moments."""
    return 1 + dimensions + dimensions**2


class SurfaceLoad(NamedTuple):
    """A load on a part of a surface during one step.

    Attributes
    ----------
    column : int
        First of the columns of ``particles.surface`` with the particles' parts.
    half : tuple of D float
        Half-widths over which a part is spread, in the initial state; zeros for points.
    follows : bool
        Whether areas and normals are current; else initial.
    stretches : bool
        Whether distances from particles follow the deformation, as the particles' size does.
    traction : tuple of 3 float
        Force per area.
    pressure : float
        Force per area against the normal, at the origin of coordinates.
    gradient : tuple of 3 float
        Gradient of the pressure in space.
    drifts : float or ()
        A number where areas and normals follow the particles' positions, not their F alone; alike
        for all loads of a scene.
    """

    column: int
    half: tuple[float, ...]
    follows: bool
    stretches: bool
    traction: tuple[float, float, float]
    pressure: float
    gradient: tuple[float, float, float]
    drifts: float | tuple[()] = ()


class Hydrostatic(Model):
    """The pressure of a liquid at rest, below its level."""

    level: Varying = Field(
        description="height of the liquid's surface, against gravity from the origin of "
        "coordinates: with gravity along -y the y of the surface [length]"
    )
    density: Positive = Field(description="density of the liquid [mass/length^3]")

    def pressure(
        self, gravity: Sequence[float], t: float
    ) -> tuple[float, tuple[float, float, float]]:
        """Return the pressure at the origin of coordinates at time `t`, and its gradient."""
        x, y, z = (*(self.density * g for g in gravity), 0.0, 0.0)[:3]
        level = self.level.value(t) if isinstance(self.level, TimeFunction) else self.level
        return hypot(x, y, z) * level, (x, y, z)
