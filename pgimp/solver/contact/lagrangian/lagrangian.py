"""Contact of bodies in the initial configuration: each other, rigid bodies, unilateral walls.

In cases with both configurations all bodies use this contact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.lagrangian.books import book_contacts, book_held, book_mirrored
from pgimp.kernels.contact.lagrangian.broad_phase import grow_boxes
from pgimp.kernels.contact.lagrangian.coupling import Coupling, find_coupling, number_rows
from pgimp.kernels.contact.lagrangian.gauss_seidel import IMPULSES, solve_impulses
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs, find_contact_pairs
from pgimp.kernels.contact.lagrangian.reference_grid import (
    Changes,
    ReferenceVertices,
    change_velocities,
)
from pgimp.kernels.contact.lagrangian.reference_numbers import WIDE
from pgimp.kernels.contact.lagrangian.rows import Solved, begin_solution, find_changes
from pgimp.kernels.contact.lagrangian.vertices import ContactVertices, sum_at_contact_vertices
from pgimp.kernels.data.ledger import CONTACT_AREA, Ledger
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.lagrangian.bonds import bonded, interactions, separating_walls, with_walls
from pgimp.solver.contact.lagrangian.broad_phase import BroadPhase, reach
from pgimp.solver.contact.lagrangian.joint import Joint, join, share
from pgimp.solver.contact.lagrangian.known import refuse
from pgimp.solver.contact.lagrangian.near_particles import Near, NearParticles
from pgimp.solver.contact.lagrangian.selected import Selection, flat
from pgimp.solver.contact.lagrangian.selection import Selector
from pgimp.solver.contact.lagrangian.warm_start import WarmStart
from pgimp.solver.lagrangian.masters import REACH as MASTERS_AWAY
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate

#: The most sweeps over all pairs in a step, and the relative change of impulses that ends them. To
#: 1e-3 only, the vertices round a corner that leans on a wall took energy from it, without end.
SWEEPS, TOLERANCE = 100, 1e-5

#: The tolerance with free rigid bodies: all impulses on one change the velocities of all others.
COUPLED_ACCURACY = 200, 1e-6


class LagrangianContact(NoContact):
    """Contact of bodies in the initial configuration, on one rank.

    Particles near contact are copied to the ranks that share out the vertices round their current
    positions, in canonical order, with their reference vertices. These ranks find the candidate
    pairs and their rows of B. The rank with the first layer solves for the impulses of all, and
    tells what they change at reference vertices: nothing depends on the ranks.

    Attributes
    ----------
    fields : tuple of int
        Number of each body's velocity field on the reference grid: bodies in initial contact have
        different fields unless they are bonded.
    free : FreeBodies or None
        The rigid bodies that move freely, if any.
    sweeps : int
        Sweeps over the pairs in the last step with any, on the rank that solves.
    """

    bears = True

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self.call = Bound()
        self.bodies = len(scene.body_names)
        self.fields = (0,) * self.bodies if scene.interaction.pairs else ()
        self.groups = np.zeros(self.bodies, np.int64)
        self._grouped = False
        self.pairs, self._walls = with_walls(scene), separating_walls(scene)
        self._broad_phase = BroadPhase(scene, comm, self.pairs, self._walls)
        rigid_bodies: Any = (
            scene.interaction.rigid_bodies.in_planes(1) if scene.interaction.rigid_bodies else ()
        )
        self._contact = Contact.empty(
            self.pairs, np.empty(0), 1, self.bodies + 1, len(scene.domain.faces), rigid_bodies
        )
        self.free = FreeBodies(scene, comm) if scene.interaction.rigid_bodies.free else None
        self._accuracy = COUPLED_ACCURACY if self.free else (SWEEPS, TOLERANCE)
        self._every_face = scene.domain.standing_faces()
        self._selector = Selector(scene, comm, rigid_bodies, self._walls, self._every_face)
        self._selector.acts = interactions(
            self.pairs, self.groups, len(scene.interaction.rigid_bodies)
        )
        self._particles = NearParticles(scene, comm, self._selector.local)
        self._selection: Selection | None = None
        self._warm_start = WarmStart(comm)
        self._dt, self.sweeps = 0.0, 0
        self._box = np.zeros((WIDE**2, WIDE))

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () without any."""
        return self._contact.rigid_bodies

    def require_known(self, done: Step) -> None:
        """See `NoContact.require_known`."""
        if self._broad_phase.lost:
            refuse(self._broad_phase.lost, done)

    def moved(self) -> None:
        """See `NoContact.moved`: all particles are searched again in the next step."""
        self._broad_phase.restart()

    @property
    def kept_forces(self) -> np.ndarray:
        """See `NoContact.kept_forces`."""
        return self._warm_start.stored

    def restore_forces(self, forces: np.ndarray) -> None:
        """See `NoContact.restore_forces`."""
        self._warm_start.restore(forces)

    def assign_fields(self, rank: RankState) -> None:
        """See `NoContact.assign_fields`; once, for the groups of bodies bonded at the start."""
        if self._grouped:
            return
        self._grouped = True
        scene, grid, population = self.scene, rank.grid, rank.population
        if not self.fields:
            return
        p, order = population.up_to_date(), population.order
        boxes = np.full((2, self.bodies, scene.dimension), np.inf)
        boxes[1] = -np.inf
        grow_boxes(scene.domain.frame, p._replace(x=p.origin), order, boxes)
        every = np.array(self.comm.allgather(boxes))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        distance = 2.0 * reach(scene)
        exact = bool(scene.settings.exact_surfaces.any())
        domain = scene.domain
        cells = [n * joined for n, joined in zip(domain.frame.cells, domain.periodic, strict=True)]
        self.fields, self.groups = bonded(
            self.pairs, low, high, distance, scene.settings.lagrangian, exact * MASTERS_AWAY, cells
        )
        self._selector.groups = self.groups
        self._selector.acts = interactions(
            self.pairs, self.groups, len(scene.interaction.rigid_bodies)
        )
        self._selector.fields = np.array(self.fields, np.int64)
        if max(self.fields) > 0 and self.fields != grid.fields:
            grid.fields = self.fields
            grid.store(grid.base)

    def exchange(self, rank: RankState, update: VertexUpdate) -> None:
        """See `NoContact.exchange`.

        Velocities and accelerations of the vertices change. Contact is at current positions; faces
        and constraints hold reference vertices, at initial positions.
        """
        rigid_bodies, free = self.rigid_bodies, self.free
        t, _, forcing, ledger = update
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        self.changes = None
        if self.scene.interaction.rigid_bodies:
            self.scene.interaction.rigid_bodies.at(
                t.start, t.end, free.states if free else None
            )  # in place
        if free:
            free.begin(rigid_bodies, t, forcing.gravity)
        rate = free.rate if free else 0.0
        looked = self._broad_phase.update(
            rank.population, self.groups, rigid_bodies, t, rate, rank.grid
        )
        rate = max(self.scene.interaction.rigid_bodies.rate, rate)
        travel, self._dt = rate * self._dt, t.dt
        if looked:
            self._selection = None
        if needed(self._broad_phase.any):
            self._exchange_near(rank, update, self._select(rank, looked, travel, rate * t.dt))
        else:
            self._warm_start.clear()
        if free:
            free.end(rigid_bodies, t.dt)

    def _select(
        self, rank: RankState, looked: bool, travel: float, rigid_speed: float
    ) -> Selection:
        """The last selection, or another one if that does not hold; collective."""
        selection = self._selection
        lasts = needed(selection is not None) and self._selector.lasts(rank.grid, travel)
        if selection is None or not lasts:
            near, speeds = self._broad_phase.near, (self._broad_phase.travel, rigid_speed)
            selection = self._selector.select(rank, near, speeds, looked)
            self._selection = selection
        return selection

    def _exchange_near(self, rank: RankState, update: VertexUpdate, selection: Selection) -> None:
        """Solve for the impulses."""
        scene, contact, call, grid = self.scene, self._contact, self.call, rank.grid
        t, faces, forcing, ledger = update
        holding = Holding(
            faces, scene.domain.frame, forcing, contact.scratch_impulse, forcing.loads.relaxation
        )
        near = self._particles.gather(grid.field, rank.population, selection, holding)
        joint: Joint | None = Joint(*self._find(near, t), near.vertices)
        assert joint is not None
        found = len(joint.pairs.ends)
        if self.comm.size > 1:
            found, joint = join(self.comm, self._selector.root, joint)
        if not needed(found):
            self._warm_start.clear()
            return
        self._warm_start.move_to(self._selector.root)
        changes = None
        if joint is not None:
            changes = self._solve(joint, nothing_held(holding), ledger)
        else:
            self._warm_start.clear()
        if self.comm.size > 1:
            answers = self.rigid_bodies.responses["trial_impulse"] if self.free else np.empty(0)
            changes = share(self.comm, self._selector.root, changes, answers)
        assert changes is not None
        self.changes = changes
        call(change_velocities, scene.domain.frame, grid.field, changes, forcing, ledger.work)
        call(book_held, holding, grid.field, changes, ledger)

    def _solve(self, joint: Joint, free: Holding, ledger: Ledger) -> Changes:
        """Solve for the impulses of pairs, and book them."""
        call, mirrors = self.call, self._selector.mirrors
        pairs, coupling, known = joint
        vertices, solved = flat(known.values), Solved.empty(len(known.values), coupling)
        call(begin_solution, free.frame, vertices, coupling, solved)
        self._sweep(free, pairs, coupling, solved)
        self._warm_start.keep(pairs, self._dt)
        changes = self._changes(known, solved)
        if coupling.beyond.size:  # rows of surfaces are of vertices that there are
            call(book_mirrored, pairs, coupling, mirrors, ledger)
        self._book(free, pairs, coupling, solved, vertices, ledger)
        return changes

    def _changes(self, known: ReferenceVertices, solved: Solved) -> Changes:
        """What the impulses have changed."""
        changes = Changes(known.keys, *np.empty((2, len(known.keys), 3)))
        self.call(find_changes, flat(known.values), solved, changes)
        return changes

    def _sweep(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved
    ) -> None:
        """Solve for the impulses of pairs, by sweeps."""
        contact, call = self._contact, self.call
        scratch = np.empty((2, len(pairs.ends), IMPULSES))
        self._warm_start.begin(contact, pairs, coupling, solved, self._dt)
        self.sweeps = call(
            solve_impulses, contact, free, pairs, coupling, solved, scratch, *self._accuracy
        )

    def _book(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved,
        vertices: np.ndarray, ledger: Ledger,
    ) -> None:  # fmt: skip
        """Book the impulses of pairs."""
        of = self._contact, free, pairs, coupling, solved, vertices
        self.call(book_contacts, *of, self._walls, ledger)

    def _find(self, near: Near, t: Step) -> tuple[ContactPairs, Coupling]:
        """Find the candidate pairs in this rank's share, and their rows of B."""
        contact, call, frame = self._contact, self.call, self.scene.domain.frame
        table, contact_vertices = near.selection.table, near.selection.contact_vertices
        left = self._particles.left(near)
        self._particles.forget_moved(near, self.rigid_bodies)
        call(sum_at_contact_vertices, frame, table, near.motion, near.now, *left, contact_vertices)
        contact_vertices = contact_vertices._replace(
            order=np.flatnonzero(contact_vertices.sums["mass"] > 0.0)
        )
        contact_pairs, pairs = grown(
            4 * len(contact_vertices.keys),
            ContactPairs.empty,
            lambda found: call(
                find_contact_pairs, contact, frame, self._every_face, self._walls,
                contact_vertices, t.dt, found,
            ),
        )  # fmt: skip
        contact_pairs = contact_pairs.chosen(slice(pairs))
        return contact_pairs, self._couple(near, contact_vertices, contact_pairs)

    def _couple(
        self, near: Near, contact_vertices: ContactVertices, contact_pairs: ContactPairs
    ) -> Coupling:
        """Find the rows of B for pairs."""
        call, mirrors, selection = self.call, self._selector.mirrors, near.selection
        row_of = np.empty(len(contact_vertices.keys), np.int64)
        slots = np.empty(2 * len(contact_pairs.ends), np.int64)
        rows = call(number_rows, contact_pairs, row_of, slots)
        seen = np.empty((2, len(near.vertices.keys)), np.int64)
        left, fields = (
            np.empty(len(selection.table), np.int64),
            1 + int(self._selector.fields.max()),
        )
        scratch = (flat(near.vertices.values), seen, left, self._box)
        coupling, entries = grown(
            64 * rows + WIDE**3,
            lambda size: Coupling(
                np.empty(rows + 1, np.int64),
                np.empty(size, np.int64),
                np.empty((size, 4 if len(mirrors) else 1)),
                np.empty((rows, 3)),
                np.zeros((rows, len(mirrors), 3)),
            ),
            lambda found: call(
                find_coupling, self.scene.domain.frame, (selection.table, near.motion),
                (selection.initial, selection.hashes, selection.keys, fields, selection.parts),
                mirrors, slots[:rows], contact_vertices, scratch, found,
            ),
        )  # fmt: skip
        return coupling._replace(column=coupling.column[:entries], entry=coupling.entry[:entries])


def nothing_held(holding: Holding) -> Holding:
    """Conditions inside the solver: none, as constrained vertices have no inverse mass."""
    forcing = holding.forcing._replace(marked=(), clearances=())
    return holding._replace(faces=(), forcing=forcing)
