"""Faces of the domain with a condition, in the form that the solver uses."""

from collections.abc import Sequence
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np

from pgimp.kernels.data.frame import Frame
from pgimp.kernels.grid.faces import KIND, PARAMETERS, Faces
from pgimp.kernels.grid.position_limits import (
    COORDINATE,
    FACE,
    GRAVITY,
    HOLDS,
    MOTION,
    NUMBER,
    VELOCITY,
    WALL,
)
from pgimp.kernels.loads.wall_gap import Sides, Wall
from pgimp.physics.boundaries import BOUNDARIES
from pgimp.physics.boundaries.base import Boundary

AXES = "xyz"

#: Fraction of a cell by which rounding may carry a particle past a wall.
SLACK = 1e-6


class Face:
    """A face of the domain with a condition on it."""

    def __init__(self, name: str, condition: Boundary) -> None:
        self.name = name
        self.condition = condition
        self.axis = AXES.index(name[0])
        self.side = -1 if name.endswith("min") else 1

    def parameters(self, start: float, end: float) -> NamedTuple:
        """Parameters of the condition's kernel for a step."""
        return self.condition.parameters(self.axis, self.side, start, end)

    def coordinate(self, frame: Frame) -> float:
        """Coordinate of the face."""
        end = frame.cells[self.axis] if self.side > 0 else 0
        return frame.origin[self.axis] + end * frame.cell[self.axis]

    def wall(self, frame: Frame, end: float) -> tuple[float, float] | None:
        """Coordinate to which the face moves particles that pass it, and its velocity there.

        None where particles may pass: the face draws material out of the domain, or does not
        constrain the normal motion.
        """
        speed = self.condition.speed(self.axis, end)
        if speed is None or speed * self.side > 0.0:
            return None
        origin, cells, x = frame.origin[self.axis], frame.cells[self.axis], self.coordinate(frame)
        if self.side < 0:
            return x, speed
        # Just within the last cell: the gradient of a point on the face itself would act on
        # massless vertices beyond. The force that balances the face's would be lost.
        while (x - origin) * frame.inverse[self.axis] >= cells:
            x = float(np.nextafter(x, -np.inf))
        return x, speed


def _numbers(parameters: tuple | float) -> list[float]:
    """Numbers of nested tuples, flattened in order."""
    if isinstance(parameters, tuple):
        return [number for each in parameters for number in _numbers(each)]
    return [float(parameters)]


def _example(hint: Any) -> Any:
    """Make a value of a type: a number, a boolean, a tuple or NamedTuple of such."""
    if hasattr(hint, "_fields"):
        return hint(*(_example(each) for each in get_type_hints(hint).values()))
    return tuple(map(_example, get_args(hint))) if get_args(hint) else hint()


def table_of(parameters: Sequence[NamedTuple]) -> Faces:
    """Make the kernels' table of the parameters of each face's condition.

    It has all registered conditions, used or not, so that kernels are compiled once.
    """
    entries = [
        get_type_hints(entry.parameters)["return"]
        for entry in BOUNDARIES.values()
        if not entry.joins
    ]
    kinds = {kind: _example(kind) for kind in entries}
    kinds |= {type(each): each for each in parameters if type(each) not in kinds}
    width = max(len(_numbers(each)) for each in kinds.values())
    rows = np.zeros((len(parameters), PARAMETERS + width))
    for row, each in zip(rows, parameters, strict=True):
        row[KIND] = list(kinds).index(type(each))
        _set_row(row, each)
    return Faces(tuple(kinds.values()), rows)


def _set_row(row: np.ndarray, parameters: NamedTuple) -> None:
    values = _numbers(parameters)
    row[PARAMETERS : PARAMETERS + len(values)] = values


class FaceTable:
    """The faces for the kernels of a step.

    Parameters
    ----------
    faces : sequence of Face
        All faces with a condition.
    """

    def __init__(self, faces: Sequence[Face]) -> None:
        self._table: Any = table_of([face.parameters(0.0, 0.0) for face in faces]) if faces else ()
        self._settling: Any = self._table
        if any(face.condition.absorbs for face in faces):
            rest = [(face.condition.at_rest, face.axis, face.side) for face in faces]
            self._settling = table_of(
                [condition.parameters(axis, side, 0.0, 0.0) for condition, axis, side in rest]
            )
        self._vary = [(n, face) for n, face in enumerate(faces) if face.condition.varies]

    def at(self, start: float, end: float, settling: bool = False) -> Faces | tuple[()]:
        """Return `Faces`, or () if there are none, for a step; valid until the next call.

        While a run is `settling`, other conditions hold some of them, see `Boundary.at_rest`.
        """
        table = self._settling if settling else self._table
        for n, face in self._vary:
            _set_row(table.rows[n], face.parameters(start, end))
        return table


def walls(faces: Sequence[Face], frame: Frame, end: float) -> np.ndarray:
    """Faces that hold particles during a step to `end`.

    Returns
    -------
    (6, WALL) float64
        See `pgimp.kernels.grid.position_limits`; without gravity.
    """
    found = np.full((6, WALL), -1.0)
    found[:, GRAVITY] = found[:, HOLDS] = 0.0
    for number, face in enumerate(faces):
        wall, row = face.wall(frame, end), found[2 * face.axis + (face.side > 0)]
        row[COORDINATE], row[NUMBER] = face.coordinate(frame), number
        if wall is not None:
            row[FACE], row[COORDINATE], row[VELOCITY] = number, *wall
        motion = face.condition.motion(end)
        if motion is not None:
            row[HOLDS], row[MOTION:] = 1.0, motion
    return found


def position_bounds(faces: Sequence[Face], frame: Frame) -> tuple[tuple[float, float], ...]:
    """Coordinates between which bodies in the initial configuration have to stay.

    A body that starts on a wall at rest, or is held by it, cannot pass it. A body from elsewhere
    can: the wall's vertices act only on material that lies on them at the start. Other faces are
    no limit.
    """
    position_bounds = [[-np.inf, np.inf] for _ in frame.cell]
    for face in faces:
        if not face.condition.varies and face.condition.speed(face.axis, 0.0) == 0.0:
            d, slack = face.axis, face.side * SLACK * frame.cell[face.axis]
            position_bounds[d][face.side > 0] = float(face.coordinate(frame) + slack)
    return tuple((low, high) for low, high in position_bounds)


def walls_approached(faces: Sequence[Face]) -> list[Wall]:
    """Walls for `find_clearances`, made of the faces that bodies may approach."""
    return [
        Wall(face.axis, face.side, number)
        for number, face in enumerate(faces)
        if face.condition.approaches
    ]


def sides_approached(faces: Sequence[Face], frame: Frame) -> tuple[Sides, ...]:
    """Particle data of the walls that bodies may approach; () if there are none."""
    sides: list[Sides] = []
    for d, cell in enumerate(frame.cell):
        ends = frame.origin[d], frame.origin[d] + frame.cells[d] * cell
        own = [
            ends[face.side > 0] for face in faces if face.axis == d and face.condition.approaches
        ]
        if not own:
            sides.append(Sides(0.0, 0.0, 0.0, 0.0))  # no particle nearby
            continue
        # The range of vertices on the wall; two walls share the space between them.
        peak = min(1.25, 0.25 * frame.cells[d] if len(own) > 1 else 1.25) * cell
        sides.append(Sides(min(own), max(own), 0.5 * (min(own) + max(own)), peak))
    return tuple(sides) if any(side.peak > 0.0 for side in sides) else ()
