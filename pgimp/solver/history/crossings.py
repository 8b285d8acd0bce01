"""What crosses the surfaces of flux gauges in a step: mass and momentum, by layer.

A particle's velocity may have a part finer than a cell, which moves nothing. So a flux is counted
from ways. Sums go layer by layer in canonical order, so that no bit depends on the ranks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.case.gauges import FluxGauge, flux_gauges
from pgimp.kernels.data.arguments import Order
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.history.gauge_forces import chosen, gauge_surface, place_of, sums_by
from pgimp.solver.history.gauge_surfaces import Surface
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart

Array = np.ndarray


class _Near(NamedTuple):
    """Particles near a surface as a step begins: rows, layers, and places with and without turns.

    Without turns a place lies in the domain; with them it does not jump at periodic faces.
    """

    rows: Array
    layer: Array
    place: Array
    unwound: Array


class Crossings(StepPart):
    """Counts of a scene's flux gauges."""

    def __init__(self, gauges: list[FluxGauge]) -> None:
        self._gauges = gauges
        self._near: list[_Near] = []

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """See `StepPart.begin`."""
        population = rank.population
        layers = np.repeat(np.arange(population.layers), np.diff(population.start))
        everything = place_of(rank, population.order)
        self._near = []
        for gauge in self._gauges:
            there = np.flatnonzero(self._surface(rank, gauge).near(everything))
            there = there[chosen(rank, gauge, population.order[there])]
            rows = population.order[there]
            self._near.append(_Near(rows, layers[there], everything[there], _unwound(rank, rows)))

    def complete(self, rank: RankState) -> None:
        """See `StepPart.complete`."""
        particles, D = rank.up_to_date(), rank.scene.dimension
        for k, (gauge, near) in enumerate(zip(self._gauges, self._near, strict=True)):
            way = _unwound(rank, near.rows) - near.unwound
            part = self._surface(rank, gauge).passed(near.place, way)
            mass = (part * particles.m[near.rows])[:, None]
            terms = np.zeros((len(near.rows), 6))
            terms[:, :1], terms[:, 3 : 3 + D] = mass, mass * particles.v[near.rows]
            layers = rank.population.layers
            booked = rank.ledger.crossed[:layers, 2 * k : 2 * k + 2]
            booked += sums_by(near.layer, layers, terms).reshape(layers, 2, 3)

    @staticmethod
    def _surface(rank: RankState, gauge: FluxGauge) -> Surface:
        return gauge_surface(rank.scene, gauge.flux)


def crossings_of(scene: Scene, _: Communicator, __: Crossings | None = None) -> Crossings | None:
    """Return the counts of a scene, None without flux gauges."""
    gauges = flux_gauges(scene.case.gauges)
    return Crossings(list(gauges.values())) if gauges else None


def _unwound(rank: RankState, rows: Array) -> Array:
    """Positions of particles with their turns through periodic faces."""
    particles, periods = rank.up_to_date(), rank.scene.domain.periods
    x = particles.x[rows]
    if particles.winding.shape[1]:
        x = x + particles.winding[rows] * periods
    return x
