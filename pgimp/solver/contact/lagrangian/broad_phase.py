"""Broad phase: particles of bodies in the initial configuration near possible partners."""

from __future__ import annotations

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.population import Population
from pgimp.geometry.sweep import close_pairs
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.broad_phase import (
    Regions,
    find_near,
    greatest_speed,
    grow_boxes,
    mark_blocks,
    widen_marks,
)
from pgimp.kernels.contact.lagrangian.filled import NEVER
from pgimp.kernels.contact.lagrangian.pairs import SeparatingWalls
from pgimp.kernels.contact.lagrangian.travel import Tracked, greatest_travel
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY, VertexMotion
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.physics.contact.pairs import Pairs
from pgimp.physics.shapes.stretch import LARGEST
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.bonds import interactions
from pgimp.solver.contact.lagrangian.known import lost_body
from pgimp.solver.contact.lagrangian.messages import gathered, greatest, united
from pgimp.solver.time.clock import Step

#: Cells by which particles may approach a partner before the next search; the most steps until
#: then.
MARGIN, LONGEST = 1.0, 16

#: The fewest further steps for which a search is kept.
SHORTEST = 4

#: Most blocks of a region; the blocks of a larger one have sides of several cells.
BLOCKS = 1 << 20


def reach(scene: Scene, largest: bool = False) -> np.ndarray:
    """Cells, by direction, from a particle to the farthest vertex with weight.

    Initially, or for a particle as `largest` as it can become.
    """
    half = np.array(scene.settings.uncut.half)
    if scene.settings.exact_surfaces.any():  # from the centroid of a part of a box
        half = 2.0 * half
    return 1.0 + (np.maximum(half, LARGEST) if largest else half)


def no_regions(D: int) -> Regions:
    """Return an empty set of regions."""
    none, marks = np.empty(0, np.int64), np.empty(0, np.uint8)
    return Regions(
        np.empty((0, 2, D)),
        np.empty((0, 2), np.int64),
        np.empty((0, D), np.int64),
        none,
        none,
        marks,
        np.zeros(2, np.int64),
        none,
    )


