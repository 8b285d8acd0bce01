"""Water in the ground of a scene: its force on the particles of the bodies that it fills."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.case.schema import Case
from pgimp.kernels.data.particles import Particles
from pgimp.physics.loads.water import Buoyancy, Water, vertical_of
from pgimp.scene.materials import MaterialTable
from pgimp.schema.tables import VectorFunction
from pgimp.schema.time_functions import TimeFunction


class SceneWater:
    """The water of a case.

    Parameters
    ----------
    case : Case
        The case, with the key ``water``.
    materials : MaterialTable
        Its materials.

    Attributes
    ----------
    axis : int
        The vertical.
    """

    def __init__(self, case: Case, materials: MaterialTable) -> None:
        vertical = vertical_of(case.gravity)
        assert case.water is not None and case.gravity is not None and vertical is not None
        self.entry: Water = case.water
        (self.axis, self._up), self._pull = vertical, case.gravity
        axis = self.axis
        self._half = 0.5 * case.grid.cell[axis] / case.method.particles_per_cell[axis]
        number = len(case.bodies)
        self._inverse, self._column = np.zeros(number), np.full(number, -1)
        for body, name in enumerate(case.bodies):
            if not self.entry.fills(name):
                continue
            material = materials.body_material[body]
            layout = materials.variations.layouts[material]
            if layout is not None and ("density",) in layout.paths:
                self._column[body] = layout.indices[layout.paths.index(("density",))]
            self._inverse[body] = 1.0 / materials.entries[material].density

    @property
    def varies(self) -> bool:
        """Whether its force depends on time."""
        return isinstance(self.entry.level, TimeFunction) or isinstance(self._pull, VectorFunction)

    def at(self, t: float, other: Any = ()) -> Buoyancy:
        """Parameters of the kernels at a time, with the source of another body force."""
        pull = self._pull
        gravity = pull.value(t) if isinstance(pull, VectorFunction) else pull
        lift = -self.entry.density * float(gravity[self.axis])
        return Buoyancy(
            other, self.axis, self._up, lift, self.entry.height(t), self._half, self._inverse,
            self._column,
        )  # fmt: skip

    def lift(self, particles: Particles, count: int, t: float) -> np.ndarray:
        """Force against gravity on each of the first `count` particles, (count,)."""
        water, p = self.at(t), particles
        volume = self._inverse[p.body[:count]]
        column = self._column[p.body[:count]]
        rows = np.flatnonzero(column >= 0)
        volume[rows] = 1.0 / p.own[rows, column[rows]]
        below = 0.5 + 0.5 * (water.level - water.up * p.x[:count, self.axis]) / water.half
        return np.asarray(p.m[:count] * volume * abs(water.lift) * np.clip(below, 0.0, 1.0))
