"""Contact of bodies in the initial configuration: each other, rigid bodies, walls that let go.

Where bodies of both configurations are in one case, all of them meet in this way.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.population import Population
from pgimp.jit.bound import Bound
from pgimp.kernels.accumulated import find_responses, solve_impulses
from pgimp.kernels.boxes import grow_boxes
from pgimp.kernels.concepts import Forcing, Setting
from pgimp.kernels.contact import Contact
from pgimp.kernels.encounters import Encounters, find_encounters
from pgimp.kernels.heldbooks import book_held
from pgimp.kernels.holding import Holding
from pgimp.kernels.ledger import CONTACT_AREA, Ledger
from pgimp.kernels.numbered import number_keys, room_for
from pgimp.kernels.present import HALF, NEAR, PLACE, START, SUMMED, Present, sum_present, take_near
from pgimp.kernels.presentbooks import book_contacts, book_mirrored
from pgimp.kernels.startgrid import (
    MOVES,
    STARTED,
    YIELDS,
    Seen,
    StartVertices,
    find_vertices,
    give_to_vertices,
    take_vertices,
)
from pgimp.kernels.support import Supports, find_supports, local_vertices
from pgimp.scene.scene import Scene
from pgimp.solver.approach import Approach, reach
from pgimp.solver.bonds import bonded, separating_walls, with_walls
from pgimp.solver.clock import Step
from pgimp.solver.freebodies import FreeBodies

#: The most sweeps over all pairs in a step, and the relative change of impulses that ends them. A
#: hundred sweeps to 1e-4 find the same motion, but disks that meet then lose more.
SWEEPS, ENOUGH = 30, 1e-3

#: The same where rigid bodies move freely: all impulses on one change the velocities of all others.
TOGETHER = 200, 1e-6


class PresentMeetings:
    """Contact of bodies in the initial configuration, on one rank.

    Particles that are near something are gathered on all ranks, in canonical order, with the
    vertices of their own grid. All ranks then find the same impulses and apply them to their own
    vertices: nothing depends on the ranks, and no step needs more than one exchange.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.

    Attributes
    ----------
    fields : tuple of int
        Number of each body's velocity field on the grid of the start: bodies that touch there have
        fields of their own unless they are bonded.
    sweeps : int
        Those of the last step.
    free : FreeBodies or None
        The rigid bodies that move freely, if there are any.
    """

    def __init__(self, scene: Scene, comm: Any) -> None:
        self.scene, self.comm, self.call = scene, comm, Bound()
        self.bodies = len(scene.body_names)
        self.fields: tuple[int, ...] = (0,) * self.bodies if scene.pairs else ()
        self.groups = np.zeros(self.bodies, np.int64)
        self.sweeps = 0
        self._grouped = False
        self._seen = Seen(np.empty(0, np.int64), 0)
        self.pairs, self._walls = with_walls(scene), separating_walls(scene)
        self._approach = Approach(scene, comm, self.pairs, self._walls)
        tools: Any = scene.tools.in_planes(1) if scene.tools else ()
        self._contact = Contact.empty(
            self.pairs, np.empty(0), 1, self.bodies + 1, len(scene.faces), tools
        )
        self.free = FreeBodies(scene, comm) if scene.tools.free else None
        self._accuracy = TOGETHER if self.free else (SWEEPS, ENOUGH)
        self._every_face = scene.standing_faces()
        self._plain, self._mirrors = plain(scene), mirrors_of(scene)
        self._local = local_vertices(scene.vertices, scene.dimension)

    def forget(self) -> None:
        """Search all particles again in the next step: they have changed, or their bodies have."""
        self._approach.forget()

    def group(self, grid: Grid, population: Population) -> None:
        """Find, once, which bodies are bonded at the start; collective."""
        if self._grouped:
            return
        self._grouped = True
        scene = self.scene
        if not self.fields:
            return
        p, order = population.particles, population.order
        boxes = np.full((2, self.bodies, scene.dimension), np.inf)
        boxes[1] = -np.inf
        grow_boxes(scene.frame, p._replace(x=p.origin), order, boxes)
        every = np.array(self.comm.allgather(boxes))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        distance = 2.0 * reach(scene)
        self.fields, self.groups = bonded(self.pairs, low, high, distance, scene.begun)
        if max(self.fields) > 0 and self.fields != grid.fields:
            grid.fields = self.fields
            grid.store(grid.base)

    def exchange(
        self, grid: Grid, population: Population, ledger: Ledger, t: Step, forcing: Forcing,
        faces: Any,
    ) -> None:  # fmt: skip
        """Exchange the impulses of contact, after the update of momentum; collective.

        Velocities and accelerations of the vertices change. Bodies meet where they are now; faces
        and constraints hold the vertices of the start, as at the start.
        """
        contact, free = self._contact, self.free
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        if self.scene.tools:
            self.scene.tools.at(t.start, t.end, free.states if free else None)  # in place
        if free:
            free.begin(contact.tools, t, forcing.gravity)
        rate = free.rate if free else 0.0
        self._approach.follow(population, self.groups, contact.tools, t, rate)
        if self._approach.any:
            self._meet(grid, population, ledger, t, forcing, faces)
        if free:
            free.end(contact.tools, t.dt)

    def _meet(
        self, grid: Grid, population: Population, ledger: Ledger, t: Step, forcing: Forcing,
        faces: Any,
    ) -> None:  # fmt: skip
        """Exchange the impulses of what may be near something."""
        scene, contact, call = self.scene, self._contact, self.call
        holding = Holding(faces, scene.frame, forcing, contact.unbooked)
        table, vertices = self._gather(grid, population, holding)
        before = vertices.values[:, MOVES:YIELDS].copy()
        free = nothing_held(holding)
        known = self._solve(table, vertices, free, t)
        if known is None:
            return
        changes = vertices.values[:, MOVES:YIELDS] - before
        call(give_to_vertices, scene.frame, grid.field, vertices.keys, changes, t.dt)
        call(book_held, holding, grid.field, vertices, ledger)
        if grid.slab.layers and grid.slab.lower is None:
            encounters, _, responses = known
            if len(self._mirrors):
                call(book_mirrored, encounters, responses, self._mirrors, ledger)
            call(book_contacts, contact, free, *known, vertices.values, self._walls, ledger)

    def _gather(
        self, grid: Grid, population: Population, holding: Holding
    ) -> tuple[np.ndarray, StartVertices]:
        """All ranks' particles near something, and the vertices of the start that these have."""
        scene, call = self.scene, self.call
        rows = population.order[self._approach.near].astype(np.int64)
        table, supports = np.empty((len(rows), NEAR)), self._supports(len(rows))
        fields = np.array(self.fields or (0,) * self.bodies, np.int64)
        call(
            take_near, self._plain, population.particles, rows, self.groups, fields, scene.begun,
            table,
        )  # fmt: skip
        call(find_supports, scene.shape, scene.frame, HALF, table, START, supports)
        last, step = self._seen
        if len(last) != len(grid.G) // 8:
            last, step = np.full(len(grid.G) // 8, -1, np.int64), 0
        self._seen = Seen(last, step + 1)
        most = supports.at.size
        mine = StartVertices(np.empty(most, np.int64), np.empty((most, STARTED)))
        found = call(
            take_vertices, holding, grid.field, table, supports, self._mirrors, self._seen, mine
        )
        parts = (table, mine.keys[:found].copy(), mine.values[:found].copy())
        every = self.comm.allgather(parts)
        table, keys, values = (np.concatenate(each) for each in zip(*every, strict=True))
        return table, StartVertices(keys, values)

    def _solve(self, table: np.ndarray, vertices: StartVertices, free: Holding, t: Step) -> Any:
        """Find the impulses; `vertices` gets the velocities after them.

        Returns the pairs, those that lie too deep to act, and the responses of the first; None
        where nothing meets.
        """
        scene, contact, call = self.scene, self._contact, self.call
        shape, frame = scene.shape, scene.frame
        now, start = self._supports(len(table)), self._supports(len(table))
        call(find_supports, shape, frame, HALF, table, PLACE, now)
        present = self._sum(table, now)
        capacity = 4 * len(present.keys)
        while True:
            encounters = Encounters.empty(capacity)
            pairs, deep = call(
                find_encounters, contact, frame, self._every_face, self._walls, present, t.dt,
                encounters,
            )  # fmt: skip
            if pairs + deep <= capacity:
                break
            capacity = pairs + deep
        if pairs == 0:
            self.sweeps = 0
            return None
        deeper = encounters.between(capacity - deep, capacity)
        encounters = encounters.between(0, pairs)
        call(find_supports, shape, frame, HALF, table, START, start)
        hashes, values = room_for(len(vertices.keys)), vertices.values
        call(number_keys, vertices.keys, hashes)
        mirrors, fields = self._mirrors, 1 + max(self.fields, default=0)
        call(find_vertices, frame, table, start, mirrors, fields, hashes)
        responses = call(
            find_responses, table, now, start, mirrors, encounters, present.sums, values
        )
        self.sweeps = call(
            solve_impulses, contact, free, encounters, responses, values, *self._accuracy
        )
        return encounters, deeper, responses

    def _sum(self, table: np.ndarray, now: Supports) -> Present:
        """The groups' sums at the vertices; `now` are the particles' supports there."""
        most, low = now.at.size, now.first.min(axis=0)
        extent = now.first.max(axis=0) - low + self.scene.vertices
        present = Present(
            low, extent, 1 + int(self.groups.max()), np.empty(most, np.int64),
            np.empty((most, SUMMED)), np.empty(0, np.int64),
        )  # fmt: skip
        found = self.call(sum_present, self.scene.frame, table, now, room_for(most), present)
        keys, sums = present.keys[:found], present.sums[:found]
        return present._replace(keys=keys, sums=sums, order=np.argsort(keys, kind="stable"))

    def _supports(self, count: int) -> Supports:
        """Storage for the supports of `count` particles."""
        return Supports.empty(count, self._local)


def plain(scene: Scene) -> Setting:
    """The scene for kernels that take particles where they are, and need no materials."""
    return scene.setting.without_materials()._replace(frame=scene.frame)


def mirrors_of(scene: Scene) -> np.ndarray:
    """Axis, side, vertex number and face of the walls that reflect, (n, 4) int64."""
    frame = scene.frame
    rows = [
        (each.axis, each.side, frame.ghost + (each.side > 0) * frame.cells[each.axis], each.number)
        for each in scene.mirrors
    ]
    return np.array(rows, np.int64).reshape(-1, 4)


def nothing_held(holding: Holding) -> Holding:
    """The holding for the law of contact: none, as held vertices have no mobility."""
    forcing = holding.forcing._replace(marked=(), clearances=())
    return holding._replace(faces=(), forcing=forcing)
