"""Contact of bodies in the initial configuration: each other, rigid bodies, unilateral walls.

In cases with both configurations all bodies use this contact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.lagrangian.books import book_contacts, book_mirrored
from pgimp.kernels.contact.lagrangian.boxes import grow_boxes
from pgimp.kernels.contact.lagrangian.coupling import Coupling, find_coupling
from pgimp.kernels.contact.lagrangian.gauss_seidel import solve_impulses
from pgimp.kernels.contact.lagrangian.hash_table import empty_table, insert_keys
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs, find_contact_pairs
from pgimp.kernels.contact.lagrangian.reactions import book_held
from pgimp.kernels.contact.lagrangian.reference_grid import (
    ReferenceVertices,
    change_velocities,
    number_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.vertices import sum_at_contact_vertices
from pgimp.kernels.data.ledger import CONTACT_AREA
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.contact.lagrangian.bonds import bonded, separating_walls, with_walls
from pgimp.solver.contact.lagrangian.broad_phase import BroadPhase, reach
from pgimp.solver.contact.lagrangian.near_particles import Near, NearParticles, in_order
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate

#: The most sweeps over all pairs in a step, and the relative change of impulses that ends them. A
#: hundred sweeps to 1e-4 find the same motion, but disks in contact then lose more energy.
SWEEPS, ENOUGH = 30, 1e-3

#: The tolerance with free rigid bodies: all impulses on one change the velocities of all others.
TOGETHER = 200, 1e-6


class LagrangianContact(NoContact):
    """Contact of bodies in the initial configuration, on one rank.

    Particles near contact are copied to the ranks that share out the vertices round their current
    positions, in canonical order, with their reference vertices. These ranks find the candidate
    pairs and their rows of B. All ranks gather them, solve for the same impulses and apply these to
    their own vertices: nothing depends on the ranks.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.

    Attributes
    ----------
    fields : tuple of int
        Number of each body's velocity field on the reference grid: bodies in initial contact have
        different fields unless they are bonded.
    sweeps : int
        Sweeps of the last step.
    free : FreeBodies or None
        The rigid bodies that move freely, if any.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self.call = Bound()
        self.bodies = len(scene.body_names)
        self.fields = (0,) * self.bodies if scene.interaction.pairs else ()
        self.groups = np.zeros(self.bodies, np.int64)
        self.sweeps = 0
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
        self._accuracy = TOGETHER if self.free else (SWEEPS, ENOUGH)
        self._every_face = scene.domain.standing_faces()
        self._particles = NearParticles(scene, comm, rigid_bodies, self._walls)

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () without any."""
        return self._contact.rigid_bodies

    def moved(self) -> None:
        """See `NoContact.moved`: all particles are searched again in the next step."""
        self._broad_phase.restart()

    def assign_fields(self, rank: RankState) -> None:
        """See `NoContact.assign_fields`; once, for the groups of bodies bonded at the start."""
        if self._grouped:
            return
        self._grouped = True
        scene, grid, population = self.scene, rank.grid, rank.population
        if not self.fields:
            return
        p, order = population.particles, population.order
        boxes = np.full((2, self.bodies, scene.dimension), np.inf)
        boxes[1] = -np.inf
        grow_boxes(scene.domain.frame, p._replace(x=p.origin), order, boxes)
        every = np.array(self.comm.allgather(boxes))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        distance = 2.0 * reach(scene)
        self.fields, self.groups = bonded(
            self.pairs, low, high, distance, scene.settings.lagrangian
        )
        self._particles.groups = self.groups
        self._particles.fields = np.array(self.fields, np.int64)
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
        if self.scene.interaction.rigid_bodies:
            self.scene.interaction.rigid_bodies.at(
                t.start, t.end, free.states if free else None
            )  # in place
        if free:
            free.begin(rigid_bodies, t, forcing.gravity)
        rate = free.rate if free else 0.0
        looked = self._broad_phase.update(rank.population, self.groups, rigid_bodies, t, rate)
        if needed(self._broad_phase.any):
            self._exchange_near(rank, update, looked)
        if free:
            free.end(rigid_bodies, t.dt)

    def _exchange_near(self, rank: RankState, update: VertexUpdate, anew: bool) -> None:
        """Solve for the impulses; `anew`: divide the vertices among the ranks again."""
        scene, contact, call = self.scene, self._contact, self.call
        t, faces, forcing, ledger = update
        grid, population = rank.grid, rank.population
        holding = Holding(
            faces, scene.domain.frame, forcing, contact.scratch_impulse, forcing.loads.relaxation
        )
        rows = population.order[self._broad_phase.near].astype(np.int64)
        if population.outdated:
            population.update(self._broad_phase.near)
        near = self._particles.gather(grid, population.stored, rows, holding, anew)
        contact_pairs, coupling = self._find(near, t)
        vertices = near.vertices
        if self.comm.size > 1:
            contact_pairs, coupling, vertices = unite(self.comm, contact_pairs, coupling, vertices)
        self.sweeps = 0
        if not needed(len(contact_pairs.ends)):
            return
        values, free = vertices.values, nothing_held(holding)
        before = values["velocity"].copy()
        self.sweeps = call(
            solve_impulses, contact, free, contact_pairs, coupling, values, *self._accuracy
        )
        changes = values["velocity"] - before
        call(
            change_velocities,
            scene.domain.frame,
            grid.field,
            vertices.keys,
            changes,
            forcing,
            ledger.work,
        )
        call(book_held, holding, grid.field, vertices, ledger)
        if grid.slab.layers and grid.slab.lower is None:
            if len(self._particles.mirrors):
                call(book_mirrored, contact_pairs, coupling, self._particles.mirrors, ledger)
            call(book_contacts, contact, free, contact_pairs, coupling, values, self._walls, ledger)

    def _find(self, near: Near, t: Step) -> tuple[ContactPairs, Coupling]:
        """Find the candidate pairs in this rank's share, and their rows of B."""
        contact, call, frame = self._contact, self.call, self.scene.domain.frame
        table, patches, contact_vertices, start, vertices = near
        now, mirrors = self._particles.supports(table, True), self._particles.mirrors
        left = self._particles.left(table, now)
        call(
            sum_at_contact_vertices,
            frame,
            table,
            now,
            *left,
            patches.patch,
            patches.numbers,
            contact_vertices,
        )
        order = np.argsort(contact_vertices.keys)
        contact_vertices = contact_vertices._replace(
            order=order[contact_vertices.sums["mass"][order] > 0.0]
        )
        capacity = 4 * len(contact_vertices.keys)
        while True:
            contact_pairs = ContactPairs.empty(capacity)
            pairs = call(
                find_contact_pairs, contact, frame, self._every_face, self._walls,
                contact_vertices, t.dt, contact_pairs,
            )  # fmt: skip
            if pairs <= capacity:
                break
            capacity = pairs
        contact_pairs = contact_pairs.chosen(slice(pairs))
        if needed(pairs):
            hashes = empty_table(len(vertices.keys))
            call(insert_keys, vertices.keys, hashes)
            fields = 1 + max(self.fields, default=0)
            call(number_reference_vertices, frame, table, start, mirrors, fields, hashes)
        coupling = call(
            find_coupling, frame, table, now, start, mirrors, contact_pairs, contact_vertices.sums,
            vertices.values,
        )  # fmt: skip
        return contact_pairs, coupling


