"""Contact by surfaces in scenes that also have bodies in the current configuration.

These meet surfaces by what they fill before facets. Among themselves, and at unilateral walls, they
meet at the vertices of the domain's grid. One solution has the impulses of all.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.rows import Solved
from pgimp.kernels.contact.surfaces.data import Patches
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.scene import Scene
from pgimp.solver.contact.impulses.impulse_contact import ACCURACY, ImpulseContact
from pgimp.solver.contact.impulses.joint import Joint
from pgimp.solver.contact.impulses.room import Room
from pgimp.solver.contact.material.at_vertices import ContactAtVertices
from pgimp.solver.contact.material.merged import Merger
from pgimp.solver.contact.material.near import NearMaterial
from pgimp.solver.contact.surfaces.contact import SurfaceContact
from pgimp.solver.contact.surfaces.table import Table
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate


class MixedContact(SurfaceContact):
    """Contact by surfaces, of bodies in the current configuration at vertices as well."""

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self._accuracy = ACCURACY  # patches have no compliance
        self._current = np.flatnonzero(~scene.settings.lagrangian)
        own = self._among(self.pairs)
        self._at_vertices = ContactAtVertices(scene, comm, own, self._walls)
        self._material: NearMaterial | None = None
        self._beside, self._merger = Room(), Merger()
        #: Of the step's patches, with surfaces and with material; whose facets these are.
        self._found: list[np.ndarray] = []
        self._has_facets = np.ones(self._walls.first + len(self._walls.planes), bool)
        self._has_facets[self._current] = self._has_facets[self._walls.first :] = False
        self._proximity.alone = True  # bodies in the current configuration may join all groups

    def moved(self) -> None:
        """See `NoContact.moved`."""
        super().moved()
        if self._material:
            self._material.relocate()

    def _among(self, pairs: Pairs) -> Pairs:
        """The pairs of bodies in the current configuration, with each other and with walls."""
        entry, mine = np.zeros_like(pairs.entry), np.zeros(len(pairs.entry), bool)
        mine[self._current] = mine[self._walls.first :] = True
        some = np.ix_(mine, mine)
        entry[some] = pairs.entry[some]
        return pairs._replace(entry=entry)

    @property
    def volumes(self) -> tuple[np.ndarray, ...]:
        """See `NoContact.volumes`."""
        data = self._at_vertices.data
        return (data.volumes, data.used) if data else ()

    def detect(self, rank: RankState, t: Step, ledger: Ledger) -> None:
        """See `NoContact.detect`."""
        self._at_vertices.detect(rank, self.fields)

    def known(self, rank: RankState) -> Table:
        """See `SurfaceContact.known`."""
        before = self._table
        table = super().known(rank)
        if table is not before:
            entry, first = self.pairs.entry, self._walls.first
            acts = (np.maximum(np.abs(entry), np.abs(entry.T)) != 0)[:first, : self.bodies]
            acts[:, self.scene.settings.lagrangian] = False
            acts[self._current] = False
            self._material = NearMaterial(
                self.scene, self.comm, self._walls, table, acts, self.groups, self.fields
            )
            soft, current = np.nonzero(acts)
            self._beyond = np.column_stack([soft, current])
        return table

    @property
    def _meeting(self) -> np.ndarray:
        """See `SurfaceContact._meeting`; facets may meet material at any time."""
        return np.concatenate([self._proximity.met, self._beyond])

    def material_gaps(self, rank: RankState, rigid: Any) -> tuple[np.ndarray, np.ndarray]:
        """See `SurfaceContact.material_gaps`."""
        assert self._material is not None
        self._material.locate(rank, self.known(rank))
        return self._material.gaps(rank, rigid)

    def _meet(self, rank: RankState, update: VertexUpdate, table: Table) -> None:
        """See `SurfaceContact._meet`."""
        near, material = self._proximity.facets, self._material
        assert near is not None and material is not None
        rigid, t = self.rigid_bodies, update.t
        found: list[Joint | None] = []
        self._found = []
        if needed(len(near)):
            found.append(self._joint(rank, update, table))
            self._found.append(self._every)
        material.look(rank, table, rigid, t.dt, self._rate)
        assert material.near is not None
        if needed(material.near.any):
            met = material.meet(rank, rigid, self._holding(update))
            if met is not None:
                step = t.dt, self._warm_start.kept
                way = max(met.speed, self._rate * min(self.scene.domain.frame.cell)) * t.dt
                of = met.every, Patches.of(met.surface, met.every, way)
                found.append(
                    self._pairs(met.surface, met.cells, of, met.vertices, step, self._beside)
                )
                self._found.append(self._every)
        found.append(
            self._at_vertices.find(rank, self._proximity.root, self._holding(update), t.dt)
        )
        own = [joint for joint in found if joint is not None]
        self._act(rank, update, self._merger.merged(own) if own else None)

    def _sweep_groups(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved
    ) -> None:
        """See `ImpulseContact._sweep`; of all groups, without compliance of patches."""
        states, parts = pairs.states, self._sizes[1] / self._dt
        most = np.maximum(parts, -pairs.ends["parted"])
        states["gap_rate"] = np.maximum(states["gap_rate"], -most)
        ImpulseContact._sweep(self, free, pairs, coupling, solved)

    def _book(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved,
        vertices: np.ndarray, ledger: Ledger,
    ) -> None:  # fmt: skip
        """See `ImpulseContact._book`; of all groups."""
        ImpulseContact._book(self, free, pairs, coupling, solved, vertices, ledger)
        if not self.loads or not self._found:
            return
        assert self._table is not None and self._material is not None
        mine, surface = self._has_facets[pairs.ends["bodies"]].any(axis=1), self._table.surface
        every = np.concatenate(self._found)
        every = every[np.lexsort((every["body"], surface.patch[every["facet"]]))]
        now, moving = self._material.surface.now.copy(), self._proximity.share.moving
        now[moving] = surface.now[moving]
        self._add_loads(pairs.chosen(mine), coupling, solved, surface._replace(now=now), every)
