"""The rigid bodies of a scene, and their poses in each step."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from hashlib import sha256
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.checks.rigid_bodies import meet_by_surfaces
from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.geometry.distancefield import DistanceField
from pgimp.geometry.outline import outline
from pgimp.geometry.sharpen import sharpened
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.rigid.bodies import BLOCK, LATTICE, MOTION, POINT, RESPONSE, RigidBodies
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.physics.rigid import Motion, Pose, Triple
from pgimp.scene.rigid.free_body import FreeBody, State
from pgimp.scene.rigid.images import (
    Middle,
    bound,
    nearest_image,
    own_ends,
    place,
    require_short,
    rings,
)
from pgimp.scene.rigid.measure import lattice_points, measure, require_densities

#: Compliance of a free body against held fields, over its compliance as a free body. This fraction
#: of a step's velocity change remains, divided among the body's vertices. With 1e-6 to 1e-2 a ball
#: falling on a held body comes to rest at the same position, to a per cent of its path. That holds
#: for a hundredth and for a hundred times the material's density.
SOFT = 1e-3


class Surface(NamedTuple):
    """Surfaces of rigid bodies: vertices, cells of them, and the body of each vertex."""

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    body: NDArray[np.int64]


class SceneRigidBodies:
    """The rigid bodies of a scene, with the poses of prescribed ones in each step.

    Parameters
    ----------
    frame : Frame
        Where the grid lies.
    periods : (D,) float64
        Period by direction, or 0.

    Attributes
    ----------
    names
        list of str.
    entries
        list of RigidBody.
    moving : list of int
        The numbers of those that may move: others are placed once.
    fields : list of DistanceField
        Their distances, after `measure`.
    rate : float
        Most cells that a point of a prescribed body crosses per unit of time; likewise.
    free : dict of int to FreeBody
        The free bodies, by number; likewise.
    arms : list of float
        Greatest distance of their surfaces from their centres of mass; likewise.
    thick : list of float
        Thickness of all bodies; likewise.
    ends : list of (2, D) float64
        Least and greatest coordinates of all bodies at the start; likewise.
    """

    def __init__(self, case: Case, frame: Frame, periods: NDArray[np.float64]) -> None:
        self.case, self.frame, self.periods = case, frame, periods
        self.rings = rings(frame, periods)
        self.names, self.entries = list(case.rigid_bodies), list(case.rigid_bodies.values())
        self.moving = [number for number, entry in enumerate(self.entries) if entry.moves]
        self.fields: list[DistanceField] = []
        self.rate = 0.0
        self.free: dict[int, FreeBody] = {}
        self.arms: list[float] = []
        self.thick: list[float] = []
        self.ends: list[NDArray[np.float64]] = []
        #: Pairs of rigid bodies that act on each other, by their numbers.
        self.meeting: frozenset[frozenset[int]] = frozenset()
        #: Whether bodies meet them at their surfaces.
        self.by_surfaces = meet_by_surfaces(case.bodies)
        self.meets_walls = False  # those that let go
        self._kept: RigidBodies | None = None
        self._placed: dict[int, tuple] = {}
        self._poses: dict[int, tuple[float, Pose]] = {}
        self._own_ends: list[list[list[float]]] = []

    def __len__(self) -> int:
        """Return the number of rigid bodies."""
        return len(self.entries)

    def points(self) -> float:
        """Return the number of points of all lattices, except lattices of meshes."""
        return sum(
            lattice_points(self.case, self.frame, entry)
            for entry in self.entries
            if not any(part.FROM_FILE for part in entry.region.simple())
        )

    def measure(self, comm: Communicator, keep: bool = False) -> None:
        """Compute the distances on rank 0, and share them with all ranks; collective.

        Surfaces from files are freed then, unless they are to be kept, see `release`.

        Raises
        ------
        CaseError
            On every rank, if a body is too thin, too large, too light or too heavy.
        """
        with located(self.case):
            require_densities(self.case)
            found = [
                on_root(comm, partial(measure, self.case, self.frame, name, entry))
                for name, entry in zip(self.names, self.entries, strict=True)
            ]
            self.fields = [one.field for one in found]
            self.thick, self.ends = [one.thick for one in found], [one.ends for one in found]
            around = len(self.frame.cell), self.rings, self.case.axisymmetric
            for number, (name, entry, one) in enumerate(
                zip(self.names, self.entries, found, strict=True)
            ):
                around_it = self.frame, self.periods, name, self.by_surfaces
                require_short(entry, one.field, *around_it)
                if one.inertia:
                    self.free[number] = FreeBody(name, entry, one.inertia, *around)
        # Steps depend on these: one rank computes them, because machines may round differently.
        self.rate = on_root(comm, self._greatest_rate)
        self.arms = on_root(comm, self._greatest_arms)
        self._kept = None
        if not keep:
            self.release()

    def release(self) -> None:
        """Free surfaces from files."""
        for entry in self.entries:
            for part in entry.region.simple():
                part.__dict__.pop("surface", None)

    def borrow(self, other: SceneRigidBodies) -> None:
        """Reuse another stage's measures of the same bodies as placeholders for compiling."""
        numbers = [other.names.index(name) for name in self.names]
        self.fields = [other.fields[number] for number in numbers]
        self.ends = [other.ends[number] for number in numbers]
        self.free = {
            own: other.free[number] for own, number in enumerate(numbers) if number in other.free
        }
        arms = dict(zip(other.free, other.arms, strict=True))
        self.arms = [arms[number] for number in numbers if number in arms]

    @cached_property
    def surface(self) -> Surface:
        """Surfaces of the bodies in their initial poses."""
        D = len(self.frame.cell)
        points, cells, body = [np.zeros((0, 3))], [np.zeros((0, 2 ** (D - 1)), np.int64)], []
        for number, field in enumerate(self.fields):
            vertices, faces = outline(field, D)
            cells.append(faces + sum(map(len, points)))
            points.append(vertices)
            body.append(np.full(len(vertices), number))
        return Surface(
            np.concatenate(points),
            np.concatenate(cells),
            np.concatenate([np.zeros(0, np.int64), *body]),
        )

    @cached_property
    def sharp(self) -> NDArray[np.float64]:
        """Vertices of `surface` with the corners of the bodies' regions, (n, 3), for pictures."""
        each = zip(self.fields, self.entries, strict=True)
        return np.concatenate(
            [
                sharpened(self.surface.points[self.surface.body == number], field, entry.region)
                for number, (field, entry) in enumerate(each)
            ]
        )

    @property
    def first(self) -> list[State]:
        """Initial states of the free bodies, in order."""
        return [body.first for body in self.free.values()]

    def rates(self, states: list[State]) -> list[float]:
        """Return the most cells that a point of each free body crosses per unit of time."""
        inverse, found = max(self.frame.inverse), []
        for body, state, arm in zip(self.free.values(), states, self.arms, strict=True):
            v = body.velocities(state)
            found.append((hypot(*v[:3]) + hypot(*v[3:]) * arm) * inverse)
        return found

    @property
    def first_rate(self) -> float:
        """Most cells that a point of any body crosses per unit of time at the start."""
        return max([self.rate, *self.rates(self.first)])

    def reference(self, number: int) -> Triple:
        """Return the reference point of a body's motion, in its initial position."""
        if number in self.free:
            return self.free[number].bulk.centre
        motion = self.entries[number].rigid
        assert isinstance(motion, Motion)
        return motion.reference

    def poses(self, time: float, states: list[State]) -> list[Pose]:
        """Return the poses of all bodies at a time; `states` are the free bodies'."""
        free = dict(zip(self.free, states, strict=True))
        return [self.pose(number, time, free) for number in range(len(self))]

    def pose(self, number: int, time: float, free: Mapping[int, State]) -> Pose:
        """Return the pose of a body at a time; `free` are the states of the free ones."""
        motion = self.entries[number].rigid
        if isinstance(motion, Motion):
            if self._poses.get(number, (None,))[0] != time:  # the end of a step begins the next
                self._poses[number] = time, motion.pose(time)
            return self._poses[number][1]
        return self.free[number].pose(free[number])

    def nearest(self, name: str, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points that lie to a body at the start as `x`, (n, D), do to its nearest image."""
        field = self.fields[self.names.index(name)]
        return nearest_image(x, field.middle[: x.shape[1]], self.periods)

    def surface_at(self, poses: list[Pose], sharp: bool = False) -> NDArray[np.float64]:
        """Return the vertices of `surface` for these poses, (n, 3), or those of `sharp`."""
        points = (self.sharp if sharp else self.surface.points).copy()
        for number, (centre, turn) in enumerate(poses):
            mine = self.surface.body == number
            own = points[mine] - np.array(self.reference(number))
            points[mine] = own @ np.array(turn).reshape(3, 3).T + np.array(centre)
        return points

    def at(self, start: float, end: float, states: list[State] | None = None) -> RigidBodies:
        """Return the kernels' rigid bodies for a step from `start` to `end`.

        `states` are the free bodies' states at the start of the step; their velocity at its end
        is set to the velocity at its start.
        """
        rigid_bodies, states = self.arrays(), self.first if states is None else states
        free = dict(zip(self.free, states, strict=True))
        for number in self.moving if self._placed else range(len(self)):
            row, lattice = rigid_bodies.motion[number], rigid_bodies.lattice[number]
            pose = self.pose(number, start, free)
            if isinstance(motion := self.entries[number].rigid, Motion):
                before, after = motion.velocities(start), motion.velocities(end)
                if self.by_surfaces:  # gaps close by what moves within the step
                    after = motion.mean_velocities(start, end)
                placed = (pose, before, after, motion.displacement(start))
                if self._placed.get(number) == placed:  # it waits for its time
                    continue
                self._placed[number] = placed
                row["velocity_before"] = before[0] + before[1]
                row["velocity_after"] = after[0] + after[1]
            else:
                for name in ("velocity_before", "velocity_after"):
                    row[name] = self.free[number].velocities(free[number])
            self.place(row, number, pose, start, free)
            bound(row, lattice, self._own_ends[number], self.frame, self.periods)
        return rigid_bodies

    def place(
        self, row: NDArray, number: int, pose: Pose, time: float, free: Mapping[int, State]
    ) -> None:
        """Set a body's pose; `free` are the states of the free bodies, by number."""
        field, motion, middle = self.fields[number], self.entries[number].rigid, None
        if self.rings:
            middle = Middle(self.rings, field.middle, field.middle - self.reference(number))
        home = motion if isinstance(motion, Motion) else free[number].home
        place(row, pose, middle, home, time)

    def speeds(self) -> dict[int, float]:
        """Return the greatest speed over time of a point of each prescribed body."""
        found = {}
        for number, entry in enumerate(self.entries):
            motion = entry.rigid
            if isinstance(motion, Motion):
                arm = self.surface.points[self.surface.body == number] - motion.reference
                across = np.linalg.norm(np.cross(arm, motion.axis), axis=1).max(initial=0.0)
                speed, spin = motion.greatest()
                found[number] = speed + spin * float(across)
        return found

    def _greatest_rate(self) -> float:
        """See `rate`."""
        return max(self.speeds().values(), default=0.0) * max(self.frame.inverse)

    def _greatest_arms(self) -> list[float]:
        """See `arms`."""
        found = []
        for number, body in self.free.items():
            arm = self.surface.points[self.surface.body == number] - body.bulk.centre
            found.append(float(np.sqrt(np.square(arm).sum(axis=1).max(initial=0.0))))
        return found

    @cached_property
    def checksum(self) -> str:
        """Checksum of the bodies with their meshes; empty without bodies."""
        if not self.fields:
            return ""
        return sha256(b"".join(field.values.tobytes() for field in self.fields)).hexdigest()

    def arrays(self) -> RigidBodies:
        """Return the kernels' constant data, and storage for the other data."""
        if self._kept is None:
            self._placed.clear()
            self._own_ends = [own_ends(f, self.reference(n)) for n, f in enumerate(self.fields)]
            count = len(self.entries)
            motion, lattice = np.zeros(count, MOTION), np.zeros(count, LATTICE)
            first, blocks = 0, [np.zeros(0)]
            for number, field in enumerate(self.fields):
                row, one = motion[number], lattice[number]
                row["reference"] = self.reference(number)
                row["spacing"], row["low"] = field.spacing, field.low
                one["points"], one["first"] = field.shape, first
                one["free"] = [*self.free].index(number) if number in self.free else -1
                if number in self.free:
                    row["compliance"] = SOFT / self.free[number].bulk.mass
                one["first_block"] = sum(map(len, blocks))
                first += len(field.values)
                blocks.append(field.least_by_block(BLOCK))
            values = np.concatenate([np.zeros((0, 5)), *(field.values for field in self.fields)])
            point, bodies = np.zeros(1, POINT), len(self.case.bodies)
            periods = np.array([*self.periods, 0.0, 0.0][:3]) if self.periods.any() else ()
            self._kept = RigidBodies(
                motion, lattice, values, np.concatenate(blocks), bodies, point, self._answers(0),
                periods,
            )  # fmt: skip
        return self._kept

    def in_planes(self, planes: int) -> RigidBodies:
        """Return the kernels' rigid bodies in their initial poses, with storage for some planes."""
        return self.at(0.0, 0.0)._replace(responses=self._answers(planes))

    def _answers(self, planes: int) -> np.ndarray | tuple[()]:
        return np.zeros((planes, len(self.free)), RESPONSE) if self.free else ()
