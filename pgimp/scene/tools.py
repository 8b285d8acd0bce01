"""The rigid bodies of a scene: their distances, and where they are in each step."""

from __future__ import annotations

from functools import cached_property, partial
from hashlib import sha256
from itertools import product
from math import hypot
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.places import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.distancefield import MARGIN, DistanceField, distance_field, extent, thickness
from pgimp.geometry.outline import outline
from pgimp.kernels.particles import Frame
from pgimp.kernels.tools import (
    ABOUT,
    ANSWER,
    AT,
    CENTRE,
    FIRST,
    FORMER,
    FREE,
    LATTER,
    LEAST,
    LOW,
    MOST,
    MOTION,
    REFERENCE,
    SHAPE,
    SPACING,
    TURN,
    YIELDS,
    Tools,
)
from pgimp.mpi.collective import on_root
from pgimp.physics.rigid import Motion, Pose, RigidBody, Triple
from pgimp.scene.bulk import Bulk, bulk
from pgimp.scene.freebody import FreeBody, State
from pgimp.schema.tables import VectorTable

#: Instants at which the way of a body that does not turn is looked at, to know what of it matters.
_INSTANTS = 2000

#: Least density of a free body, over that of the material around it; and the other way round.
LIGHTEST = 1e-10

#: How much a free body yields to what is held, over how much it would if nothing else held it: of
#: a step's change of velocity this part is left, divided among the vertices that it is on.
#: From 1e-6 to 1e-2 a ball that falls on what is held comes to rest at the same place, to a per
#: cent of its way, with a hundredth of the material's density as with a hundred times it.
SOFT = 1e-3

#: Points that a lattice may have: about 1 GB.
_MOST_POINTS = 30_000_000


class Surface(NamedTuple):
    """Surfaces of rigid bodies: vertices, cells of them, and the body of each vertex."""

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    body: NDArray[np.int64]


