"""What gauges measure: forces, fluxes, levels; only as a line is due.

Sums of particles go layer by layer in canonical order, as those of vertices by plane: see
`pgimp.solver.history.gauge_forces`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pgimp.case.gauges import CutGauge, FluxGauge, Gauge, LevelGauge, WallGauge
from pgimp.physics.fields import Source
from pgimp.physics.fields import radius as half_of
from pgimp.physics.fields import volume as volume_of
from pgimp.scene.scene import Scene
from pgimp.solver.history.gauge_forces import (
    Vertices,
    chosen,
    gauge_surface,
    on_wall,
    place_of,
    sum_vertices,
    sums_by,
    through_cut,
    wall_area,
)
from pgimp.solver.history.gauge_surfaces import covered
from pgimp.solver.rank_state import RankState

Array = np.ndarray

#: Numbers of a flux, of mass and momentum; of a level, volume over area and the highest point.
FLUXES, LEVEL = 4, 2


def measure(rank: RankState, time: float) -> dict[str, Array] | None:
    """Return what each gauge measures now on rank 0, None elsewhere; collective.

    Fluxes are those of the particles' velocities, for a first line; see `crossings` for others.
    """
    gauges: Mapping[str, Gauge] = rank.scene.case.gauges
    parts: dict[str, Array] = {}
    known: dict[tuple[object, ...], Vertices] = {}
    for name, gauge in gauges.items():
        if isinstance(gauge, CutGauge | WallGauge):
            external = isinstance(gauge, WallGauge)
            key = (gauge.bodies, id(gauge.within), external)
            if key not in known:
                known[key] = sum_vertices(rank, time, gauge, external)
            parts[name] = (
                on_wall(rank.scene, known[key], gauge)
                if external
                else through_cut(rank.scene, known[key], gauge)
            )
        elif isinstance(gauge, FluxGauge):
            parts[name] = _flux(rank, gauge)
        elif isinstance(gauge, LevelGauge):
            parts[name] = _level(rank, gauge)
    every = rank.comm.gather(parts)
    if every is None:
        return None
    return {
        name: _total(rank.scene, gauge, [part[name] for part in every])
        for name, gauge in gauges.items()
    }


def _total(scene: Scene, gauge: Gauge, parts: Sequence[Array]) -> Array:
    """Return the numbers of a gauge from its parts by plane or layer of all ranks."""
    rows = np.concatenate(parts)
    found = np.add.reduce(rows, axis=0)
    if isinstance(gauge, WallGauge):
        return np.array([found[0], found[0] / wall_area(scene, gauge)])
    if isinstance(gauge, LevelGauge):
        tops = rows[:, 1]
        top = tops.max() if len(tops) else -np.inf
        return np.array([found[0] / _room(scene, gauge), top if np.isfinite(top) else np.nan])
    if scene.case.axisymmetric:  # what points along the radius vanishes all round
        found[1 if isinstance(gauge, FluxGauge) else 0] = 0.0
        if isinstance(gauge, CutGauge):
            found[3:] = 0.0
    return found


def _counted(rank: RankState, gauge: Gauge) -> tuple[Array, Array]:
    """Rows of the particles that a gauge counts, in order, and their layers in this rank."""
    population = rank.population
    layer = np.repeat(np.arange(population.layers), np.diff(population.start))
    if gauge.bodies is None and getattr(gauge, "within", None) is None:
        return population.order, layer
    counted = chosen(rank, gauge, population.order)
    return population.order[counted], layer[counted]


def _flux(rank: RankState, gauge: FluxGauge) -> Array:
    """Sums by layer of mass and momentum that leave a surface, per time."""
    surface, particles = gauge_surface(rank.scene, gauge.flux), rank.up_to_date()
    rows, layer = _counted(rank, gauge)
    rate = surface.passing(place_of(rank, rows), np.take(particles.v, rows, axis=0))
    there = np.flatnonzero(rate)
    rows, layer, rate = rows[there], layer[there], rate[there]
    passed = (rate * particles.m[rows])[:, None]
    terms = np.zeros((len(rows), FLUXES))
    terms[:, :1], terms[:, 1 : 1 + rank.scene.dimension] = passed, passed * particles.v[rows]
    return sums_by(layer, rank.population.layers, terms)


def _level(rank: RankState, gauge: LevelGauge) -> Array:
    """Sums by layer of volumes in a column, and the highest point in each."""
    scene, particles, up = rank.scene, rank.up_to_date(), rank.scene.dimension - 1
    cell, periods = scene.domain.frame.cell, scene.domain.periods
    rows, layer = _counted(rank, gauge)
    x = place_of(rank, rows)
    weight = np.ones(len(rows))
    for d, at in enumerate(gauge.level):
        away = x[:, d] - at
        if periods[d] > 0.0:
            away -= np.round(away / periods[d]) * periods[d]
        weight *= np.maximum(0.0, 1.0 - np.abs(away) / cell[d])
    there = np.flatnonzero(weight)
    rows, layer, height = rows[there], layer[there], x[there, up]
    materials = scene.materials
    source = Source(
        particles, rows, up + 1, materials.body_material, plate=scene.carried.plate,
        fills=materials.fills,
    )  # fmt: skip
    volume = volume_of(source)
    if scene.case.axisymmetric:
        volume = volume / (2.0 * np.pi * particles.x[rows, 0].clip(1e-300))
    found = np.full((rank.population.layers, LEVEL), -np.inf)
    terms = (weight[there] * volume)[:, None]
    found[:, :1] = sums_by(layer, len(found), terms)
    np.maximum.at(found[:, 1], layer, height + half_of(source))
    return found


def _room(scene: Scene, gauge: LevelGauge) -> float:
    """Integral over the domain of the weights of a level's column."""
    grid, area = scene.case.grid, 1.0
    for d, at in enumerate(gauge.level):
        low, high = grid.origin[d], grid.corner[d]
        if scene.domain.periodic[d]:
            low, high = at - grid.cell[d], at + grid.cell[d]
        area *= covered(low, high, at, grid.cell[d])
    return area
