"""The domain of a scene: grid, conditions on its faces, and gravity."""

import math
from collections.abc import Sequence

import numpy as np

from pgimp.case.outflow import exits
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.kernels.data.frame import FRAMES, AxialFrame
from pgimp.kernels.data.images import Images
from pgimp.kernels.grid.faces import Faces
from pgimp.kernels.grid.position_limits import GRAVITY
from pgimp.kernels.loads.wall_gap import Sides
from pgimp.kernels.order.order import cell_numbers
from pgimp.kernels.update.turns import PERIODIC
from pgimp.scene.faces import (
    AXES,
    Face,
    FaceTable,
    position_bounds,
    sides_approached,
    walls,
    walls_approached,
)
from pgimp.scene.liquids import reflecting
from pgimp.scene.settings import Settings
from pgimp.schema.tables import VectorFunction


class Domain:
    """Grid, faces and gravity.

    Attributes
    ----------
    frame : Frame
        Position and size of the grid.
    faces : list of Face
        Faces with a condition, x-min to z-max. Unilateral walls come last where bodies in the
        initial configuration meet them.
    mirrors : list of Images
        Faces that reflect the part of supports beyond them.
    absorbing_mirrors : list of Images
        Absorbing faces, with which all that lies beyond them moves.
    approached : list of Wall
        Faces that bodies approach; `sides_approached` is their sides for loads.
    unilateral_walls : bool
        Whether bodies in the initial configuration meet unilateral walls: at their current
        position, not on their own grid.
    periodic : tuple of bool
        Directions in which the domain is periodic. `seams` are those across the planes; along x
        layers form a ring.
    exits : int
        Faces through which particles may leave, by bit; see `KernelScene`.
    bounds : tuple of (float, float) or None
        Coordinate limits of particles that the grid does not limit.
    absorbing : list of (int, Face)
        Absorbing faces and their numbers.
    settling : bool
        Whether the run comes to rest: absorbing faces then hold what is on them.
    """

    def __init__(self, case: Case, settings: Settings) -> None:
        grid, method, remote = case.grid, case.method, settings.by_vertex
        mirrored = reflecting(case)
        self.frame = FRAMES[case.geometry][0](
            origin=tuple(float(x) for x in grid.origin),
            cell=tuple(float(x) for x in grid.cell),
            inverse=tuple(1.0 / x for x in grid.cell),
            cells=tuple(
                round(size / cell) for size, cell in zip(grid.size, grid.cell, strict=True)
            ),
            ghost=settings.vertices - 1,
        )
        if cell_numbers(self.frame.vertices) >= 2**62:
            raise CaseError("grid.cell: more cells than can be numbered; use larger ones")
        named = case.boundaries
        order = [f"{axis}-{end}" for axis in AXES for end in ("min", "max")]
        self.faces = [
            Face(name, named[name]) for name in order if name in named and not named[name].joins
        ]
        self.periodic = tuple(
            f"{axis}-min" in named and named[f"{axis}-min"].joins
            for axis in AXES[: case.dimensions]
        )
        self.seams = [
            Images.of_seam(axis, self.frame.cells[axis])
            for axis, joined in enumerate(self.periodic)
            if joined and axis
        ]
        self.unilateral_walls = remote and any(face.condition.approaches for face in self.faces)
        if self.unilateral_walls:
            self.faces.sort(key=lambda face: face.condition.approaches)
        self.absorbing = [(n, face) for n, face in enumerate(self.faces) if face.condition.absorbs]
        self.settling = False
        periods = [PERIODIC + axis for axis, joined in enumerate(self.periodic) if joined]
        self.exits = sum(1 << bit for bit in (*map(order.index, exits(case.outflow)), *periods))
        # Unilateral walls come last: where they meet other walls, they use the sums of both.
        self.mirrors = sorted(
            (
                Images(face.axis, face.side, number, face.condition.releases, face.condition.sticks)
                for number, face in enumerate(self.faces)
                if face.name in mirrored and not (remote and face.condition.approaches)
            ),
            key=lambda mirror: mirror.releases,
        )
        self.absorbing_mirrors = [
            Images(face.axis, face.side, number, False, False, True)
            for number, face in self.absorbing
            if method.chi != "point" and not remote
        ]
        # Point particles give no gap: it would jump by half a cell as they move.
        near = [] if method.chi == "point" or remote else self.faces
        self.approached = walls_approached(near)
        self.sides_approached: tuple[Sides, ...] = sides_approached(near, self.frame)
        self.bounds = position_bounds(self.faces, self.frame) if remote else None
        self._face_table = FaceTable(
            [
                face
                for face in self.faces
                if not (self.unilateral_walls and face.condition.approaches)
            ]
        )
        self._pull = case.gravity
        self._gravity = self._gravity_at(0.0)
        # Faces that bodies approach vary by the length of the step alone.
        moves = any(each.condition.varies and not each.condition.approaches for each in self.faces)
        self._walls = None if moves else walls(self.faces, self.frame, 0.0)
        if self._walls is not None:
            self._walls[:, GRAVITY] = np.repeat(self._gravity, 2)

    @property
    def ring(self) -> int | None:
        """Number of the first layer of the ring along x; None where layers form a line."""
        return self.frame.ghost if self.periodic[0] else None

    @property
    def ring_layers(self) -> int:
        """Number of layers of the ring along x; 0 where they form a line."""
        return self.frame.cells[0] if self.periodic[0] else 0

    @property
    def periods(self) -> np.ndarray:
        """Period by direction, 0 where there is none, (D,)."""
        return np.where(self.periodic, np.multiply(self.frame.cells, self.frame.cell), 0.0)

    @property
    def ends(self) -> tuple[tuple[float, float], ...]:
        """Low end and period of each direction; () if none is periodic, see `fields.Source`."""
        if not any(self.periodic):
            return ()
        return tuple(zip(self.frame.origin, self.periods.tolist(), strict=True))

    def circumference(self, centroids: np.ndarray) -> np.ndarray:
        """Circumference 2 pi r of the rings with these centroids, (n, D).

        Times the areas of their sections it is their volumes (Pappus).
        """
        return np.asarray(2.0 * np.pi * centroids[:, 0])

    def tent_volume(self, place: Sequence[float]) -> float:
        """Integral of a vertex's tent about a position: a cell's volume, or its ring's."""
        volume = math.prod(self.frame.cell)
        if not isinstance(self.frame, AxialFrame):
            return volume
        h = self.frame.cell[0]
        beyond = max(0.0, h - place[0])  # of the axis, where there is nothing
        return 2.0 * math.pi * (place[0] + beyond**3 / (6.0 * h * h)) * volume

    def gravity(self, t: float) -> tuple[float, float, float]:
        """Gravity at a time, force per mass; zero in directions that the scene does not have."""
        return self._gravity_at(t) if isinstance(self._pull, VectorFunction) else self._gravity

    def _gravity_at(self, t: float) -> tuple[float, float, float]:
        b = self._pull
        if b is None:
            return (0.0, 0.0, 0.0)
        value = b.value(t) if isinstance(b, VectorFunction) else b
        x, y, z = (*(float(c) for c in value), 0.0, 0.0)[:3]
        return (x, y, z)

    def face_parameters(self, start: float, end: float) -> Faces | tuple[()]:
        """Conditions of the faces in a step, `Faces` or (); valid until the next call."""
        return self._face_table.at(start, end, self.settling)

    def standing_faces(self) -> Faces | tuple[()]:
        """All faces with a condition, for kernels that only need their positions."""
        return FaceTable(self.faces).at(0.0, 1.0)

    def walls(self, start: float, end: float) -> np.ndarray:
        """Faces that hold particles in during a step; valid until the next call.

        See `pgimp.kernels.grid.position_limits`.
        """
        found = self._walls
        if found is None:
            found = walls(self.faces, self.frame, end)
        elif not isinstance(self._pull, VectorFunction):
            return found
        found[:, GRAVITY] = np.repeat(self.gravity(start), 2)
        return found
