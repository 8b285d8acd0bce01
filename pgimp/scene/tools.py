"""The rigid bodies of a scene: their distances, and where they are in each step."""

from __future__ import annotations

from functools import cached_property, partial
from hashlib import sha256
from itertools import product
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
)
from pgimp.mpi.collective import on_root
from pgimp.physics.rigid import RigidBody
from pgimp.schema.tables import VectorTable

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
    rate : float
        Cells that a point of any of the bodies crosses in a unit of time, at most; likewise.
    """

    def __init__(self, case: Case, frame: Frame) -> None:
        self.case, self.frame = case, frame
        self.names, self.entries = list(case.tools), list(case.tools.values())
        self.fields: list[DistanceField] = []
        self.rate = 0.0
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
            On every rank: a body that is too thin, or too large.
        """
        with located(self.case):
            self.fields = [
                on_root(comm, partial(self._read_and_measure, name, entry))
                for name, entry in zip(self.names, self.entries, strict=True)
            ]
        # Steps depend on it: one rank computes it, as machines may round otherwise.
        self.rate = on_root(comm, self._greatest_rate)
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
        if entry.rigid.rotation is not None:
            return None
        D, grid = len(self.frame.cell), self.case.grid
        end, velocity = self.case.time.end, entry.rigid.velocity
        times = np.linspace(0.0, end, _INSTANTS if entry.rigid.moves else 1)
        if isinstance(velocity, VectorTable):
            rows = np.array([time for time, _ in velocity.table])
            times = np.concatenate([times, rows[(rows > 0.0) & (rows < end)]])
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

    def _greatest_rate(self) -> float:
        """See `rate`."""
        fastest = 0.0
        for number, entry in enumerate(self.entries):
            arm = self.surface.points[self.surface.body == number] - entry.rigid.reference
            across = np.linalg.norm(np.cross(arm, entry.rigid.axis), axis=1).max(initial=0.0)
            speed, spin = entry.rigid.greatest()
            fastest = max(fastest, speed + spin * float(across))
        return fastest * max(self.frame.inverse)

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
            for row, one, entry, field in zip(
                motion, about, self.entries, self.fields, strict=True
            ):
                row[REFERENCE : REFERENCE + 3] = entry.rigid.reference
                row[SPACING], row[LOW : LOW + 3] = field.spacing, field.low
                one[SHAPE : SHAPE + 3], one[FIRST] = field.shape, first
                first += len(field.values)
            values = [field.values for field in self.fields]
            self._kept = Tools(
                motion, about, np.concatenate(values) if values else np.zeros((0, 5)),
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