class BroadPhase:
    """The particles of a rank that are near other bodies, rigid bodies or unilateral walls.

    Parameters
    ----------
    pairs : Pairs
        The pairs of bodies in contact.
    walls : SeparatingWalls
        The unilateral walls.

    Attributes
    ----------
    near : (n,) int64
        Their offsets in the canonical order.
    any : bool
        Whether any rank has such particles.
    travel : float
        Greatest distance in cells by which anything moved in the step of the last search.
    lost : tuple of 2 str or None
        See `lost_body`.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, pairs: Pairs, walls: SeparatingWalls
    ) -> None:
        self.scene, self.comm, self.pairs, self.walls = scene, comm, pairs, walls
        self.near = self._storage = np.empty(0, np.int64)
        self.any, self.travel = False, 0.0
        self.lost: tuple[str, str] | None = None
        self.call = Bound()
        self._pause = 0
        self._acting: tuple[np.ndarray, np.ndarray] | None = None
        self._regions = no_regions(scene.dimension)
        self._tracked: Tracked | None = None
        self._window: object = None
        self._rigid_travel = 0.0

    def restart(self) -> None:
        """Search all particles again in the next step: they have changed, or their bodies have."""
        self._pause, self._tracked = 0, None

    def update(
        self,
        population: Population,
        groups: np.ndarray,
        rigid_bodies: AnyRigidBodies,
        t: Step,
        rate: float = 0.0,
        grid: Grid | None = None,
    ) -> bool:
        """Search all particles in a step, if some may have come near by then; collective.

        Parameters
        ----------
        population : Population
            The particles.
        groups : (bodies,) int64
            The groups of bonded bodies.
        rigid_bodies : RigidBodies or ()
            The rigid bodies at their positions.
        rate : float
            Speed of free rigid bodies in cells per unit of time.
        grid : Grid or None
            Its vertices tell how far bodies have moved, if all are in the initial configuration.

        Returns
        -------
        bool
            Whether they were searched.
        """
        rate = max(self.scene.interaction.rigid_bodies.rate, rate)
        looked = self._pause == 0 and not self._lasts(grid, t, rate)
        if looked:
            self._look(population, groups, rigid_bodies, t, rate)
            self._track(grid)
        self._pause -= 1
        self._rigid_travel += rate * t.dt
        if looked or self.scene.settings.mixed:  # other particles keep their offsets
            self._select(population, groups)
        return looked

    def _track(self, grid: Grid | None) -> None:
        """Watch all vertices from now on, until the next search."""
        self._rigid_travel = 0.0
        if grid is None or self.scene.settings.mixed:
            return
        motion = grid.field.motion
        assert isinstance(motion, VertexMotion)
        self._window, values = grid.window, motion.values.reshape(-1, RECORD)
        records = np.flatnonzero(values[:, KEPT_MASS] > 0.0)
        before = values[records, DISPLACEMENT : DISPLACEMENT + 3]
        self._tracked = Tracked(records * RECORD, before)

    def _lasts(self, grid: Grid | None, t: Step, rate: float) -> bool:
        """Whether the last search holds for further steps, as little has moved; collective."""
        tracked = self._tracked
        if grid is None or tracked is None:
            return False
        moved, speed = np.inf, np.inf
        if self._window is grid.window:
            frame, field = self.scene.domain.frame, grid.field
            assert isinstance(field.motion, VertexMotion)
            moved = float(self.call(greatest_travel, frame, field, tracked))
            v = field.motion.values.reshape(-1, RECORD)[tracked.records // RECORD, KEPT_VELOCITY:]
            away = np.abs(v[:, : len(frame.inverse)]).max(axis=0, initial=0.0)
            speed = float((away * frame.inverse).max())
        moved = max(greatest(self.comm, moved), self._rigid_travel)
        travel = max(greatest(self.comm, speed), rate) * t.dt
        left = 0.4 * MARGIN - moved
        steps = LONGEST if travel * LONGEST <= left else int(max(left, 0.0) / travel)
        if steps < SHORTEST:
            return False
        self._pause = steps
        return True

    def _look(
        self,
        population: Population,
        groups: np.ndarray,
        rigid_bodies: AnyRigidBodies,
        t: Step,
        rate: float,
    ) -> None:
        """Find the regions of possible contact, and the steps for which they hold; collective."""
        scene, frame, p = self.scene, self.scene.domain.frame, population.up_to_date()
        order, D = population.order, self.scene.dimension
        boxes = np.full((2, len(groups), D), np.inf)
        boxes[1] = -np.inf
        self.call(grow_boxes, frame, p, order, boxes)
        speed = float(self.call(greatest_speed, frame, p, order))
        low, high = np.full((2, 1 + int(groups.max()), D), [[[np.inf]], [[-np.inf]]])
        for boxes in gathered(self.comm, boxes):
            np.minimum.at(low, groups, boxes[0])
            np.maximum.at(high, groups, boxes[1])
        speed = max(greatest(self.comm, speed), scene.interaction.rigid_bodies.rate, rate)
        self.travel = travel = speed * t.dt
        self._pause = max(1, min(LONGEST, int(0.4 * MARGIN / travel))) if travel > 0.0 else LONGEST
        away = reach(scene, scene.settings.follows) + MARGIN
        pairs = self._meeting(low, high, groups, 4.0 * away)
        first = np.maximum(low[pairs[:, 0]], low[pairs[:, 1]]) - 2.0 * away
        last = np.minimum(high[pairs[:, 0]], high[pairs[:, 1]]) + 2.0 * away
        meet = (first <= last).all(axis=1)
        ends = [*np.stack([first[meet], last[meet]], axis=1)]
        around = low - away, high + away
        self.lost = lost_body(scene, self.pairs, groups, around, rigid_bodies)
        for row in rigid_bodies.lattice if rigid_bodies else ():
            first, last = row["least"][:D] - away, row["most"][:D] + away
            ends.append(np.array((first - frame.ghost, last - frame.ghost)))
        for axis, side, end, *_ in self.walls.planes.tolist():
            lattice = np.full((2, D), [[-np.inf], [np.inf]])
            lattice[int(side < 0), axis] = end - frame.ghost - side * (1.0 + away[axis])
            ends.append(lattice)
        boxes = np.array(ends).reshape(-1, 2, D)
        self._regions = self._marked(population, groups, boxes, pairs[meet])

    def _meeting(
        self, low: np.ndarray, high: np.ndarray, groups: np.ndarray, wide: np.ndarray
    ) -> np.ndarray:
        """Pairs of groups that act on each other and may be within a distance, (n, 2) int64."""
        if self._acting is None or self._acting[0] is not groups:
            self._acting = groups, interactions(self.pairs, groups, 0)
        pairs = close_pairs(low, high, wide)
        return pairs[self._acting[1][pairs[:, 0], pairs[:, 1]] != NEVER]

    def _marked(
        self, population: Population, groups: np.ndarray, ends: np.ndarray, meeting: np.ndarray
    ) -> Regions:
        """Regions with marks near either of their two groups; collective."""
        count, n, D = len(ends), len(meeting), self.scene.dimension
        blocks, size = np.ones((count, D), np.int64), np.zeros(count, np.int64)
        size[:n] = 1
        left = np.arange(n)
        while len(left):
            wide = np.ceil((ends[left, 1] - ends[left, 0]) / size[left, None])
            blocks[left] = wide
            left = left[wide.prod(axis=1) > BLOCKS]
            size[left] *= 2
        first = np.concatenate([[0], np.cumsum(blocks[:n].prod(axis=1))])
        pairs = np.full((count, 2), -1, np.int64)
        pairs[:n] = meeting
        marks = np.zeros(first[-1], np.uint8)
        places = np.concatenate([first[:-1], np.zeros(count - n, np.int64)])
        listed = _by_group(pairs, n, 1 + int(groups.max()))
        regions = Regions(ends, pairs, blocks, size, places, marks, *listed)
        if not needed(n):
            return regions
        order = population.order
        self.call(
            mark_blocks, self.scene.domain.frame, population.up_to_date(), order, groups, regions
        )
        marks[:] = united(self.comm, marks)
        far = 2.0 * reach(self.scene, self.scene.settings.follows) + MARGIN
        counts = np.ceil(far / size[:n, None]).astype(np.int64)
        line = np.empty(int(blocks[:n].max(initial=1)), np.uint8)
        self.call(widen_marks, regions, counts, line)
        return regions

    def _select(self, population: Population, groups: np.ndarray) -> None:
        """Find the particles in the regions of possible contact; collective."""
        order = population.order
        if len(self._storage) < len(order):
            self._storage = np.empty(len(order), np.int64)
        found = self.call(
            find_near,
            self.scene.domain.frame,
            population.up_to_date(),
            order,
            groups,
            self._regions,
            self._storage,
        )
        self.near = self._storage[:found]
        self.any = greatest(self.comm, found) > 0


def _by_group(pairs: np.ndarray, meeting: int, groups: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the regions of each group begin in a list, and the list.

    The first regions are for two groups each, the others for any.
    """
    others = np.arange(meeting, len(pairs))
    own = np.concatenate([pairs[:meeting].T.ravel(), np.repeat(np.arange(groups), len(others))])
    regions = np.concatenate([np.tile(np.arange(meeting), 2), np.tile(others, groups)])
    start = np.concatenate([[0], np.cumsum(np.bincount(own, minlength=groups))])
    return start, regions[np.argsort(own, kind="stable")]
