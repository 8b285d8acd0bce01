"""Contact of bodies: their velocity fields, and the sums that give the gaps between them."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.population import Population
from pgimp.errors import DamagedError
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import marked, needed
from pgimp.kernels.contact.apart import Search
from pgimp.kernels.contact.colouring import find_excursion
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.fill import find_rigid_vertices
from pgimp.kernels.contact.rigid_newton import find_rigid_impulses
from pgimp.kernels.contact.select import select_near
from pgimp.kernels.contact.vertex import contact_forces, find_contact_vertices
from pgimp.kernels.contact.vertex_list import list_vertices
from pgimp.kernels.contact.volumes import volume_sums
from pgimp.kernels.data.arguments import Field, Order
from pgimp.kernels.data.ledger import CONTACT_AREA, Ledger
from pgimp.kernels.step.momentum import BEGINNING, REST, WHOLE
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.contact.velocity_fields import (
    MARGIN,
    assign,
    body_boxes,
    margin_of,
    reach,
    where_near,
)
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertex_sums import VertexSums
from pgimp.solver.vertices import VertexUpdate

#: Marks of constrained vertices in scenes without any.
_NONE_HELD = np.empty(0, np.int64)

#: Coordinates of the boxes of bodies without particles, in checkpoints.
_EMPTY = 1e300

#: With contact in more than this part of the planes, all their particles count as near.
_MOST_OF_A_PLANE = 0.6


class MultifieldContact(NoContact):
    """Contact on one rank.

    Volumes are summed only for planes in which several fields have mass. Layered sums and exchange
    are as for masses, so that all ranks get the same bits. A neighbour takes part if it shares such
    a plane, on which both sides agree.

    Parameters
    ----------
    scene : Scene
        The scene, which has contact.

    Attributes
    ----------
    fields : tuple of int
        Number of each body's velocity field.
    free : FreeBodies or None
        The rigid bodies that move freely, if any.
    """

    at_vertices, by_planes = True, False

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        assert scene.interaction.pairs is not None
        self.pairs, self.call = scene.interaction.pairs, Bound()
        self.fields = (0,) * len(scene.body_names)
        self.free = FreeBodies(scene, comm) if scene.interaction.rigid_bodies.free else None
        self._reach = reach(scene)
        self._boxes = np.empty((2, 0, scene.dimension))  # of the last search, or of none so far
        self._margin, self._moved = MARGIN, [0.0, 0.0]  # how far they may move, and have moved
        self._taken = self._noted = 0  # steps since then, and those of which ranks have heard
        self._where: Any = None
        self._rows = np.empty(0, np.int32)
        self._volumes = VertexSums(scene, comm, volume_sums(scene.settings.shape))

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () without any."""
        return self.data.rigid_bodies if self.data else ()

    def assign_fields(self, rank: RankState) -> None:
        """See `NoContact.assign_fields`; when bodies may have left their margins.

        Ranks that wait for each other have heard of one step more. No rank makes use of that.
        """
        last = (self._taken - 1) // self._every * self._every
        known = self._moved[0 if self._noted // self._every * self._every > last else 1]
        if self._boxes.shape[1] and known + self._taken - max(last, 0) <= self._margin:
            return
        self._moved, self._taken, self._noted = [0.0, 0.0], 0, self._noted - self._taken
        population, count = rank.population, len(self.fields)
        self._boxes = body_boxes(
            self.scene.domain, population.up_to_date(), population.order, count, self.comm
        )
        self._share(rank)

    def _share(self, rank: RankState, fields: tuple[int, ...] = ()) -> None:
        """Use given fields, or those for the boxes of the bodies, until the next search."""
        self.fields = fields or assign(self._boxes, self._reach)
        self._margin = margin_of(self._boxes, self._reach, self.fields)
        self._where = None
        if self.fields != rank.grid.fields:
            rank.grid.regroup(self.fields)

    @property
    def _every(self) -> int:
        """Steps from one look at how far bodies have moved to the next."""
        return max(int(0.5 * self._margin), 1)

    def excursion(self, rank: RankState) -> float:
        """See `NoContact.excursion`; 0 in steps without a look."""
        p, rows = rank.population.up_to_date(), rank.population.order
        self._taken += 1
        if not needed(self._taken % self._every == 0):
            return 0.0
        return self.call(find_excursion, self.scene.domain.frame, p.x, p.body, rows, self._boxes)

    def note_excursion(self, greatest: float) -> None:
        """See `NoContact.note_excursion`; that of a step before the last search is of no use."""
        self._noted += 1
        if self._noted > 0 and self._noted % self._every == 0:
            self._moved = [self._moved[1], greatest]

    @property
    def assignment(self) -> np.ndarray:
        """See `NoContact.assignment`: 0, and the fields."""
        return np.array([0, *self.fields], np.int64)

    @property
    def search(self) -> np.ndarray:
        """See `NoContact.search`: how far bodies have moved, in how many steps, and from where."""
        boxes = np.clip(self._boxes, -_EMPTY, _EMPTY)
        return (
            np.array([*self._moved, self._taken, *boxes.flat, *[0.0] * 8])
            if self.comm.rank == 0
            else np.empty(0)
        )

    def restore_search(self, search: np.ndarray) -> None:
        """See `NoContact.restore_search`."""
        if len(search) != 11 + 2 * len(self.fields) * self.scene.dimension:
            raise DamagedError("its search for contact is of other bodies")
        self._moved, self._taken = search[:2].tolist(), int(search[2])
        self._noted = self._taken
        self._boxes = search[3:-8].reshape(2, len(self.fields), -1).copy()

    def restore(self, rank: RankState, assignment: np.ndarray) -> None:
        """See `NoContact.restore`; after `restore_search`."""
        if self._boxes.shape[1]:
            self._share(rank, tuple(assignment[1:].tolist()))

    def detect(self, rank: RankState, t: Step, ledger: Ledger) -> None:
        """See `NoContact.detect`; volumes are summed at contact vertices."""
        grid = rank.grid
        if self._volumes.fit(grid, self.fields):
            self._connect(grid)
        contact = self.data
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        contact.vertex_counts.fill(0)
        scene, rigid_bodies = self.scene, self.scene.interaction.rigid_bodies
        if not needed(max(self.fields) or rigid_bodies):
            return
        if self._where is None:
            self._where = self._find_planes(grid)
        self.call(
            find_contact_vertices,
            grid.field,
            self._where,
            contact.marks,
            contact.vertex_counts,
            contact.vertex_ranges,
        )
        if rigid_bodies:
            placed = rigid_bodies.at(t.start, t.end, self.free.states if self.free else None)
            if self.free:
                contact.rigid_bodies.responses.fill(0.0)
            self.call(
                find_rigid_vertices,
                scene.domain.frame,
                grid.field,
                placed,
                contact.near,
                contact.marks,
                contact.vertex_counts,
                contact.vertex_ranges,
            )
        found = marked(contact.vertex_counts)
        if len(found):
            order = self._near(grid, rank.population)
            self._volumes.add(rank.up_to_date(), order, found)

    def update_momentum(self, rank: RankState, update: VertexUpdate) -> None:
        """See `NoContact.update_momentum`.

        The impulses on free rigid bodies depend on their new velocities, which depend on them: both
        are solved for, between two parts of the update.
        """
        self._list(rank, update, False)
        if self.free is None:
            self.advance(rank, update, WHOLE)
            return
        self.advance(rank, update, BEGINNING)
        self._list(rank, update, True)
        self._solve_free(rank, update)
        self.advance(rank, update, REST)
        self.free.move(self.rigid_bodies, rank.grid, update.t.dt)

    def hold(self, rank: RankState, update: VertexUpdate, field: Field) -> None:
        """See `NoContact.hold`; what the update has listed is listed for another field, too."""
        if field is rank.grid.field:
            self._list(rank, update, False)
        self.advance(rank, update, WHOLE, field)

    def _solve_free(self, rank: RankState, update: VertexUpdate) -> None:
        """Find the velocities of free rigid bodies at the step's end."""
        if self.free is None:
            return
        respond = partial(
            rank.call,
            find_rigid_impulses,
            self.data,
            update.faces,
            self.scene.domain.frame,
            rank.grid.field,
            update.forcing,
        )
        gravity = update.forcing.gravity
        self.free.solve_velocities(self.rigid_bodies, rank.grid, update.t, gravity, respond)

    def forces(self, rank: RankState, update: VertexUpdate, out: np.ndarray) -> None:
        """See `NoContact.forces`."""
        self._list(rank, update, False)
        if update.forcing.loads.relaxation != ():
            self._add_forces(rank, update, False, out)
        self.advance(rank, update, BEGINNING)
        if self.free:
            self._list(rank, update, True)
        self._solve_free(rank, update)
        self._add_forces(rank, update, True, out)

    def _add_forces(
        self, rank: RankState, update: VertexUpdate, last: bool, out: np.ndarray
    ) -> None:
        """Add the forces of a pass to those at the vertices."""
        rank.call(
            contact_forces, self.data, update.faces, self.scene.domain.frame, rank.grid.field,
            update.forcing, last, out,
        )  # fmt: skip

    def _list(self, rank: RankState, update: VertexUpdate, last: bool) -> None:
        """List the contact vertices; for the last pass anew only with free rigid bodies."""
        contact = self.data
        if not needed(contact.vertex_counts.any()):
            contact.listed.start.fill(0)
            return
        domain, forcing = self.scene.domain, update.forcing
        light = np.inf if rank.phases else rank.mass_cutoff
        held = forcing.marked[1] if forcing.marked else _NONE_HELD
        search = Search(
            update.faces, domain.frame, rank.grid.field, update.t.dt, last, forcing.gravity, light,
            held,
        )  # fmt: skip
        folded = bool(domain.mirrors or domain.absorbing_mirrors)
        while True:
            self.call(list_vertices, self.data, search, folded)
            if self.data.listed.fits():
                return
            self.data = self.data._replace(listed=self.data.listed.with_room())

    def _find_planes(self, grid: Grid) -> np.ndarray:
        """Find the planes of possible contact until fields are regrouped: all for rigid bodies."""
        if self.scene.interaction.rigid_bodies:
            return np.ones(grid.planes, bool)
        first, planes = int(grid.window.lower[0]) - self.scene.domain.frame.ghost, grid.planes
        intervals = where_near(self._boxes, 2.0 * self._margin + self._reach, self.fields)
        begin = np.clip(np.ceil(intervals[:, 0]) - first, 0, planes).astype(np.int64)
        end = np.clip(np.floor(intervals[:, 1]) + 1 - first, 0, planes).astype(np.int64)
        more, less = (np.bincount(each, minlength=planes + 1) for each in (begin, end))
        return np.cumsum(more - less)[:planes] > 0

    def _connect(self, grid: Grid) -> None:
        """Connect the data of kernels to the grids; allocate them if there is no room."""
        self._where, scene, sums = None, self.scene, self._volumes.grid
        rigid_bodies, most = scene.interaction.rigid_bodies, 1 + max(self.fields)
        old = self.data and (len(self.data.vertex_counts), len(self.data.fields))
        if not old or old[0] != grid.planes or old[1] < most + len(rigid_bodies):
            self.data = Contact.empty(
                self.pairs,
                sums.G,
                grid.planes,
                most + most // 4,
                len(scene.domain.faces),
                rigid_bodies.in_planes(grid.planes) if rigid_bodies else (),
            )
        near, marks = self.data.near, self.data.marks
        if marks.shape != grid.window.extent:
            marks = np.zeros(grid.window.extent, np.int64)
        if rigid_bodies and near.shape != grid.window.extent:
            near = np.zeros(grid.window.extent, np.int8)
        new = {"volumes": sums.G, "used": sums.field.used, "near": near, "marks": marks}
        self.data = self.data._replace(**new)

    def _near(self, grid: Grid, population: Population) -> Order:
        """Find the particles that may have weight on contact vertices."""
        order, extent = population.ordered, grid.window.extent
        ranges = self.data.vertex_ranges.view(np.int64).reshape(-1, 2, 2)  # others are empty
        if any(self.scene.domain.periodic):  # also particles at the other side of a seam are near
            return order
        part = 1.0
        for d in range(1, self.scene.dimension):
            part *= (ranges[:, 1, d - 1].max() - ranges[:, 0, d - 1].min() + 1) / extent[d]
        if not needed(part <= _MOST_OF_A_PLANE):
            return order
        if len(self._rows) < len(order.rows):
            self._rows = np.empty(len(order.rows) * 9 // 8, np.int32)
        return near_vertices(self.call, grid, population, order, self.data, self._rows)


def near_vertices(
    call: Bound, grid: Grid, population: Population, order: Order, contact: Contact,
    rows: np.ndarray,
) -> Order:  # fmt: skip
    """Particles of an order that may have weight on contact vertices, in `rows`, (n,) int32."""
    start = np.empty_like(order.start)
    call(
        select_near, grid.frame, grid.window, population.up_to_date(), order,
        contact.vertex_ranges, grid.vertices - 1, rows, start,
    )  # fmt: skip
    return Order(rows[: start[-1]], start)
