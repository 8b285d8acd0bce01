"""Contact of bodies in the current configuration with each other and walls, beside surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import marked, needed
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs, SeparatingWalls
from pgimp.kernels.contact.impulses.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    read_reference_vertices,
)
from pgimp.kernels.contact.material.vertices import find_shared_vertices, find_vertex_pairs
from pgimp.kernels.contact.volumes import volume_sums
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.impulses.joint import Joint, join
from pgimp.solver.contact.multifield import near_vertices
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertex_sums import VertexSums


class ContactAtVertices:
    """Finds the pairs of bodies in the current configuration at the vertices of the grid.

    Parameters
    ----------
    pairs : Pairs
        The laws of these bodies alone.
    walls : SeparatingWalls
        The unilateral walls.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, pairs: Pairs, walls: SeparatingWalls
    ) -> None:
        self.scene, self.comm, self.call = scene, comm, Bound()
        self._pairs, self._walls = pairs, walls
        self.acts = bool(pairs.entry.any())
        self._volumes = VertexSums(scene, comm, volume_sums(scene.settings.uncut))
        self._every_face = scene.domain.standing_faces()
        self._first = 0
        self.data: Any = ()  #: Contact or (): Laws, and volumes at vertices.

    def detect(self, rank: RankState, fields: tuple[int, ...]) -> None:
        """Sum volumes at the vertices that may have pairs; collective.

        `fields` are the velocity fields of all bodies, those of these bodies last.
        """
        if not self.acts:
            return
        grid = rank.grid
        if self._volumes.fit(grid, fields):
            self._connect(grid, fields)
        self.call(find_shared_vertices, self.data, grid.field, self._walls, self._first)
        found = marked(self.data.vertex_counts)
        if len(found):
            order = groups_of(rank)[0].order
            rows = np.empty(len(order.rows), np.int32)
            near = near_vertices(self.call, grid, rank.population, order, self.data, rows)
            self._volumes.add(rank.up_to_date(), near, found)

    def _connect(self, grid: Grid, fields: tuple[int, ...]) -> None:
        """Connect the data of kernels to the grid of volumes."""
        sums, current = self._volumes.grid, ~self.scene.settings.lagrangian
        self._first = int(np.array(fields)[current].min())
        faces = len(self.scene.domain.faces)
        data = Contact.empty(self._pairs, sums.G, grid.planes, 2 + max(fields), faces)
        self.data = data._replace(used=np.asarray(sums.field.used))

    def find(self, rank: RankState, root: int, holding: Holding, dt: float) -> Joint | None:
        """The pairs of all ranks, on the root; None on others and without any; collective."""
        if not self.acts:
            return None
        frame, field, call = self.scene.domain.frame, rank.grid.field, self.call
        (pairs, keys), found = (ContactPairs.empty(0), np.empty((0, 2), np.int64)), 0
        if needed(self.data.vertex_counts.any()):
            count = 4 * int(self.data.vertex_counts.sum()) + 16
            (pairs, keys), found = grown(
                count,
                lambda room: (ContactPairs.empty(room), np.empty((room, 2), np.int64)),
                lambda room: call(
                    find_vertex_pairs, self.data, frame, self._every_face, field, self._walls,
                    self._first, dt, room,
                ),
            )  # fmt: skip
        pairs, keys = pairs.chosen(slice(found)), keys[:found]
        own, column = np.unique(keys[keys >= 0], return_inverse=True)
        number = np.cumsum(keys >= 0) - 1
        rows = pairs.ends["rows"]
        rows[keys >= 0] = number[(keys >= 0).reshape(-1)]
        values = np.empty(len(own), REFERENCE_VERTEX)
        call(read_reference_vertices, holding, field, own, values)
        coupling = Coupling(
            np.arange(len(column) + 1), column.reshape(-1), np.ones((len(column), 1)),
            np.ascontiguousarray(values["inverse_mass"][column.reshape(-1)]),
        )  # fmt: skip
        joint: Joint | None = Joint(pairs, coupling, ReferenceVertices(own, values))
        if self.comm.size > 1 and joint is not None:
            found, joint = join(self.comm, root, joint)
        return joint if needed(found) else None
