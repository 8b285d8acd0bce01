"""Contact of bodies in the initial configuration by their own surfaces.

Of bodies that are exact to their surface, with each other, rigid bodies, unilateral walls, and with
themselves.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.impulses.books import book_held
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import (
    REFERENCE_VERTEX,
    Changes,
    ReferenceVertices,
    change_velocities,
)
from pgimp.kernels.contact.impulses.rows import Solved
from pgimp.kernels.contact.surfaces.data import Patches, Surface, SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.groups import book_groups
from pgimp.kernels.contact.surfaces.loads import add_loads
from pgimp.kernels.contact.surfaces.motion import read_vertices
from pgimp.kernels.contact.surfaces.patches.levels import TOUCHES
from pgimp.kernels.contact.surfaces.patches.rows import PARTS, find_patch_pairs
from pgimp.kernels.contact.surfaces.soft import LEAST_AREA, solve_softly
from pgimp.kernels.data.ledger import CONTACT_AREA, Ledger
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.impulses.impulse_contact import ImpulseContact, flat, nothing_held
from pgimp.solver.contact.impulses.joint import Joint
from pgimp.solver.contact.impulses.room import Room
from pgimp.solver.contact.surfaces.groups import (
    GroupBooks,
    Grouped,
    add_books,
    books_of,
    labels_of,
    share_changes,
)
from pgimp.solver.contact.surfaces.loads import SurfaceLoads
from pgimp.solver.contact.surfaces.overrun import Depth, OverrunWatch
from pgimp.solver.contact.surfaces.proximity import Proximity
from pgimp.solver.contact.surfaces.rebounds import rebounds_of
from pgimp.solver.contact.surfaces.seams import changes_of_images
from pgimp.solver.contact.surfaces.table import Table, bits_of, table_of
from pgimp.solver.contact.surfaces.wide import parted
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate

#: No changes.
_NONE = Changes(np.empty(0, np.int64), *np.empty((2, 0, 3)))

#: The most sweeps in a step, and the relative change of impulses that ends them, without rigid
#: bodies that move freely: these meet each other without the compliance of patches.
SOFT_ACCURACY = 200, 1e-5


class SurfaceContact(ImpulseContact):
    """Contact by surfaces: patches of one body, and the nearest facets of another.

    Each connected group of bodies has a rank that finds its gaps, and solves for its impulses, from
    the vertices of all ranks near contact. What it finds depends on the group alone.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self._proximity = Proximity(scene, comm, self._walls)
        self._table: Table | None = None
        self._slaves: object = None
        self._acts = np.zeros((0, 0), np.uint8)
        self._rate, self._deepest = 0.0, -1
        if not self.free:
            self._accuracy = SOFT_ACCURACY
        cell = scene.domain.frame.cell
        lengths = PARTS * min(cell), TOUCHES * min(cell)
        self._sizes = LEAST_AREA * min(cell) ** (len(cell) - 1), *lengths
        #: SurfaceLoads or None: Loads on facets, where the case asks for frames of surfaces.
        self.loads = SurfaceLoads(comm) if scene.case.output.surface else None
        self._every = no_facets(0)
        self._moved: Any = None  # cells, and displacements of the surface vertices
        self._read: Any = (None,)  # room for what the share's vertices have
        rigid_bodies = scene.interaction.rigid_bodies
        names = [*scene.body_names, *rigid_bodies.names]
        self._watch, self._depth = OverrunWatch(scene, names), Depth(scene, names)
        self._books: tuple[np.ndarray, GroupBooks] | None = None
        self._ascending: Any = (None, False)
        self._planes: GroupBooks | None = None  # as long as there are as many groups
        self._by_group: Grouped | None = None
        self._rebounds = rebounds_of(scene)
        first = self._walls.first
        for number in scene.interaction.rigid_bodies.free:  # they meet walls as other bodies do
            self.pairs.entry[self.bodies + number, first:] = self.pairs.entry[0, first:]

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

    @property
    def surface_loads(self) -> np.ndarray:
        """See `NoContact.surface_loads`."""
        return self.loads.stored if self.loads else super().surface_loads

    def restore_loads(self, loads: np.ndarray) -> None:
        """See `NoContact.restore_loads`."""
        if self.loads:
            self.loads.restore(loads)

    def conclude(self, rank: RankState) -> None:
        """See `NoContact.conclude`; loads of a checkpoint are of this stage's surfaces."""
        if self.loads:
            surface = self.known(rank).surface
            self.loads.know(surface, self._proximity.labels)

    def follow(self, before: NoContact) -> None:
        """See `NoContact.follow`."""
        if self.loads and isinstance(before, SurfaceContact) and before.loads:
            self.loads = before.loads

    @property
    def proximity(self) -> Proximity:
        """What is near."""
        return self._proximity

    @property
    def laws(self) -> Contact:
        """Laws and rigid bodies, for kernels."""
        return self._contact

    @property
    def acts(self) -> np.ndarray:
        """Whether facets of a body look for another's, (bodies, bodies) uint8."""
        return self._acts

    def overrun(self, rank: RankState, done: Step) -> list[str]:
        """See `NoContact.overrun`."""
        said = self._depth.look(self.comm)
        due, end = self._watch.due(done), float(self.scene.case.time.end)
        if self._table is None or not (due or said or done.end > end - 0.5 * done.dt):
            return said
        u = self._proximity.all_displacements(rank, self._table)
        if self.comm.rank > 0:
            return []
        return said + self._watch.look(self._table, self._acts, u, self.rigid_bodies, done)

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
        table, rate = self.known(rank), max(every.rate, free.rate if free else 0.0)
        self._rate = rate
        if self._proximity.update(rank, table, self._acts, rigid_bodies, t.dt, rate):
            self._warm_start.divide(self._proximity.has)
            if self.loads:
                proximity, met = self._proximity, self._meeting
                of = table.surface, proximity.labels, proximity.groups
                self.loads.divide(*of, met, proximity.root)
        if self.loads:
            self.loads.time += t.dt
        self._meet(rank, update, table)
        if free:
            free.end(rigid_bodies, t.dt)

    def known(self, rank: RankState) -> Table:
        """The surfaces of all bodies; collective when they have to be found."""
        slaves = rank.slaves.keys if rank.slaves else None
        if self._table is None or self._slaves is not slaves:
            self._table, self._slaves = table_of(rank, self.fields), slaves
            self._acts = self._looking()
            self._proximity.restart()
            self._proximity.labels = labels_of(self.scene, self.groups, len(self._walls.planes))
        return self._table

    @property
    def _meeting(self) -> np.ndarray:
        """Pairs of bodies that may exchange loads until the next search, (n, 2) int64."""
        return self._proximity.met

    def material_gaps(self, rank: RankState, rigid: Any) -> tuple[np.ndarray, np.ndarray]:
        """Facets, and their gaps to material in the current configuration, on all ranks.

        Collective. `rigid` are the rigid bodies where they are now.
        """
        return np.empty(0, np.int64), np.empty(0)

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

    def _meet(self, rank: RankState, update: VertexUpdate, table: Table) -> None:
        """Find the pairs, and exchange impulses; collective."""
        near = self._proximity.facets
        assert near is not None
        if needed(len(near)):
            self._act(rank, update, self._joint(rank, update, table))
        else:
            self._warm_start.clear()

    def _holding(self, update: VertexUpdate) -> Holding:
        """Faces and constraints, for kernels."""
        scratch, forcing = self._contact.scratch_impulse, update.forcing
        frame = self.scene.domain.frame
        return Holding(update.faces, frame, forcing, scratch, forcing.loads.relaxation)

    def _joint(self, rank: RankState, update: VertexUpdate, table: Table) -> Joint:
        """The pairs of surfaces in the rank's groups; collective."""
        call, grid, share, proximity = self.call, rank.grid, self._proximity.share, self._proximity
        surface, cells, every = table.every, share.cells, proximity.candidates
        if self._read[0] is not share:
            count = len(share.records)
            self._read = share, np.empty(count, REFERENCE_VERTEX), np.empty((count, 4))
        _, values, u = self._read
        call(read_vertices, self._holding(update), grid.field, share.sent, share.records, values, u)
        u, values = share.gather(self.comm, u, values)
        dt, self._moved = update.t.dt, (cells, u)
        patches = proximity.awake(self._contact, table, u, flat(values), dt)
        step = dt, self._warm_start.kept
        vertices = ReferenceVertices(share.keys, values)
        joint = self._pairs(surface, cells, (every, patches), vertices, step, self._room)
        self._depth.note(every, self._deepest, surface, update.t.start)
        return joint

    def _act(self, rank: RankState, update: VertexUpdate, joint: Joint | None) -> None:
        """Solve for the impulses of the rank's pairs, and apply them; collective."""
        scene, call, grid, (_, _, forcing, ledger) = self.scene, self.call, rank.grid, update
        frame, holding = scene.domain.frame, self._holding(update)
        self._books = None
        changes = _NONE
        if joint is not None and needed(len(joint.pairs.ends)):
            changes = self._solve(joint, nothing_held(holding), ledger)
        else:
            self._warm_start.clear()
        add_books(self.comm, self._proximity.root, self._books, ledger)
        answers = self.rigid_bodies.responses["trial_impulse"] if self.free else np.empty(0)
        keys = joint.vertices.keys if joint is not None else changes.keys
        if self._ascending[0] is not keys:  # the same until the next search
            self._ascending = keys, bool((keys[1:] > keys[:-1]).all())
        changes = share_changes(self.comm, changes, answers, self._ascending[1])
        if not needed(len(changes.keys)):
            return
        if scene.domain.periodic[0]:
            bits = bits_of(frame, 1 + max(self.fields, default=0))
            changes = changes_of_images(changes, frame, bits)
        self.changes = changes
        call(change_velocities, frame, grid.field, changes, forcing, ledger.work)
        call(book_held, holding, grid.field, changes, ledger)

    def _sweep(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved
    ) -> None:
        """See `ImpulseContact._sweep`; rigid bodies rebound."""
        self._by_group = grouped = Grouped.of(pairs, self._proximity.groups)
        if not self._rebounds:
            self._sweep_groups(free, pairs, coupling, solved)
            return
        sweep = partial(self._sweep_groups, free, pairs, coupling, solved)
        states = solved.velocity, solved.held_impulse
        self._rebounds.solve(self.rigid_bodies, pairs, grouped, states, sweep)

    def _sweep_groups(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved
    ) -> None:
        """Solve for the impulses; the sweeps of each group end by themselves.

        Neighbouring patches have some compliance in them.
        """
        assert self._by_group is not None
        order, first, *_ = self._by_group
        room = self._room.soft(len(solved.velocity), len(pairs.ends), coupling)
        self.sweeps = self.call(
            solve_softly, self._contact, free, self._warm_start.kept, (pairs, order, first),
            coupling, solved, room, ((self._dt, *self._sizes), self._accuracy),
        )  # fmt: skip

    def _book(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved,
        vertices: np.ndarray, ledger: Ledger,
    ) -> None:  # fmt: skip
        """See `ImpulseContact._book`; of each group alone."""
        grouped = self._by_group
        assert grouped is not None
        count = len(grouped.number)
        books = self._planes
        if books and books.ledger is ledger and count == len(books.planes.work):
            books.whole.fill(0.0)
        else:
            books = self._planes = books_of(ledger, count)
        self._books = grouped.number, books
        own = grouped.chosen(pairs), grouped.first
        of = self._contact, free, own, coupling, solved, vertices
        self.call(book_groups, *of, self._walls, books.planes)
        if self.loads:
            assert self._table is not None
            self._add_loads(pairs, coupling, solved, self._table.surface, self._parted())

    def _parted(self) -> np.ndarray:
        """The candidates of the step, with the parts of wide facets in their place."""
        table, proximity, every = self._table, self._proximity, self._every
        assert table is not None
        if not needed((every["facet"] >= len(table.wide)).any()):
            return every
        found, row = parted(table, every)
        of = self.scene.domain.frame, self._contact, self._walls, table.surface, self._moved
        near = found, Patches.of(table.surface, found, -1.0)
        self.call(find_gaps, *of, proximity.scratch, proximity.far, near)
        for name in ("gap", "side", "facing", "normal"):
            found[name] = every[name][row]
        return found

    def _add_loads(
        self, pairs: ContactPairs, coupling: Coupling, solved: Solved, surface: Surface,
        every: np.ndarray,
    ) -> None:  # fmt: skip
        """Add what pairs of patches have exchanged to the loads of facets."""
        assert self.loads
        of = self._contact, pairs, coupling, solved, self.scene.domain.frame
        self.call(add_loads, *of, surface, every, (self._dt, *self.loads.arrays))

    def _pairs(
        self, surface: Surface, cells: SurfaceCells, near: tuple[np.ndarray, Patches],
        reference: ReferenceVertices, step: tuple[float, np.ndarray], room: Room,
    ) -> Joint:  # fmt: skip
        """The pairs of patches and other bodies, with their rows of B, in `room`.

        `near` are facets near others, and their patches; `step` has its length, and kept forces.
        """
        call, frame, (keys, values) = self.call, self.scene.domain.frame, reference
        (every, _), used = near, 0
        gathering = room.gathering(len(keys), len(every), len(frame.cell))
        scratch = flat(values), *gathering, *self._proximity.scratch[-2:]
        self._every = every
        while True:
            found, rows, used, self._deepest = call(
                find_patch_pairs, self._contact, frame, surface, cells, near, step, scratch,
                room.found(len(every), used),
            )  # fmt: skip
            if used <= room.entries:
                break
        return Joint(*room.filled(found, rows, used), reference)
