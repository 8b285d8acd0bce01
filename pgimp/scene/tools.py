"""The rigid bodies of a scene: their distances, and where they are in each step."""

from __future__ import annotations

from functools import cached_property, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.places import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.distancefield import MARGIN, DistanceField, distance_field, extent, thickness
from pgimp.geometry.outline import outline
from pgimp.kernels.particles import Frame, Particles
from pgimp.kernels.tools import (
    ABOUT,
    AT,
    CENTRE,
    FIRST,
    FORMER,
    LATTER,
    LEAST,
    LOW,
    MOST,
    MOTION,
    REFERENCE,
    SHAPE,
    SPACING,
    TURN,
    Tools,
    distances,
)
from pgimp.mpi.collective import on_root
from pgimp.physics.rigid import RigidBody

#: Instants at which the way of a body that does not turn is looked at, to know what of it matters.
_INSTANTS = 2000

#: Points that a lattice may have: about 1 GB.
_MOST_POINTS = 30_000_000


class Surface(NamedTuple):
    """Surfaces of rigid bodies: vertices, cells of them, and the body of each vertex."""

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    body: NDArray[np.int64]


class SceneTools:
    """The rigid bodies that move as prescribed.

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
    """

    def __init__(self, case: Case, frame: Frame) -> None:
        self.case, self.frame = case, frame
        self.names, self.entries = list(case.tools), list(case.tools.values())
        self.fields: list[DistanceField] = []
        self._kept: Any = None

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.entries)

    def points(self) -> int:
        """Return the number of points of all lattices."""
        return sum(
            int(np.prod(extent(entry.region, self.frame.cell, self._within(entry))[2]))
            for entry in self.entries
            if not any(part.FROM_FILE for part in entry.region.simple())
        )

    def measure(self, comm: Any) -> None:
        """Find the distances, on rank 0, and let all ranks have them; collective.

        Raises
        ------
        CaseError
            On every rank: a body that is too thin, or too large.
        """
        with located(self.case):
            self.fields = [
                on_root(comm, partial(self._read_and_measure, name, entry))
                for name, entry in zip(self.names, self.entries, strict=True)
            ]
        self._kept = None

    def _read_and_measure(self, name: str, entry: RigidBody) -> DistanceField:
        """Measure a body, of which meshes are in memory no longer than that."""
        try:
            return self._measure(entry)
        except CaseError as error:
            raise CaseError(f"bodies.{name}.region: {error}") from None
        finally:
            for part in entry.region.simple():
                part.__dict__.pop("surface", None)

    def _measure(self, entry: RigidBody) -> DistanceField:
        cell, within = self.frame.cell, self._within(entry)
        points = int(np.prod(extent(entry.region, cell, within)[2]))
        if points > _MOST_POINTS:
            raise CaseError(
                f"is too large for these cells: it would take {points:,} distances half a cell "
                f"apart, where {_MOST_POINTS:,} are possible; leave out what meets nothing"
            )
        field = distance_field(entry.region, cell, within)
        thick = thickness(entry.region, field, len(cell))
        if thick < (1.0 - 1e-6) * min(cell):
            raise CaseError(
                f"is {thick:.2g} thick at most, and cells are "
                f"{min(cell):.6g} wide: what meets it would feel both of its sides at once; make "
                "it thicker, on a side that meets nothing, or the cells smaller"
            )
        return field

    def _within(self, entry: RigidBody) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Ends of the part of a body, where it is at the start, that comes into the domain."""
        if entry.rigid.rotation is not None:
            return None
        D, grid = len(self.frame.cell), self.case.grid
        times = np.linspace(0.0, self.case.time.end, _INSTANTS if entry.rigid.moves else 1)
        ways = np.array([entry.rigid.displacement(float(t))[:D] for t in times])
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

    def surface_at(self, time: float) -> NDArray[np.float64]:
        """Return the vertices of `surface` at a time, (n, 3)."""
        points = self.surface.points.copy()
        for number, entry in enumerate(self.entries):
            mine = self.surface.body == number
            centre, turn = entry.rigid.pose(time)
            own = points[mine] - np.array(entry.rigid.reference)
            points[mine] = own @ np.array(turn).reshape(3, 3).T + np.array(centre)
        return points

    def at(self, start: float, end: float) -> Tools:
        """Return them for the kernels of a step from `start` to `end`."""
        tools = self._arrays()
        for row, about, entry, field in zip(
            tools.motion, tools.about, self.entries, self.fields, strict=True
        ):
            centre, turn = entry.rigid.pose(start)
            row[CENTRE : CENTRE + 3], row[TURN : TURN + 9] = centre, turn
            for column, time in ((FORMER, start), (LATTER, end)):
                row[column : column + 6] = np.concatenate(entry.rigid.velocities(time))
            self._bound(row, about, field)
        return tools

    def require_apart(self, particles: Particles, rows: NDArray[np.int32], comm: Any) -> None:
        """Refuse bodies whose particles lie in rigid bodies at the start; collective.

        Those that a surface cuts may have their centre beyond it by half their size.

        Raises
        ------
        CaseError
            On every rank.
        """
        size = np.array(self.frame.cell) / np.array(self.case.method.particles_per_cell)
        tools, found = self.at(0.0, 0.0), []
        x = particles.x[rows]
        distance = np.empty(len(x))
        for t, name in enumerate(self.names):
            distances(tools, t, self.frame, x, distance)
            if len(x) and distance.min() < -0.5 * float(np.sqrt(np.square(size).sum())):
                deepest = int(distance.argmin())
                body = int(particles.body[rows[deepest]])
                found.append((float(distance[deepest]), tuple(x[deepest].tolist()), body, name))
        every = [one for some in comm.allgather(found) for one in some]
        if not every:
            return
        deep, place, body, name = min(every)
        with located(self.case):
            raise CaseError(
                f"bodies.{name}.region: '{list(self.case.bodies)[body]}' reaches {-deep:.3g} into "
                f"the rigid '{name}' at ({', '.join(f'{c:.6g}' for c in place)}); bodies must not "
                "overlap at the start: move or cut one of them"
            )

    def _arrays(self) -> Tools:
        """Return what does not change, and room for what does."""
        if self._kept is None:
            count = len(self.entries)
            motion, about = np.zeros((count, MOTION)), np.zeros((count, ABOUT), np.int64)
            first = 0
            for row, one, entry, field in zip(
                motion, about, self.entries, self.fields, strict=True
            ):
                row[REFERENCE : REFERENCE + 3] = entry.rigid.reference
                row[SPACING], row[LOW : LOW + 3] = field.spacing, field.low
                one[SHAPE : SHAPE + 3], one[FIRST] = field.shape, first
                first += len(field.values)
            values = [field.values for field in self.fields]
            self._kept = Tools(
                motion, about, np.concatenate(values) if values else np.zeros((0, 4)),
                len(self.case.bodies), np.zeros(AT),
            )  # fmt: skip
        return self._kept

    def _bound(self, row: NDArray, about: NDArray, field: DistanceField) -> None:
        """Set the least and the greatest vertex near a body."""
        far = field.low + field.spacing * (field.shape - 1)
        ends = zip(field.low, far, strict=True)
        corners = np.array(list(product(*ends))) - row[REFERENCE : REFERENCE + 3]
        placed = corners @ row[TURN : TURN + 9].reshape(3, 3).T + row[CENTRE : CENTRE + 3]
        for d, (origin, inverse) in enumerate(
            zip(self.frame.origin, self.frame.inverse, strict=True)
        ):
            low, high = placed[:, d].min(), placed[:, d].max()
            least, most = 0, self.frame.vertices[d] - 1
            about[LEAST + d] = np.clip(
                np.floor((low - origin) * inverse) + self.frame.ghost - 1, least, most
            )
            about[MOST + d] = np.clip(
                np.ceil((high - origin) * inverse) + self.frame.ghost + 1, least, most
            )