class SceneTools:
    """The rigid bodies: of those that move as prescribed, also where they are in each step.

    Parameters
    ----------
    case : Case
        The case.
    frame : Frame
        Where the grid lies.

    Attributes
    ----------
    names : list of str
    entries : list of RigidBody
    fields : list of DistanceField
        Their distances, after `measure`.
    rate : float
        Cells that a point of any body that moves as prescribed crosses in a unit of time, at most;
        likewise.
    free : dict of int to FreeBody
        Those that move freely, by number; likewise.
    arms : list of float
        Greatest distance of their surfaces from their centres of mass; likewise.
    thick : list of float
        Thickness of all bodies; likewise.
    """

    def __init__(self, case: Case, frame: Frame) -> None:
        self.case, self.frame = case, frame
        self.names, self.entries = list(case.tools), list(case.tools.values())
        self.fields: list[DistanceField] = []
        self.rate = 0.0
        self.free: dict[int, FreeBody] = {}
        self.arms: list[float] = []
        self.thick: list[float] = []
        self._kept: Any = None

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.entries)

    def points(self) -> float:
        """Return the number of points of all lattices but those of meshes."""
        return sum(
            float(np.prod(extent(entry.region, self.frame.cell, self._within(entry))[2] * 1.0))
            for entry in self.entries
            if not any(part.FROM_FILE for part in entry.region.simple())
        )

    def measure(self, comm: Any) -> None:
        """Find the distances, on rank 0, and let all ranks have them; collective.

        Raises
        ------
        CaseError
            On every rank: a body that is too thin, too large, too light or too heavy.
        """
        with located(self.case):
            self._weigh()
            found = [
                on_root(comm, partial(self._read_and_measure, name, entry))
                for name, entry in zip(self.names, self.entries, strict=True)
            ]
            self.fields = [field for field, _, _ in found]
            self.thick = [thick for _, thick, _ in found]
            for number, (name, entry, (_, _, inertia)) in enumerate(
                zip(self.names, self.entries, found, strict=True)
            ):
                if inertia:
                    self.free[number] = FreeBody(name, entry, inertia, len(self.frame.cell))
        # Steps depend on these: one rank computes them, as machines may round otherwise.
        self.rate = on_root(comm, self._greatest_rate)
        self.arms = on_root(comm, self._greatest_arms)
        self._kept = None

    def _weigh(self) -> None:
        """Refuse free bodies whose mass no solution of six equations can bear."""
        used = (self.case.materials[body.material] for body in self.case.bodies.values())
        densities = [material.typical("density") for material in used]
        low, high = LIGHTEST * min(densities), max(densities) / LIGHTEST
        for name, entry in zip(self.names, self.entries, strict=True):
            if entry.free and not low <= entry.free.density <= high:
                raise CaseError(
                    f"bodies.{name}.rigid.density: {entry.free.density:.3g}, and bodies of a "
                    f"material have {min(densities):.3g} to {max(densities):.3g}; with less than "
                    f"{LIGHTEST:g} of the least, or more than that part says of the greatest, "
                    "rounding decides how it moves"
                )

    def _read_and_measure(
        self, name: str, entry: RigidBody
    ) -> tuple[DistanceField, float, Bulk | None]:
        """Measure a body, of which meshes are in memory no longer than that."""
        try:
            free, D = entry.free, len(self.frame.cell)
            field = self._measure(entry)
            inertia = bulk(entry.region, free.density, D) if free else None
            return field, thickness(entry.region, D), inertia
        except CaseError as error:
            raise CaseError(f"bodies.{name}.region: {error}") from None
        finally:
            for part in entry.region.simple():
                part.__dict__.pop("surface", None)

    def _measure(self, entry: RigidBody) -> DistanceField:
        cell, within = self.frame.cell, self._within(entry)
        thick = thickness(entry.region, len(cell))
        if thick < (1.0 - 1e-3) * min(cell):
            raise CaseError(
                f"is {thick:.2g} thick at most, and cells are {min(cell):.6g} wide: what meets it "
                "would feel both of its sides at once; make it thicker, on a side that meets "
                "nothing, or the cells smaller"
            )
        points = float(np.prod(extent(entry.region, cell, within)[2].astype(float)))
        if points > _MOST_POINTS:
            raise CaseError(
                f"is too large for these cells: it would take {points:.3g} distances half a cell "
                f"apart, where {_MOST_POINTS:.3g} are possible; leave out what meets nothing"
            )
        return distance_field(entry.region, cell, within)

    def _within(self, entry: RigidBody) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Ends of the part of a body, where it is at the start, that comes into the domain."""
        motion = entry.rigid
        if not isinstance(motion, Motion) or motion.rotation is not None:
            return None
        D, grid = len(self.frame.cell), self.case.grid
        end, velocity = self.case.time.end, motion.velocity
        times = np.linspace(0.0, end, _INSTANTS if motion.moves else 1)
        if isinstance(velocity, VectorTable):
            rows = np.array([time for time, _ in velocity.table])
            times = np.concatenate([times, rows[(rows > 0.0) & (rows < end)]])
        ways = np.array([motion.displacement(float(t))[:D] for t in times])
        slack = (MARGIN + 1.0) * np.array(self.frame.cell)
        low = np.array(grid.origin, float) - ways.max(axis=0) - slack
        return low, np.array(grid.corner, float) - ways.min(axis=0) + slack

    @cached_property
    def surface(self) -> Surface:
        """The surfaces where the bodies are at the start."""
        D = len(self.frame.cell)
        points, cells, body = [np.zeros((0, 3))], [np.zeros((0, 2 ** (D - 1)), np.int64)], []
        for number, field in enumerate(self.fields):
            vertices, faces = outline(field, D)
            cells.append(faces + sum(map(len, points)))
            points.append(vertices)
            body.append(np.full(len(vertices), number))
        return Surface(
            np.concatenate(points), np.concatenate(cells),
            np.concatenate([np.zeros(0, np.int64), *body]),
        )  # fmt: skip

    @property
    def first(self) -> list[State]:
        """How those that move freely move at the start, in their order."""
        return [body.first for body in self.free.values()]

    def rates(self, states: list[State]) -> list[float]:
        """Return the cells that points of those that move freely cross in a unit of time."""
        inverse, found = max(self.frame.inverse), []
        for body, state, arm in zip(self.free.values(), states, self.arms, strict=True):
            v = body.velocities(state)
            found.append((hypot(*v[:3]) + hypot(*v[3:]) * arm) * inverse)
        return found

    @property
    def first_rate(self) -> float:
        """Cells that a point of any body crosses in a unit of time at the start, at most."""
        return max([self.rate, *self.rates(self.first)])

    def reference(self, number: int) -> Triple:
        """Return the point of a body that its motion refers to, where it is at the start."""
        if number in self.free:
            return self.free[number].bulk.centre
        motion = self.entries[number].rigid
        assert isinstance(motion, Motion)
        return motion.reference

    def poses(self, time: float, states: list[State]) -> list[Pose]:
        """Return where all are at a time, those that move freely in these states."""
        free = zip(self.free.items(), states, strict=True)
        placed = {number: body.pose(state) for (number, body), state in free}
        return [
            entry.rigid.pose(time) if isinstance(entry.rigid, Motion) else placed[number]
            for number, entry in enumerate(self.entries)
        ]

    def surface_at(self, poses: list[Pose]) -> NDArray[np.float64]:
        """Return the vertices of `surface` where the bodies are there, (n, 3)."""
        points = self.surface.points.copy()
        for number, (centre, turn) in enumerate(poses):
            mine = self.surface.body == number
            own = points[mine] - np.array(self.reference(number))
            points[mine] = own @ np.array(turn).reshape(3, 3).T + np.array(centre)
        return points

    def at(self, start: float, end: float, states: list[State] | None = None) -> Tools:
        """Return them for the kernels of a step from `start` to `end`.

        Of those that move freely, `states` says how at its start; the velocity at its end is then
        the same.
        """
        tools, states = self._arrays(), self.first if states is None else states
        free = dict(zip(self.free, states, strict=True))
        for number, (pose, entry, field) in enumerate(
            zip(self.poses(start, states), self.entries, self.fields, strict=True)
        ):
            row, about = tools.motion[number], tools.about[number]
            row[CENTRE : CENTRE + 3], row[TURN : TURN + 9] = pose
            for column, time in ((FORMER, start), (LATTER, end)):
                if isinstance(entry.rigid, Motion):
                    row[column : column + 6] = np.concatenate(entry.rigid.velocities(time))
                else:
                    row[column : column + 6] = self.free[number].velocities(free[number])
            self._bound(row, about, field)
        return tools

    def _greatest_rate(self) -> float:
        """See `rate`."""
        fastest = 0.0
        for number, entry in enumerate(self.entries):
            motion = entry.rigid
            if not isinstance(motion, Motion):
                continue
            arm = self.surface.points[self.surface.body == number] - motion.reference
            across = np.linalg.norm(np.cross(arm, motion.axis), axis=1).max(initial=0.0)
            speed, spin = motion.greatest()
            fastest = max(fastest, speed + spin * float(across))
        return fastest * max(self.frame.inverse)

    def _greatest_arms(self) -> list[float]:
        """See `arms`."""
        found = []
        for number, body in self.free.items():
            arm = self.surface.points[self.surface.body == number] - body.bulk.centre
            found.append(float(np.sqrt(np.square(arm).sum(axis=1).max(initial=0.0))))
        return found

    @cached_property
    def checksum(self) -> str:
        """What tells these bodies from others, whose mesh has changed; empty without any."""
        if not self.fields:
            return ""
        return sha256(b"".join(field.values.tobytes() for field in self.fields)).hexdigest()

    def _arrays(self) -> Tools:
        """Return what does not change, and room for what does."""
        if self._kept is None:
            count = len(self.entries)
            motion, about = np.zeros((count, MOTION)), np.zeros((count, ABOUT), np.int64)
            first = 0
            for number, field in enumerate(self.fields):
                row, one = motion[number], about[number]
                row[REFERENCE : REFERENCE + 3] = self.reference(number)
                row[SPACING], row[LOW : LOW + 3] = field.spacing, field.low
                one[SHAPE : SHAPE + 3], one[FIRST] = field.shape, first
                one[FREE] = [*self.free].index(number) if number in self.free else -1
                if number in self.free:
                    row[YIELDS] = SOFT / self.free[number].bulk.mass
                first += len(field.values)
            values = [field.values for field in self.fields]
            self._kept = Tools(
                motion, about, np.concatenate(values) if values else np.zeros((0, 5)),
                len(self.case.bodies), np.zeros(AT), self._answers(0),
            )  # fmt: skip
        return self._kept

    def in_planes(self, planes: int) -> Tools:
        """Return them for the kernels, where they are at the start, with room for some planes."""
        return self.at(0.0, 0.0)._replace(answers=self._answers(planes))

    def _answers(self, planes: int) -> Any:
        return np.zeros((planes, len(self.free), ANSWER)) if self.free else ()

    def _bound(self, row: NDArray, about: NDArray, field: DistanceField) -> None:
        """Set the least and the greatest vertex near a body."""
        far = field.low + field.spacing * (field.shape - 1)
        ends = zip(field.low, far, strict=True)
        corners = np.array(list(product(*ends))) - row[REFERENCE : REFERENCE + 3]
        for d, (origin, inverse) in enumerate(
            zip(self.frame.origin, self.frame.inverse, strict=True)
        ):
            # Not by a product of matrices, which machines may round otherwise.
            a, b, c = (corners[:, k] * row[TURN + 3 * d + k] for k in range(3))
            placed = a + b + c + row[CENTRE + d]
            low, high = placed.min(), placed.max()
            least, most = 0, self.frame.vertices[d] - 1
            about[LEAST + d] = np.clip(
                np.floor((low - origin) * inverse) + self.frame.ghost - 1, least, most
            )
            about[MOST + d] = np.clip(
                np.ceil((high - origin) * inverse) + self.frame.ghost + 1, least, most
            )
