"""Particles of bodies in the initial configuration that are near possible contact partners."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.decomposition.population import Population
from pgimp.kernels.encounters import SeparatingWalls
from pgimp.kernels.tools import LEAST, MOST
from pgimp.physics.contact import Pairs
from pgimp.scene.scene import Scene
from pgimp.solver.bonds import acting
from pgimp.solver.clock import Step

#: Cells by which particles may come nearer to something before the next search; the most steps
#: until then.
MARGIN, LONGEST = 1.0, 16


def reach(scene: Scene) -> np.ndarray:
    """Cells, by direction, from a particle to the farthest vertex that it has weight on."""
    return 1.0 + np.array(scene.shape.half)


class Approach:
    """The particles of a rank that are near other bodies, rigid bodies or walls that let go.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.
    pairs : Pairs
        The bodies that act on each other.
    walls : SeparatingWalls
        The walls that let go.

    Attributes
    ----------
    near : (n,) int64
        Their places in the canonical order.
    any : bool
        Whether there are such particles on any rank.
    """

    def __init__(self, scene: Scene, comm: Any, pairs: Pairs, walls: SeparatingWalls) -> None:
        self.scene, self.comm, self.pairs, self.walls = scene, comm, pairs, walls
        self.near = np.empty(0, np.int64)
        self.any = False
        self._pause = 0
        #: The groups that meet there, () if all do, and the ends of the region, in cells.
        self._regions: list[tuple[Any, np.ndarray, np.ndarray]] = []

    def forget(self) -> None:
        """Search all particles again in the next step: they have changed, or their bodies have."""
        self._pause = 0

    def follow(
        self, population: Population, groups: np.ndarray, tools: Any, t: Step, rate: float = 0.0
    ) -> None:
        """Search all particles in a step, if some may have come near by then; collective.

        Parameters
        ----------
        population : Population
            The particles.
        groups : (bodies,) int64
            The groups of bonded bodies.
        tools : Tools or ()
            The rigid bodies, in place.
        t : Step
            The step.
        rate : float
            Cells that rigid bodies that move freely cross in a unit of time.
        """
        looked = self._pause == 0
        if looked:
            self._look(population, groups, tools, t, rate)
        self._pause -= 1
        if looked or self.scene.mixed:  # others keep their places
            self._select(population, groups)

    def _look(
        self, population: Population, groups: np.ndarray, tools: Any, t: Step, rate: float
    ) -> None:
        """Find the particles near something, and the steps for which this holds; collective."""
        scene, frame, p = self.scene, self.scene.frame, population.particles
        order = population.order
        x = (p.x[order] - np.array(frame.origin)) * np.array(frame.inverse)
        group = groups[p.body[order]]
        count = 1 + int(groups.max())
        boxes = np.full((2, count, scene.dimension), np.inf)
        boxes[1] = -np.inf
        np.minimum.at(boxes[0], group, x)
        np.maximum.at(boxes[1], group, x)
        speed = float(np.abs(p.v[order] * np.array(frame.inverse)).max(initial=0.0))
        every = self.comm.allgather((boxes, speed))
        low = np.min([each[0][0] for each in every], axis=0)
        high = np.max([each[0][1] for each in every], axis=0)
        speed = max(max(each[1] for each in every), scene.tools.rate, rate)
        travel = speed * t.dt
        self._pause = max(1, min(LONGEST, int(0.4 * MARGIN / travel))) if travel > 0.0 else LONGEST
        away = reach(scene) + MARGIN
        self._regions = []
        for a, b in acting(self.pairs, groups, len(groups)):
            first = np.maximum(low[a], low[b]) - 2.0 * away
            last = np.minimum(high[a], high[b]) + 2.0 * away
            if (first <= last).all():
                self._regions.append(((a, b), first, last))
        for row in tools.about if tools else ():
            first = row[LEAST : LEAST + scene.dimension] - frame.ghost - away
            last = row[MOST : MOST + scene.dimension] - frame.ghost + away
            self._regions.append(((), first, last))
        for axis, side, end in self.walls.rows:
            ends = np.full((2, scene.dimension), [[-np.inf], [np.inf]])
            ends[int(side < 0), axis] = end - frame.ghost - side * (1.0 + away[axis])
            self._regions.append(((), *ends))

    def _select(self, population: Population, groups: np.ndarray) -> None:
        """Find the particles in the regions where something may be met; collective."""
        frame, p = self.scene.frame, population.particles
        order = population.order
        x = (p.x[order] - np.array(frame.origin)) * np.array(frame.inverse)
        group, near = groups[p.body[order]], np.zeros(len(order), bool)
        for parties, first, last in self._regions:
            inside = ((x >= first) & (x <= last)).all(axis=1)
            near |= inside & np.isin(group, parties) if parties else inside
        self.near = np.flatnonzero(near)
        self.any = bool(sum(self.comm.allgather(len(self.near))))
