"""Contact of bodies in the initial configuration by their own surfaces.

Of bodies that are exact to their surface, with each other, rigid bodies, unilateral walls, and with
themselves.
"""

from __future__ import annotations

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.books import book_held
from pgimp.kernels.contact.lagrangian.coupling import Coupling
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs
from pgimp.kernels.contact.lagrangian.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    change_velocities,
    read_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.rows import Solved, begin_solution
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.rows import find_patch_pairs
from pgimp.kernels.contact.surfaces.soft import LEAST_AREA, PARTS, apply_impulses, soften
from pgimp.kernels.data.ledger import CONTACT_AREA
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.joint import Joint, share
from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact, nothing_held
from pgimp.solver.contact.lagrangian.selected import flat
from pgimp.solver.contact.surfaces.proximity import Near, Proximity
from pgimp.solver.contact.surfaces.table import Table, table_of
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import VertexUpdate

#: The most sweeps over all pairs in a step, and the relative change of impulses that ends them. To
#: 1e-3 disks rebound the same to four digits, but what rests with friction slowly gains energy.
SWEEPS, TOLERANCE = 200, 1e-5


class SurfaceContact(LagrangianContact):
    """Contact by surfaces: patches of one body, and the nearest facets of another.

    The rank with the first layer finds the gaps, and solves for the impulses, from the vertices of
    all ranks near contact. So nothing depends on the ranks.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self._proximity = Proximity(scene, comm, self._walls)
        self._table: Table | None = None
        self._slaves: object = None
        self._acts = np.zeros((0, 0), np.uint8)
        self._rate, self._room = 0.0, (ContactPairs.empty(0), _rows(0, 0))
        cell = scene.domain.frame.cell
        self._sizes = LEAST_AREA * min(cell) ** (len(cell) - 1), PARTS * min(cell)
        if not self.free:
            self._accuracy = SWEEPS, TOLERANCE

    def moved(self) -> None:
        """See `NoContact.moved`."""
        self._proximity.relocate()

    @property
    def search(self) -> np.ndarray:
        """See `NoContact.search`."""
        return self._proximity.state

    def restore_search(self, search: np.ndarray) -> None:
        """See `NoContact.restore_search`."""
        self._proximity.restore(search)

    def exchange(self, rank: RankState, update: VertexUpdate) -> None:
        """See `NoContact.exchange`."""
        rigid_bodies, free = self.rigid_bodies, self.free
        t, _, forcing, ledger = update
        every, self._dt, self.changes = self.scene.interaction.rigid_bodies, t.dt, None
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        if every:
            every.at(t.start, t.end, free.states if free else None)  # in place
        if free:
            free.begin(rigid_bodies, t, forcing.gravity)
        table, rate = self._known(rank), max(every.rate, free.rate if free else 0.0)
        self._rate = rate
        self._proximity.update(rank, table, self._acts, rigid_bodies, t.dt, rate)
        near = self._proximity.near
        assert near is not None
        if needed(near.any):
            self._act(rank, update, table, near)
        else:
            self._warm_start.clear()
        if free:
            free.end(rigid_bodies, t.dt)

    def _known(self, rank: RankState) -> Table:
        """The surfaces of all bodies; collective when they have to be found."""
        slaves = rank.slaves.keys if rank.slaves else None
        if self._table is None or self._slaves is not slaves:
            self._table, self._slaves = table_of(rank, self.fields), slaves
            self._acts = self._looking()
            self._proximity.restart()
        return self._table

    def _looking(self) -> np.ndarray:
        """Whether facets of a body look for another's: of bodies that act, those of the first."""
        count, groups = self._walls.first, self.groups
        acts = np.triu(self.pairs.entry[:count, :count]) != 0
        acts[self.bodies :] = False
        for pair in self.scene.interaction.rigid_bodies.meeting:
            acts[self.bodies + min(pair), self.bodies + max(pair)] = True
        soft = slice(self.bodies)
        acts[soft, soft] &= (groups[:, None] != groups) | np.eye(len(groups), dtype=bool)
        return acts.astype(np.uint8)

    def _act(self, rank: RankState, update: VertexUpdate, table: Table, near: Near) -> None:
        """Find the gaps, solve for the impulses, and apply them; collective."""
        scene, contact, call, grid = self.scene, self._contact, self.call, rank.grid
        t, faces, forcing, ledger = update
        frame, root = scene.domain.frame, self._proximity.root
        holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
        values = np.empty(len(near.own), REFERENCE_VERTEX)
        call(read_reference_vertices, holding, grid.field, near.keys[near.own], values)
        u, every = self._proximity.displacements(rank, near), self._proximity.on_root(near, values)
        joint: Joint | None = None
        found = np.zeros(1, np.int64)
        if u is not None and every is not None:
            joint = self._pairs(table, near, u, every, t.dt)
            found[0] = len(joint.pairs.ends)
        if self.comm.size > 1:
            self.comm.Bcast(found, root)
        if not needed(found[0]):
            self._warm_start.clear()
            return
        self._warm_start.move_to(root)
        changes = None
        if joint is not None:
            changes = self._solve(joint, nothing_held(holding), ledger)
        else:
            self._warm_start.clear()
        if self.comm.size > 1:
            answers = self.rigid_bodies.responses["trial_impulse"] if self.free else np.empty(0)
            changes = share(self.comm, root, changes, answers)
        assert changes is not None
        self.changes = changes
        call(change_velocities, frame, grid.field, changes, forcing, ledger.work)
        call(book_held, holding, grid.field, changes, ledger)

    def _sweep(self, joint: Joint, free: Holding, solved: Solved) -> None:
        """See `LagrangianContact._sweep`; here with some compliance between neighbours."""
        contact, call, (pairs, coupling, vertices) = self._contact, self.call, joint
        soft, kept = coupling._replace(answer=coupling.answer.copy()), self._warm_start.kept
        softened = solved._replace(soft=np.zeros_like(soft.answer))
        scratch, sizes = (np.zeros(len(vertices.keys)), np.zeros(len(pairs.ends))), self._sizes
        call(soften, contact, kept, pairs, soft, softened, (self._dt, *sizes), scratch)
        super()._sweep(joint._replace(coupling=soft), free, softened)
        call(begin_solution, free.frame, flat(vertices.values), coupling, solved)
        call(apply_impulses, pairs, coupling, solved)

    def _pairs(
        self, table: Table, near: Near, u: np.ndarray, values: np.ndarray, dt: float
    ) -> Joint:
        """The pairs of patches and other bodies, with their rows of B."""
        call, frame, surface = self.call, self.scene.domain.frame, table.surface
        proximity, rigid, cells = self._proximity, self.rigid_bodies, near.cells
        every, scratch, least = proximity.candidates, proximity.scratch, min(frame.cell)
        fastest = float(np.abs(values["velocity"]).max(initial=0.0)) + self._rate * least
        call(move_facets, frame, rigid, surface, cells, u, proximity.moving, scratch)
        far = proximity.far, bool(proximity.walks(fastest * dt / least))
        call(find_gaps, frame, rigid, self._walls, surface, (cells, u), scratch, far, every)
        seen, counts = np.empty((2, len(near.keys)), np.int64), [0, 0]
        vertices = flat(values), seen, np.empty(2 ** len(frame.cell))
        if len(self._room[0].ends) < len(every):
            self._room = ContactPairs.empty(len(every)), _rows(len(every), 8 * len(every))

        def fill(coupling: Coupling) -> int:
            counts[0], counts[1], used = call(
                find_patch_pairs, self._contact, frame, surface, cells, every, (dt, fastest),
                vertices, (self._room[0], coupling),
            )  # fmt: skip
            return int(used)

        pairs, coupling = self._room
        used = fill(coupling)
        if used > len(coupling.column):
            coupling = _rows(len(every), used + used // 4)
            self._room = pairs, coupling
            fill(coupling)
        found, rows = counts
        coupling = Coupling(
            coupling.start[: rows + 1], coupling.column[:used], coupling.entry[:used],
            coupling.answer[:rows], coupling.beyond[:rows],
        )  # fmt: skip
        return Joint(pairs.chosen(slice(found)), coupling, ReferenceVertices(near.keys, values))


def _rows(pairs: int, entries: int) -> Coupling:
    """Room for the rows of so many pairs, with so many entries."""
    return Coupling(
        np.zeros(2 * pairs + 1, np.int64), np.empty(entries, np.int64), np.empty((entries, 1)),
        np.empty((2 * pairs, 3)), np.zeros((2 * pairs, 0, 3)),
    )  # fmt: skip
