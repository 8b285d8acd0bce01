"""Particles near contact at their current positions, with data of their reference vertices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.cut_supports import narrow_supports
from pgimp.kernels.contact.lagrangian.pairs import SeparatingWalls
from pgimp.kernels.contact.lagrangian.reference_grid import (
    FACE_PLANE,
    REFERENCE_VERTEX,
    ReferenceVertices,
    Seen,
    copy_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.shared_vertices import Patches, find_shared
from pgimp.kernels.contact.lagrangian.supports import Supports, find_supports, local_vertices
from pgimp.kernels.contact.lagrangian.vertices import (
    NEAR_PARTICLE,
    VERTEX_SUMS,
    ContactVertices,
    copy_near_particles,
)
from pgimp.kernels.contact.volumes import BOXES
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.frame import InitialFrame
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.shares import FAR, divide, undivided


class Near(NamedTuple):
    """A rank's data for its share of the vertices.

    Attributes
    ----------
    table : (n,) NEAR_PARTICLE
        The particles with shared vertices there, in canonical order.
    patches : Patches
        The numbers of these vertices.
    contact_vertices : ContactVertices
        Room for the sums there.
    start : Supports
        The particles' initial supports.
    vertices : ReferenceVertices
        All their vertices, in the order of their keys.
    """

    table: np.ndarray
    patches: Patches
    contact_vertices: ContactVertices
    start: Supports
    vertices: ReferenceVertices


class NearParticles:
    """Copies of particles on the ranks that share out the vertices round their current positions.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.
    rigid_bodies : RigidBodies or ()
        The rigid bodies at their positions.
    walls : SeparatingWalls
        The unilateral walls.

    Attributes
    ----------
    groups, fields : (bodies,) int64
        Groups of bonded bodies, and their velocity fields on the reference grid.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, rigid_bodies: AnyRigidBodies, walls: SeparatingWalls
    ) -> None:
        self.scene, self.comm, self.call, self._initial = scene, comm, Bound(), Bound()
        self._frame = InitialFrame(*scene.domain.frame)
        self._rigid_bodies, self._walls = rigid_bodies, walls
        self.groups, self.fields = np.zeros((2, len(scene.body_names)), np.int64)
        self.mirrors = mirrors_of(scene)
        self.local = local_vertices(scene.settings.vertices, scene.dimension)
        self._seen = Seen(np.empty(0, np.int64), 0)
        self._plain, self._shares = plain(scene), undivided(comm.size)
        self._table, self._kept = np.empty(0, NEAR_PARTICLE), dict[str, Supports]()

    def gather(
        self, grid: Grid, particles: Particles, rows: np.ndarray, holding: Holding, anew: bool
    ) -> Near:
        """Gather the data for this rank's share of the vertices; collective.

        Parameters
        ----------
        grid : Grid
            After the update of momentum.
        particles, rows
            This rank's particles near contact, in canonical order.
        holding : Holding
            Faces and constraints.
        anew : bool
            Whether to divide the vertices anew.
        """
        scene, call, comm = self.scene, self.call, self.comm
        if len(self._table) < len(rows):
            self._table = np.empty(len(rows) + len(rows) // 8, NEAR_PARTICLE)
        table = self._table[: len(rows)]
        call(
            copy_near_particles,
            self._plain,
            particles,
            rows,
            self.groups,
            self.fields,
            scene.settings.lagrangian,
            table,
        )
        if comm.size == 1:
            table, patches, contact_vertices = self._shared(table)
            start = self.supports(table, False)
            vertices = self._take(grid, holding, table, start)
            return Near(table, patches, contact_vertices, start, vertices)
        if anew:
            most = np.array(scene.domain.frame.cells) + 2 * scene.domain.frame.ghost + 1
            self._shares = divide(comm, table["first_vertex"], scene.settings.vertices, most)
        parts = []
        for rank in range(comm.size):
            own = table[self._shares.reached(table["first_vertex"], scene.settings.vertices, rank)]
            supports = self.supports(own, False)
            parts.append((own, *self._take(grid, holding, own, supports)))
        tables, keys, values = zip(*comm.alltoall(parts), strict=True)
        vertices = in_order(ReferenceVertices(np.concatenate(keys), np.concatenate(values)))
        table, patches, contact_vertices = self._shared(np.concatenate(tables))
        return Near(table, patches, contact_vertices, self.supports(table, False), vertices)

    def _shared(self, table: np.ndarray) -> tuple[np.ndarray, Patches, ContactVertices]:
        """Particles on vertices of this rank that several groups share, and these vertices."""
        low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
        if len(table):
            first = table["first_vertex"]
            low, high = first.min(axis=0), first.max(axis=0)
        none = np.empty(0, np.int64)
        contact_vertices = ContactVertices(
            low, high - low + self.scene.settings.vertices, 1 + int(self.groups.max()), none,
            np.empty(0, VERTEX_SUMS), none,
        )  # fmt: skip
        within, boxes = self._shares.within(self.comm.rank), self._rigid_boxes()
        patches = self.call(find_shared, table, self.local, within, boxes, contact_vertices)
        sums = np.empty(len(patches.keys), VERTEX_SUMS)
        return table[patches.rows], patches, contact_vertices._replace(keys=patches.keys, sums=sums)

    def _rigid_boxes(self) -> np.ndarray:
        """Least and greatest numbers of vertices at rigid bodies and walls, (n, 2, 3) int64."""
        D, rigid_bodies = self.scene.dimension, self._rigid_bodies
        lattice = rigid_bodies.lattice if rigid_bodies else ()
        boxes = np.full((len(lattice) + len(self._walls.planes), 2, 3), [[[-FAR], [FAR]]])
        for n, row in enumerate(lattice):
            boxes[n, 0, :D], boxes[n, 1, :D] = row["least"][:D], row["most"][:D]
        for n, (axis, side, place, *_) in enumerate(self._walls.planes.tolist(), len(lattice)):
            boxes[n, int(side < 0), axis] = place
        return boxes

    def _take(
        self, grid: Grid, holding: Holding, table: np.ndarray, supports: Supports
    ) -> ReferenceVertices:
        """The reference vertices of the particles of a table."""
        last, step = self._seen
        if len(last) != len(grid.G) // 8:
            last, step = np.full(len(grid.G) // 8, -1, np.int64), 0
        self._seen = Seen(last, step + 1)
        most = supports.at.size
        mine = ReferenceVertices(np.empty(most, np.int64), np.empty(most, REFERENCE_VERTEX))
        found = self.call(
            copy_reference_vertices,
            holding,
            grid.field,
            table,
            supports,
            self.mirrors,
            self._seen,
            mine,
        )
        return in_order(ReferenceVertices(mine.keys[:found], mine.values[:found]))

    def supports(self, table: np.ndarray, current: bool) -> Supports:
        """Supports of the particles of a table, at their current or initial positions.

        They hold until the next ones of this kind.
        """
        supports, scene = self._storage(len(table), "current" if current else "start"), self.scene
        if current:
            self.call(
                find_supports, scene.settings.shape, scene.domain.frame, table, current, supports
            )
        else:
            self._initial(
                find_supports, scene.settings.shape, self._frame, table, current, supports
            )
        return supports

    def left(self, table: np.ndarray, now: Supports) -> tuple[Supports, float]:
        """Supports for the sums of volumes, and whether their gradient counts.

        `now` are the supports at the particles' current positions.
        """
        if not isinstance(self.scene.settings.shape, BOXES):
            return now, 1.0
        if not needed(table["cut"].any()):
            return now, 0.0
        left, scene = self._storage(len(table), "left"), self.scene
        self.call(narrow_supports, scene.settings.shape, scene.domain.frame, table, now, left)
        return left, 0.0

    def _storage(self, count: int, kind: str) -> Supports:
        """Storage for the supports of a kind."""
        kept = self._kept.get(kind)
        if kept is None or len(kept.at) < count:
            kept = self._kept[kind] = Supports.empty(count + count // 8, self.local)
        return kept._replace(
            first=kept.first[:count], w=kept.w[:count], g=kept.g[:count], at=kept.at[:count]
        )


def in_order(vertices: ReferenceVertices) -> ReferenceVertices:
    """The vertices in the order of their keys, each once."""
    keys, first = np.unique(vertices.keys, return_index=True)
    return ReferenceVertices(keys, vertices.values[first])


def plain(scene: Scene) -> KernelScene:
    """Kernel scene with current positions, without materials."""
    return scene.setting.without_materials()._replace(frame=scene.domain.frame)


def mirrors_of(scene: Scene) -> np.ndarray:
    """The mirrors, (n,) FACE_PLANE."""
    frame = scene.domain.frame
    rows = []
    for each in scene.domain.mirrors:
        vertex = frame.ghost + (each.side > 0) * frame.cells[each.axis]
        rows.append((each.axis, each.side, vertex, each.number, each.sticks))
    return np.array(rows, FACE_PLANE)
