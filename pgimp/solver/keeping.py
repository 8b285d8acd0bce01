"""Rigid bodies that hold particles out: where they are at a step's end, and what they get."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.ledger import TOOL_WORK, Ledger
from pgimp.kernels.particles import Particles
from pgimp.kernels.toolhold import Keepers, count_near
from pgimp.kernels.tools import Tools
from pgimp.scene.scene import Scene
from pgimp.solver.clock import Step
from pgimp.solver.freebodies import FreeBodies

#: Depth in a rigid body, in cells, from which a particle counts as inside; up to which the place of
#: a cut particle may lie in a body that its material does not reach.
QUARTER, CUT = 0.25, 0.2


class Keeping:
    """The rigid bodies of a scene that hold particles out, on one rank.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.
    free : FreeBodies or None
        Those that move freely.
    layers : int
        Layers of the rank.
    """

    def __init__(self, scene: Scene, comm: Any, free: FreeBodies | None, layers: int) -> None:
        self.scene, self.comm, self.free = scene, comm, free
        self._impulses = np.zeros((layers, len(scene.tools), 6))
        self._yields = np.zeros((len(scene.tools), 6, 6))
        self._kept: Any = ()
        self._call = Bound()

    def at(self, t: Step, particles: Particles, rows: np.ndarray) -> Any:
        """Return what holds particles out at the end of a step; () where nothing does; collective.

        Parameters
        ----------
        t : Step
            The step.
        particles, rows : Particles, (n,) int32
            The rank's particles, before they move.
        """
        scene, free = self.scene, self.free
        if not scene.tools or not scene.pairs or (scene.initial and not scene.mixed):
            return ()
        if not self._kept or scene.tools.move:
            tools = scene.tools.after(t.end, free.states if free else None)
            if free:
                free.set_yields(self._yields, self._near(tools, particles, rows))
            most = CUT * min(scene.frame.cell)
            self._kept = Keepers(tools, scene.pairs, self._yields, self._impulses, most)
        return self._kept

    def _near(self, tools: Tools, particles: Particles, rows: np.ndarray) -> np.ndarray:
        """Bounds of the mass that each body may hold in a step, the same on any number of ranks."""
        counts, most = np.zeros(len(tools.motion), np.int64), np.zeros(len(tools.motion))
        cell = max(self.scene.frame.cell)
        self._call(count_near, tools, particles, rows, 2.0 * cell, counts, most)
        if self.comm.size > 1:
            every = np.array(self.comm.allgather((counts, most)))
            counts, most = every[:, 0].sum(axis=0), every[:, 1].max(axis=0)
        return counts * most

    def finish(self, ledger: Ledger, first: int) -> None:
        """Give free bodies what they got from the particles that they held; collective.

        Parameters
        ----------
        ledger : Ledger
            Of the rank; the work of these bodies is booked in the domain's first layer.
        first : int
            Number of the rank's first layer.
        """
        if not self.free or not self._kept:
            return
        numbers = self.free.numbers
        planes = self.scene.frame.vertices[0]
        every = np.zeros((planes, len(numbers), 6))
        every[first : first + len(self._impulses)] = self._impulses[:, numbers]
        self._impulses.fill(0.0)
        if self.comm.size > 1:
            found = np.empty_like(every)
            self.comm.Allreduce(every, found)  # a layer has but one rank: no sum is rounded
            every = found
        work = self.free.push(np.add.reduce(every, axis=0))
        if self.comm.rank == 0 and len(ledger.work):
            ledger.work[0] += sum(work)
            ledger.tools[0, numbers, TOOL_WORK] += work
