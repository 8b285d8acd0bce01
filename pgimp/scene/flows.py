"""Flowing bodies of a scene, whose particles are kept to the space that they fill."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.case.schema import Case
from pgimp.kernels.data.images import Images
from pgimp.physics.contact.pairs import Pairs
from pgimp.physics.materials.base import Material
from pgimp.scene.faces import Face

#: Most bodies that are calmed where there is contact: each needs a field of its own.
MOST_CALMED = 16


class SceneFlows:
    """Liquids, grains and loose soils of a scene.

    Parameters
    ----------
    materials : sequence of Material
        Materials in use.
    material_of : (bodies,) int64
        Material of each body.
    current : (bodies,) bool
        Whether each body is in the current configuration: others do not flow.
    faces : sequence of Face
        Faces with a condition.
    pairs : Pairs or None
        The laws of contact.

    Attributes
    ----------
    rates : (bodies,) float64
        Wave speed over the least side of a cell; 0 for bodies that do not flow. Also 0 for bodies
        that pass through others of the current configuration: shared space is no surplus.
    gap : (bodies,) int64
        State column of the gap by which a body has opened; -1 for others.
    most : (bodies,) float64
        Greatest J without voids, for flowing bodies without a gap; 0 for others.
    fields : tuple of int
        Number of each body's field of J. Flowing bodies of a material share one, except calmed
        bodies where there is contact, as neighbours may slide along each other.
    relaxes : bool
        Whether there are flowing bodies without a gap.
    calms : (bodies,) float64
        1 for bodies whose velocities are reduced to the part that the grid represents, else 0.
    walls : list of Images
        Impermeable faces.
    sides : (6,) bool
        Whether a face is impermeable: the low and the high end of x, y, z.
    fills : (rigid bodies,) bool
        Whether a rigid body displaces all flowing bodies: none of them passes through it.
    """

    def __init__(
        self,
        case: Case,
        materials: Sequence[Material],
        material_of: np.ndarray,
        current: np.ndarray,
        faces: Sequence[Face],
        pairs: Pairs | None,
    ) -> None:
        calms, cell = case.method.relaxation == "auto", case.grid.cell
        speeds = np.array([entry.flow_speed for entry in materials])
        gaps = np.array([_gap_of(entry, len(cell)) for entry in materials])
        own = (speeds > 0.0) & (gaps < 0)
        most = np.where(own, [entry.most_filled for entry in materials], 0.0)
        number = np.where(own, np.cumsum(own), 0) - int(own.all())
        self.rates = current * speeds[material_of] / min(cell)
        self.fills = np.ones(0, bool)
        if pairs is not None:
            bodies, passes = len(material_of), np.triu(pairs.entry == 0, 1)
            passes |= passes.T
            self.rates[(passes[:bodies, :bodies] & current).any(axis=1)] = 0.0
            self.fills = ~passes[:bodies, bodies:][self.rates > 0.0].any(axis=0)
        self.gap, self.most = gaps[material_of], most[material_of] * (self.rates > 0.0)
        grains = np.array([calms and entry.RESTS and not entry.LIQUID for entry in materials])
        self.calms = 1.0 * (grains[material_of] & (self.rates > 0.0))
        if pairs is not None and np.count_nonzero(self.calms) > MOST_CALMED:
            self.calms[:] = 0.0
        # A field keeps its number for ever: sums over fields have one order, also after a resume.
        apart = np.arange(len(material_of)) if pairs is not None else material_of
        keys = np.stack([number[material_of], self.calms * (apart + 1)], axis=1)
        self.fields = tuple(int(i) for i in np.unique(keys, axis=0, return_inverse=True)[1].ravel())
        self.relaxes = bool(own.any())
        self.walls = [
            Images(face.axis, face.side, n, False, False)
            for n, face in enumerate(faces)
            if face.condition.absorbs or face.condition.speed(face.axis, 0.0) is not None
        ]
        self.sides = np.zeros(6, bool)
        for wall in self.walls:
            self.sides[2 * wall.axis + (wall.side > 0)] = True


def _gap_of(entry: Material, dimensions: int) -> int:
    """State column of the gap by which a material has opened; -1 for others."""
    before = 0
    for state in entry.states if entry.flow_speed > 0.0 else ():
        if state.name == "gap":
            return before
        before += state.width(dimensions)
    return -1
