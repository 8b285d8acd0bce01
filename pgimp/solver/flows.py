"""When the filling of vertices is summed where bodies flow; see `pgimp.kernels.grid.filling`."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.halo import Halo
from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.frame import Window
from pgimp.kernels.grid.calming import Calming
from pgimp.kernels.grid.filling import (
    Filling,
    FillingSums,
    find_filling,
    fold_filling,
    reflect_filling,
)
from pgimp.kernels.transfer.p2g import particles_to_grid
from pgimp.scene.flows import SceneFlows
from pgimp.scene.scene import Scene
from pgimp.solver.clock import Step

#: Steps from one shift to the next, as each costs a sum over all particles.
EVERY = 8

#: eps and delta of `pgimp.kernels.grid.filling`. The noise that delta takes is made of the motion,
#: at each crossing of cells: with 0.0025 waves half a cell high keep 0.32 of their height in ten
#: periods, without 0.67. With 0.02 water that swings under a sudden gravity begins to slosh.
SHIFT, RELAX = 0.02, 0.001

#: Rate at which velocities that no vertex sees fade, over c/h: in some hundreds of steps.
CALM = 0.002

#: eps where nothing has a weight: what is closed in then keeps its pressure to some per cent.
WEIGHTLESS = 0.01


class Flows:
    """The filling of a rank's vertices.

    Parameters
    ----------
    scene : Scene
        The scene, in which bodies flow.
    comm : communicator
        Of all ranks.
    """

    def __init__(self, scene: Scene, comm: Any) -> None:
        assert scene.flows is not None
        self.scene, self.comm, self.call = scene, comm, Bound()
        self.flows: SceneFlows = scene.flows
        self._known: Any = None
        self._halo: Halo | None = None
        self.sums = sums_of(self.flows)
        self._idle = idle(self.flows)
        self.shift = WEIGHTLESS if scene.case.gravity is None else SHIFT

    def find(self, rank: Any, order: Order, t: Step) -> Filling:
        """Find the filling at the step's beginning, when it is due; collective.

        Parameters
        ----------
        rank : Rank
            The rank, whose ledger then starts to sum volumes anew.
        order : Order
            Its particles in the current configuration.
        t : Step
            The step.
        """
        if t.number % EVERY:
            return self._idle
        grid, particles = rank.grid, rank.particles
        rank.ledger.filled.fill(0.0)
        if self._known is not grid.field:
            self._connect(grid)
        own, frame, flows = self._sums, self.scene.frame, self.flows
        own.active.fill(0)
        runs = np.array([[0, grid.slab.layers, 0]])
        self.call(
            particles_to_grid, self.scene.setting.without_materials(), own.field, particles,
            self.sums, order, runs, (),
        )  # fmt: skip
        if self._halo:
            self._halo.proceed(own)
            self._halo.finish(own)
        for wall in flows.walls:
            self.call(fold_filling, frame, own.field, wall)
        self.call(
            find_filling, frame, own.field, flows.sides, rank.tools, flows.fills, self.sums.calming
        )
        for wall in reversed(flows.walls):
            self.call(reflect_filling, frame, own.field, wall)
        rate = EVERY * t.dt * flows.rates
        return Filling(
            True, own.window, own.G, self.shift * rate, 1.0 - np.exp(-RELAX * rate),
            1.0 - np.exp(-self.shift * rate), flows.most, flows.gap,
            Calming(flows.calms * (1.0 - np.exp(-CALM * rate))) if flows.calms.any() else (),
        )  # fmt: skip

    def _connect(self, grid: Grid) -> None:
        """Allocate the sums for the planes of `grid`."""
        if self._halo:
            self._halo.close()
        self._known, scene, slab = grid.field, self.scene, grid.slab
        self._sums = Grid(scene.frame, scene.vertices, slab, grid.lag, self.flows.fields)
        self._sums.store(grid.base)
        self._halo = Halo(self.comm, slab, grid.vertices - 1) if slab.neighbours else None


def sums_of(flows: SceneFlows) -> FillingSums:
    """The sums of the filling, and of the motion where bodies are calmed."""
    return FillingSums(most=flows.most, calming=Calming(flows.calms) if flows.calms.any() else ())


def idle(flows: SceneFlows) -> Filling:
    """The filling of a step that does not use it."""
    window = Window.over((0, 0, 0), (1, 1, 1), flows.fields)
    zero = np.zeros(len(flows.rates))
    calming = sums_of(flows).calming
    return Filling(False, window, np.zeros(8), zero, zero, zero, flows.most, flows.gap, calming)
