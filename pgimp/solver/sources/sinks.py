"""Sinks: particles that come into a region of `outflow` are taken out when a step ends."""

from __future__ import annotations

import numpy as np

from pgimp.case.outflow import sinks
from pgimp.geometry.regions.base import Region
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.order.sinks import find_in_box
from pgimp.kernels.sums.sums import layer_sums
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import StepPart

_NONE = np.empty(0, np.int32)


class Sinks(StepPart):
    """The sinks of a scene.

    Particles are looked at in the box around a region, and the region is asked of these alone.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        regions: list[Region] = [sink.region for sink in sinks(scene.case.outflow).values()]
        boxes = [np.array(region.bounds()) for region in regions]
        self._each = [(each, *box) for each, box in zip(regions, boxes, strict=True)]

    def change_particles(self, rank: RankState, t: Step) -> None:
        """Take out what is inside: book it in the sums of its layer, and free its rows.

        Sums are in canonical order, so that the ledger has the same bits on any number of ranks.
        """
        if rank.failed:
            return
        offsets = self._inside(rank)
        if not needed(len(offsets)):
            return
        population = rank.population
        rows = population.order[offsets]
        order = Order(rows, np.searchsorted(offsets, population.start))
        escaped = rank.ledger.escaped[: rank.slab.layers]
        layer_sums(self.scene.setting.without_shape(), population.columns, order, escaped)
        population.free_later(rows)
        population.restore_order(offsets, _NONE)

    def _inside(self, rank: RankState) -> np.ndarray:
        """Offsets of the particles in any sink, ascending; of bodies that may lose particles."""
        population, p, found = rank.population, rank.population.columns, [_NONE]
        for region, low, high in self._each:
            count = rank.call(find_in_box, population.order, p.x, low, high, population.changed)
            if count:
                offsets = population.changed[:count].copy()
                inside = region.contains(p.x[population.order[offsets]])
                found.append(offsets[inside])
        offsets = np.unique(np.concatenate(found)) if len(found) > 1 else _NONE
        if len(offsets) and self.scene.settings.mixed:
            lagrangian = self.scene.settings.lagrangian[p.body[population.order[offsets]]]
            offsets = offsets[~lagrangian]
        return offsets


def sinks_of(scene: Scene, _: Communicator, __: Sinks | None = None) -> Sinks | None:
    """Return the sinks of a scene, None without any."""
    return Sinks(scene) if sinks(scene.case.outflow) else None
