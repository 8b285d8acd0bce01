"""Steps with sums of the filling, where bodies flow; see `pgimp.kernels.flows.filling`."""

from __future__ import annotations

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Forcing, Order
from pgimp.kernels.data.frame import Window
from pgimp.kernels.flows.calming import Calming
from pgimp.kernels.flows.filling import REFLECTED, VOLUME, Filling, FillingSums, find_filling
from pgimp.kernels.grid.image_values import copy_values, fold_values
from pgimp.mpi.communicator import Communicator
from pgimp.scene.flows import SceneFlows
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertex_sums import VertexSums
from pgimp.solver.vertices import StepPart

#: Steps from one shift to the next, as each costs a sum over all particles.
EVERY = 8

#: eps and delta of `pgimp.kernels.flows.filling`. The noise that delta removes arises from motion,
#: at each crossing of cells. With 0.0025 waves half a cell high keep 0.32 of their height in ten
#: periods, without 0.67. With 0.02 water that swings under a sudden gravity begins to slosh.
SHIFT, RELAX = 0.02, 0.001

#: Rate at which null modes of velocity fade, over c/h: in some hundreds of steps.
CALM = 0.002

#: eps without weight anywhere: enclosed fluid then keeps its pressure to some per cent.
WEIGHTLESS = 0.01


class Flows(StepPart):
    """The filling of a rank's vertices.

    Parameters
    ----------
    scene : Scene
        The scene, in which bodies flow.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        assert scene.interaction.flows is not None
        self.scene, self.comm, self.call = scene, comm, Bound()
        self.flows: SceneFlows = scene.interaction.flows
        self.sums = sums_of(self.flows)
        self._sums = VertexSums(scene, comm, self.sums)
        self._idle = idle(self.flows)
        self.shift = WEIGHTLESS if scene.case.gravity is None else SHIFT

    def force_particles(self, rank: RankState, order: Order, t: Step, forcing: Forcing) -> Forcing:
        """See `StepPart.force_particles`; collective."""
        return forcing._replace(filling=self.find(rank, order, t))

    def find(self, rank: RankState, order: Order, t: Step) -> Filling:
        """Find the filling at the step's beginning, when it is due; collective.

        Parameters
        ----------
        rank : RankState
            The rank, whose ledger then starts to sum volumes anew.
        order : Order
            Its particles in the current configuration.
        """
        if t.number % EVERY:
            return self._idle
        grid, particles = rank.grid, rank.up_to_date()
        rank.ledger.filled.fill(0.0)
        flows = self.flows
        self._sums.fit(grid, flows.fields)
        self._sums.add(particles, order, np.arange(grid.planes))
        own, frame = self._sums.grid, self.scene.domain.frame
        self._sums.join()
        for wall in flows.walls:  # volumes beyond walls are pushed to their images
            self.call(fold_values, frame, own.field, wall, 1 << VOLUME, False)
        rigid_bodies, calming = rank.contact.rigid_bodies, self.sums.calming
        self.call(find_filling, frame, own.field, flows.sides, rigid_bodies, flows.fills, calming)
        for wall in reversed(flows.walls):  # nothing is shifted through them
            self.call(copy_values, frame, own.field, wall, REFLECTED)
        rate = EVERY * t.dt * flows.rates
        return Filling(
            True,
            own.window,
            own.G,
            self.shift * rate,
            1.0 - np.exp(-RELAX * rate),
            1.0 - np.exp(-self.shift * rate),
            flows.most,
            flows.gap,
            Calming(flows.calms * (1.0 - np.exp(-CALM * rate))) if flows.calms.any() else (),
        )


def flows_of(scene: Scene, comm: Communicator, _: Flows | None = None) -> Flows | None:
    """Return the filling of a scene's vertices; None where no body flows."""
    return Flows(scene, comm) if scene.interaction.flows else None


def sums_of(flows: SceneFlows) -> FillingSums:
    """The sums of the filling, and of the motion where bodies are calmed."""
    return FillingSums(most=flows.most, calming=Calming(flows.calms) if flows.calms.any() else ())


def idle(flows: SceneFlows) -> Filling:
    """The filling of a step that does not use it."""
    window = Window.over((0, 0, 0), (1, 1, 1), flows.fields)
    zero = np.zeros(len(flows.rates))
    calming = sums_of(flows).calming
    return Filling(False, window, np.zeros(8), zero, zero, zero, flows.most, flows.gap, calming)
