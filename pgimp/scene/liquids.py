"""The liquids of a scene, whose particles are kept to the space that they fill."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pgimp.kernels.mirror import Mirror
from pgimp.scene.faces import Face


class SceneLiquids:
    """The liquids of a scene.

    Parameters
    ----------
    materials : sequence of Material
        Those in use.
    material_of : (bodies,) int64
        Material of each body.
    faces : sequence of Face
        Faces with a condition.
    cell : tuple of float
        Sides of a cell.

    Attributes
    ----------
    rates : (bodies,) float64
        Speed of sound over the least side of a cell, 0 for bodies that are no liquids.
    most : (bodies,) float64
        The greatest J that counts as liquid, 0 likewise.
    fields : tuple of int
        Number of each body's field of J: liquids of a material share one.
    walls : list of Mirror
        Faces that the liquid cannot pass.
    sides : (6,) bool
        The same: the low and the high end of x, y, z.
    """

    def __init__(
        self, materials: Sequence[Any], material_of: np.ndarray, faces: Sequence[Face],
        cell: tuple[float, ...],
    ) -> None:  # fmt: skip
        speeds = np.array([entry.liquid_speed for entry in materials])
        most = np.array([entry.most_filled for entry in materials])
        self.rates = speeds[material_of] / min(cell)
        self.most = np.where(self.rates > 0.0, most[material_of], 0.0)
        number = np.where(speeds > 0.0, np.cumsum(speeds > 0.0), 0)
        number = number - int((speeds > 0.0).all())
        self.fields = tuple(int(i) for i in number[material_of])
        self.walls = [
            Mirror(face.axis, face.side, n, False, False)
            for n, face in enumerate(faces)
            if face.condition.speed(face.axis, 0.0) is not None
        ]
        self.sides = np.zeros(6, bool)
        for wall in self.walls:
            self.sides[2 * wall.axis + (wall.side > 0)] = True


def liquids_of(
    materials: Sequence[Any], material_of: np.ndarray, faces: Sequence[Face],
    cell: tuple[float, ...],
) -> SceneLiquids | None:  # fmt: skip
    """The liquids of a scene; None if it has none."""
    if not any(entry.liquid_speed > 0.0 for entry in materials):
        return None
    return SceneLiquids(materials, material_of, faces, cell)
