"""Faces of the domain with a condition, as the solver sees them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pgimp.kernels.clearance import Sides, Wall
from pgimp.kernels.particles import Frame
from pgimp.kernels.walls import WALL

AXES = "xyz"

#: Part of a cell by which rounding may bring a particle past a wall.
SLACK = 1e-6


class Face:
    """A face of the domain with a condition on it."""

    def __init__(self, name: str, condition: Any) -> None:
        self.name = name
        self.condition = condition
        self.axis = AXES.index(name[0])
        self.side = -1 if name.endswith("min") else 1

    def parameters(self, start: float, end: float) -> Any:
        """Parameters of the condition's kernel for a step."""
        return self.condition.parameters(self.axis, self.side, start, end)

    def wall(self, frame: Frame, end: float) -> tuple[float, float] | None:
        """Coordinate onto which the face puts particles that pass it, and its velocity there.

        None where it lets them pass, since it draws the material out of the domain or leaves it
        free along its normal.
        """
        speed = self.condition.speed(self.axis, end)
        if speed is None or speed * self.side > 0.0:
            return None
        origin, cells = frame.origin[self.axis], frame.cells[self.axis]
        if self.side < 0:
            return origin, speed
        # Just within the last cell: on the face itself a point would have its gradient on vertices
        # beyond, without mass, where the force that balances the one on the face would be lost.
        place = origin + cells * frame.cell[self.axis]
        while (place - origin) * frame.inverse[self.axis] >= cells:
            place = float(np.nextafter(place, -np.inf))
        return place, speed


def walls(faces: Sequence[Face], frame: Frame, end: float) -> np.ndarray:
    """Where faces hold particles in during a step to `end`.

    Returns
    -------
    (6, 3) float64
        See `pgimp.kernels.walls`.
    """
    found = np.full((6, WALL), -1.0)
    for number, face in enumerate(faces):
        wall = face.wall(frame, end)
        if wall is not None:
            found[2 * face.axis + (face.side > 0)] = number, *wall
    return found


def room(faces: Sequence[Face], frame: Frame) -> tuple[tuple[float, float], ...]:
    """Coordinates between which bodies in the initial configuration have to stay.

    What lies on a wall that stands still, or is held by it, cannot pass it; what has passed it has
    come from elsewhere, and the wall could not know: its vertices hold what lies on them at the
    start. Other faces are no limit.
    """
    bounds = [[-np.inf, np.inf] for _ in frame.cell]
    for face in faces:
        if not face.condition.varies and face.condition.speed(face.axis, 0.0) == 0.0:
            d, end = face.axis, face.side > 0
            wall = frame.origin[d] + end * frame.cells[d] * frame.cell[d]
            bounds[d][end] = float(wall + face.side * SLACK * frame.cell[d])
    return tuple((low, high) for low, high in bounds)


def walls_approached(faces: Sequence[Face]) -> list[Wall]:
    """Make what `find_clearances` wants of the faces that let bodies come near."""
    return [
        Wall(face.axis, face.side, number)
        for number, face in enumerate(faces)
        if face.condition.approaches
    ]


def sides_approached(faces: Sequence[Face], frame: Frame) -> tuple[Any, ...]:
    """Make what particles are told of them; () if there is none."""
    sides: list[Any] = []
    for d, cell in enumerate(frame.cell):
        ends = frame.origin[d], frame.origin[d] + frame.cells[d] * cell
        own = [
            ends[face.side > 0] for face in faces if face.axis == d and face.condition.approaches
        ]
        if not own:
            sides.append(())
            continue
        # What vertices on the wall feel is not farther; two walls share what is between them.
        peak = min(1.25, 0.25 * frame.cells[d] if len(own) > 1 else 1.25) * cell
        sides.append(Sides(min(own), max(own), 0.5 * (min(own) + max(own)), peak))
    return tuple(sides) if any(sides) else ()