def unite(
    comm: Communicator, contact_pairs: ContactPairs, coupling: Coupling, vertices: ReferenceVertices
) -> tuple[ContactPairs, Coupling, ReferenceVertices]:
    """Pairs and rows of B of all ranks, in the order of vertices, with the vertices; collective.

    Columns of B are then numbers of the returned vertices, and rows of the pairs are numbers in
    the united matrix.
    """
    used, new = np.unique(coupling.column, return_inverse=True)
    mine = ReferenceVertices(vertices.keys[used], vertices.values[used])
    every = comm.allgather((contact_pairs, coupling._replace(column=new), mine))
    pairs, answers, known = zip(*every, strict=True)
    keys = np.concatenate([each.keys for each in known])
    union = in_order(ReferenceVertices(keys, np.concatenate([each.values for each in known])))
    rows = entries = 0
    starts = [np.zeros(1, np.int64)]
    columns = []
    for (ends, _, _), answer, own in zip(pairs, answers, known, strict=True):
        sides = ends["rows"]
        sides[sides >= 0] += rows
        starts.append(answer.start[1:] + entries)
        columns.append(np.searchsorted(union.keys, own.keys)[answer.column])
        rows, entries = rows + len(answer.answer), entries + len(answer.column)
    joined = ContactPairs(
        np.concatenate([each.ends for each in pairs]),
        np.concatenate([each.states for each in pairs]),
        np.concatenate([each.rigid for each in pairs]),
    )
    order = np.lexsort(joined.ends["vertex"].T[::-1])
    coupling = Coupling(
        np.concatenate(starts),
        np.concatenate(columns),
        np.concatenate([each.entry for each in answers]),
        np.concatenate([each.answer for each in answers]),
        np.concatenate([each.beyond for each in answers]),
    )
    return joined.chosen(order), coupling, union


def nothing_held(holding: Holding) -> Holding:
    """Conditions inside the solver: none, as constrained vertices have no inverse mass."""
    forcing = holding.forcing._replace(marked=(), clearances=())
    return holding._replace(faces=(), forcing=forcing)
