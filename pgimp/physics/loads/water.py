"""Water in the ground: the entry of the case, and its parameters for kernels.

Below the level the pores are full of water at rest. Its pressure p grows with depth, and stresses
are effective ones. Their balance is div(sigma') - grad p + rho g = rho a. Thus water acts as a body
force of -rho_w g per volume, and presses on no surface of the ground, above which it may stand.

The volume is the initial one. The grains keep theirs: when pores close, water leaves with its
weight, and the weight of the grains in the water stays.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.schema.base import Model, Name, Positive
from pgimp.schema.tables import Varying, entries_of
from pgimp.schema.time_functions import TimeFunction


class Water(Model):
    """Water at rest in the pores, below a level."""

    level: Varying = Field(
        description="height of its surface, against gravity from the origin of coordinates: with "
        "gravity along -y the y of the surface; constant or over time [length]"
    )
    density: Positive = Field(description="density of the water [mass/length^3]")
    bodies: tuple[Name, ...] | None = Field(
        default=None, description="bodies whose pores it fills; null: all of a material"
    )

    def fills(self, body: str) -> bool:
        """Whether it is in the pores of a body."""
        return self.bodies is None or body in self.bodies

    def height(self, t: float) -> float:
        """Height of the level at a time."""
        return self.level.value(t) if isinstance(self.level, TimeFunction) else float(self.level)


def vertical_of(gravity: object) -> tuple[int, float] | None:
    """Axis of the greatest component of gravity over time, and 1 if up is along it, else -1.

    None if there is no gravity, or several axes have it.
    """
    rows = [row for _, row in entries_of(gravity)]
    if not rows:
        return None
    every = np.array(rows, float)
    sizes = np.abs(every).max(axis=0)
    axis = int(np.argmax(sizes))
    if np.count_nonzero(sizes == sizes[axis]) > 1 or not sizes[axis] > 0.0:
        return None
    along = every[:, axis].tolist()
    return axis, -1.0 if max(along, key=abs) > 0.0 else 1.0


class Buoyancy(NamedTuple):
    """The force of water in one step."""

    #: NamedTuple or (): Source of another body force, see `pgimp.physics.exact.base.BodyForce`.
    other: Any
    axis: int  #: The vertical.
    up: float  #: 1 where heights grow along the axis, else -1.
    lift: float  #: Force per volume along the axis.
    level: float  #: Height of the surface.
    half: float  #: Half-height of a particle, over which it submerges.
    inverse: np.ndarray  #: (bodies,) float64: Initial volume per mass, 0 for bodies without water.
    #: (bodies,) int64: Column of ``particles.own`` with the initial density where this varies; else
    #: -1.
    column: np.ndarray
