"""Where bodies in the initial configuration meet: each other, rigid bodies, walls that let go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.population import Population
from pgimp.jit.bound import Bound
from pgimp.kernels.accumulated import (
    ENDS,
    PARTNERS,
    RIGID,
    book_contacts,
    find_contacts,
    find_responses,
    settle_contacts,
)
from pgimp.kernels.boxes import grow_boxes
from pgimp.kernels.concepts import Forcing
from pgimp.kernels.contact import Contact
from pgimp.kernels.ledger import CONTACT_AREA, Ledger
from pgimp.kernels.present import (
    FIELD,
    NEAR,
    PLACE,
    START,
    STARTED,
    SUMMED,
    find_starts,
    find_supports,
    give_to_start,
    number_vertices,
    room_for,
    sum_present,
    take_near,
    take_vertices,
)
from pgimp.kernels.tools import LEAST, MOST
from pgimp.mpi.node import Call
from pgimp.scene.scene import Scene
from pgimp.solver.bonds import acting, bonded, with_walls
from pgimp.solver.clock import Step

#: Cells by which particles may come nearer to something until all is looked at anew; the most
#: steps until then.
MARGIN, LONGEST = 1.0, 16

#: The most sweeps over all pairs in a step, and the change of impulses, over the greatest, that is
#: none. A hundred sweeps to 1e-4 find the same motion, and disks that meet then lose more.
SWEEPS, ENOUGH = 30, 1e-3


class PresentMeetings:
    """Contact of bodies in the initial configuration, on one rank.

    Particles that are near something go to all ranks, in canonical order, with the vertices of
    their own grid. All then find the same impulses, and give them to the vertices that they have:
    nothing of it depends on which rank a particle is on, and no step needs more than one exchange.

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
    """

    def __init__(self, scene: Scene, comm: Any) -> None:
        self.scene, self.comm, self.call = scene, comm, Bound()
        self.bodies = len(scene.body_names)
        self.fields: tuple[int, ...] = (0,) * self.bodies if scene.pairs else ()
        self.groups = np.zeros(self.bodies, np.int64)
        self.sweeps = self._pause = self._step = 0
        self._grouped = False
        self._near = np.empty(0, np.int64)
        self._some = False
        self._seen = np.empty(0, np.int64)
        self.pairs = with_walls(scene)
        letting = [(n, face) for n, face in enumerate(scene.faces) if face.condition.approaches]
        ends = [scene.frame.ghost + (f.side > 0) * scene.frame.cells[f.axis] for _, f in letting]
        self._numbers = np.array([n for n, _ in letting], np.int64)
        self._walls = np.array(
            [(face.axis, face.side, end) for (_, face), end in zip(letting, ends, strict=True)],
            np.int64,
        ).reshape(-1, 3)
        self._first_wall = self.bodies + len(scene.tools)
        tools: Any = scene.tools.in_planes(1) if scene.tools else ()
        self._contact = Contact.empty(
            self.pairs, np.empty(0), 1, self.bodies + 1, len(scene.faces), tools
        )
        self._unbooked = np.zeros((len(scene.faces), 3))
        self._every_face = scene.standing_faces()

    def forget(self) -> None:
        """Look at all particles anew in the next step: there are others, or of other bodies."""
        self._pause = 0

    def group(self, grid: Grid, population: Population) -> None:
        """Find out, once, which bodies are bonded at the start; collective."""
        if self._grouped:
            return
        self._grouped = True
        scene = self.scene
        if scene.pairs is None:
            return
        p, order = population.particles, population.order
        boxes = np.full((2, self.bodies, scene.dimension), np.inf)
        boxes[1] = -np.inf
        grow_boxes(scene.frame, p._replace(x=p.origin), order, boxes)
        every = np.array(self.comm.allgather(boxes))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        self.fields, self.groups = bonded(self.pairs, low, high, 2.0 * self._reach())
        if max(self.fields) > 0 and self.fields != grid.fields:
            grid.fields = self.fields
            grid.store(grid.base)

    def exchange(
        self, grid: Grid, population: Population, ledger: Ledger, t: Step, forcing: Forcing,
        faces: Any,
    ) -> None:  # fmt: skip
        """Let all that meets exchange impulses, after the update of momentum; collective.

        Velocities and accelerations of the vertices change. What bodies meet is at present; what
        holds the vertices of the start, `faces` and constraints, is that of the start.
        """
        scene = self.scene
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        if scene.tools:
            scene.tools.at(t.start, t.end)  # in place
        if self._pause == 0:
            self._look(population, t)
        self._pause -= 1
        if not self._some:
            return
        frame, shape, call = scene.frame, scene.shape, self.call
        vertices, D = scene.vertices, scene.dimension
        rows = population.order[self._near].astype(np.int64)
        n = len(rows)
        own = np.empty((n, NEAR))
        fields = np.array(self.fields or (0,) * self.bodies, np.int64)
        call(take_near, frame, population.particles, rows, self.groups, fields, own)
        starts, w, slopes = _supports(n)
        call(find_supports, shape, frame, scene.identity, own, START, starts, w, slopes)
        if len(self._seen) != len(grid.G) // 8:
            self._seen = np.full(len(grid.G) // 8, -1, np.int64)
            self._step = 0
        self._step += 1
        keys, values = np.empty(n * vertices**D, np.int64), np.empty((n * vertices**D, STARTED))
        found = call(
            take_vertices, faces, forcing, frame, vertices, grid.field, population.particles,
            rows, starts, w, self._seen, self._step, self._unbooked, keys, values,
        )  # fmt: skip
        every = self.comm.allgather((own, keys[:found].copy(), values[:found].copy()))
        table = np.concatenate([each[0] for each in every])
        keys = np.concatenate([each[1] for each in every])
        values = np.concatenate([each[2] for each in every])
        before = values[:, 1:4].copy()
        known = self._solve(table, keys, values, t, forcing, 1 + max(fields))
        if known is None:
            return
        call(give_to_start, frame, grid.field, keys, values[:, 1:4] - before, t.dt)
        if grid.slab.layers and grid.slab.below is None:
            call(
                book_contacts, self._contact, frame, _unheld(forcing), *known, values,
                self._first_wall, self._numbers, ledger,
            )  # fmt: skip

    def _solve(
        self, table: np.ndarray, keys: np.ndarray, values: np.ndarray, t: Step, forcing: Forcing,
        count: int,
    ) -> Any:  # fmt: skip
        """Find the impulses; `values` has the velocities then. None where nothing meets."""
        scene, call = self.scene, self.call
        frame, shape, D, vertices = scene.frame, scene.shape, scene.dimension, scene.vertices
        n, groups, free = len(table), 1 + int(self.groups.max()), _unheld(forcing)
        base, w, g = _supports(n)
        call(find_supports, shape, frame, scene.identity, table, PLACE, base, w, g)
        low = base.min(axis=0)
        extent = base.max(axis=0) - low + vertices
        most = n * vertices**D
        at, sums = np.empty((n, vertices**D), np.int64), np.empty((most, SUMMED))
        found_keys = np.empty(most, np.int64)
        found = call(
            sum_present, frame, vertices, table, base, w, g, low, extent, groups, room_for(most),
            at, found_keys, sums,
        )  # fmt: skip
        order, sums = np.argsort(found_keys[:found], kind="stable"), sums[:found]
        room = 4 * found
        places = np.empty(max(groups, 1), np.int64)
        while True:
            ends = np.empty((room, ENDS), np.int64)
            partners, rigid = np.empty((room, PARTNERS)), np.empty((room, RIGID))
            pairs = call(
                find_contacts, self._contact, frame, self._every_face, self._walls,
                self._first_wall, low, extent, groups, order, found_keys, sums, places, t.dt,
                ends, partners, rigid,
            )  # fmt: skip
            if pairs <= room:
                break
            room = pairs
        if pairs == 0:
            self.sweeps = 0
            return None
        ends, partners, rigid = ends[:pairs], partners[:pairs], rigid[:pairs]
        starts, w0, slopes = _supports(n)
        call(find_supports, shape, frame, scene.identity, table, START, starts, w0, slopes)
        hashes, at0 = room_for(len(keys)), np.empty((n, vertices**D), np.int64)
        call(number_vertices, keys, hashes)
        call(
            find_starts, starts, w0, table[:, FIELD].copy(), frame, vertices, count, hashes, at0
        )
        rows = call(find_responses, table, vertices, D, w, w0, at, at0, ends, sums, values)
        self.sweeps = call(
            settle_contacts, self._contact, frame, free, ends, partners, rigid, rows, values,
            SWEEPS, ENOUGH,
        )  # fmt: skip
        return ends, partners, rigid, rows

    def _reach(self) -> np.ndarray:
        """Cells, by direction, from a particle to the farthest vertex that it has weight on."""
        return 1.0 + np.array(self.scene.shape.half)

    def _look(self, population: Population, t: Step) -> None:
        """Find the particles near something, and for how many steps these are all; collective."""
        scene, frame, p = self.scene, self.scene.frame, population.particles
        order = population.order
        x = (p.x[order] - np.array(frame.origin)) * np.array(frame.inverse)
        group = self.groups[p.body[order]]
        count = 1 + int(self.groups.max())
        boxes = np.full((2, count, scene.dimension), np.inf)
        boxes[1] = -np.inf
        np.minimum.at(boxes[0], group, x)
        np.maximum.at(boxes[1], group, x)
        speed = float(np.abs(p.v[order] * np.array(frame.inverse)).max(initial=0.0))
        every = self.comm.allgather((boxes, speed))
        low = np.min([each[0][0] for each in every], axis=0)
        high = np.max([each[0][1] for each in every], axis=0)
        speed = max(max(each[1] for each in every), scene.tools.rate)
        way = speed * t.dt
        self._pause = max(1, min(LONGEST, int(0.4 * MARGIN / way))) if way > 0.0 else LONGEST
        reach = self._reach() + MARGIN
        near = np.zeros(len(order), bool)
        for a, b in acting(self.pairs, self.groups, self.bodies):
            first = np.maximum(low[a], low[b]) - 2.0 * reach
            last = np.minimum(high[a], high[b]) + 2.0 * reach
            if (first <= last).all():
                near |= ((group == a) | (group == b)) & ((x >= first) & (x <= last)).all(axis=1)
        if scene.tools:
            about = self._contact.tools.about
            D = scene.dimension
            for row in about:
                first = row[LEAST : LEAST + D] - frame.ghost - reach
                last = row[MOST : MOST + D] - frame.ghost + reach
                near |= ((x >= first) & (x <= last)).all(axis=1)
        for axis, side, end in self._walls:
            near |= (x[:, axis] - (end - frame.ghost)) * side >= -1.0 - reach[axis]
        self._near = np.flatnonzero(near)
        self._some = bool(sum(self.comm.allgather(len(self._near))))


def calls(
    scene: Scene, grid: Grid, particles: Any, forcing: Forcing, faces: Any, ledger: Ledger
) -> Iterator[Call]:
    """Calls of the kernels on nothing, so that they are compiled; see `pgimp.solver.warmup`."""
    tools: Any = scene.tools.in_planes(1) if scene.tools else ()
    pairs, count = with_walls(scene), len(scene.faces)
    contact = Contact.empty(pairs, np.empty(0), 1, 2, count, tools)
    frame, shape, D, vertices = scene.frame, scene.shape, scene.dimension, scene.vertices
    none, free, standing = np.empty(0, np.int64), _unheld(forcing), scene.standing_faces()
    table, (base, w, g) = np.empty((0, NEAR)), _supports(0)
    values, at = np.empty((0, STARTED)), np.empty((0, vertices**D), np.int64)
    ends, partners = np.empty((0, ENDS), np.int64), np.empty((0, PARTNERS))
    sums, rigid = np.empty((0, SUMMED)), np.empty((0, RIGID))
    rows = (none, np.zeros(1, np.int64), none, np.empty(0), np.empty((0, 3)))
    low = np.zeros(3, np.int64)
    yield 0.5, lambda: take_near(frame, particles, none, none, none, table)
    yield 1.0, lambda: find_supports(shape, frame, scene.identity, table, PLACE, base, w, g)
    yield 3.0, lambda: take_vertices(
        faces, forcing, frame, vertices, grid.field, particles, none, base, w, none, 0,
        np.zeros((count, 3)), none, values,
    )
    yield 1.0, lambda: sum_present(
        frame, vertices, table, base, w, g, low, low, 1, room_for(0), at, none, sums
    )
    yield 4.0, lambda: find_contacts(
        contact, frame, standing, np.empty((0, 3), np.int64), 0, low, low, 1, none, none, sums,
        none, 1.0, ends, partners, rigid,
    )
    yield 0.2, lambda: number_vertices(none, room_for(0))
    yield 0.3, lambda: find_starts(
        base, w, np.empty(0), frame, vertices, 1, room_for(0), at
    )
    yield 2.0, lambda: find_responses(table, vertices, D, w, w, at, at, ends, sums, values)
    yield 2.0, lambda: settle_contacts(
        contact, frame, free, ends, partners, rigid, rows, values, 1, ENOUGH
    )
    yield 0.3, lambda: give_to_start(frame, grid.field, none, np.empty((0, 3)), 1.0)
    yield 2.0, lambda: book_contacts(
        contact, frame, free, ends, partners, rigid, rows, values, 0, none, ledger
    )


def _unheld(forcing: Forcing) -> Forcing:
    """What acts, for the law of contact: vertices that are held have no mobility, which is all."""
    return forcing._replace(marked=(), clearances=())


def _supports(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Room for what `find_supports` sets."""
    return np.empty((n, 3), np.int64), np.empty((n, 3, 4)), np.empty((n, 3, 4))
