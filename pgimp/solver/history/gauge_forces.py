"""Forces of gauges, from the vertices: through cuts, and on walls.

A force through a cut is the sum of the internal forces (16) of the vertices inside, each times its
weight. The rate of momentum inside is exactly this force and the external ones on these vertices,
whatever the shape: it is the balance that the steps solve. Sums go plane by plane in canonical
order, so that their bits do not depend on the ranks.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pgimp.case.gauges import CutGauge, Gauge, WallGauge
from pgimp.geometry.regions import Box, HalfSpace
from pgimp.geometry.regions.base import Region
from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import FORCE, MASS, RECORD
from pgimp.physics.fields import within
from pgimp.scene.scene import Scene
from pgimp.solver.history.gauge_surfaces import Surface, surface_of
from pgimp.solver.particle_groups import ParticleGroup, groups_of
from pgimp.solver.rank_state import RankState
from pgimp.solver.transfers import join_seams, sum_particles

Array = np.ndarray


class Vertices(NamedTuple):
    """Vertices of a rank's own planes with a force, in order."""

    plane: Array  #: (n,) int64: Their planes.
    planes: int  #: Number of the rank's own planes.
    position: Array  #: (n, 3) float64: Where the grid has them.
    now: Array  #: (n, 3) float64: Where their material is: displaced, in the initial configuration.
    force: Array  #: (n, 3) float64: Sums of the forces on them.

    def sums(self, terms: Array) -> Array:
        """Return sums by plane of terms (n, k), (planes, k)."""
        return sums_by(self.plane, self.planes, terms)


def sums_by(group: Array, count: int, terms: Array) -> Array:
    """Return sums of terms (n, k) by group, (count, k); the groups ascend."""
    found = np.zeros((count, terms.shape[1]))
    there, first = np.unique(group, return_index=True)
    ends = np.append(first, len(group))[1:]
    for i, begin, end in zip(there, first, ends, strict=True):
        found[i] = np.add.reduce(terms[begin:end], axis=0)
    return found


def chosen(rank: RankState, gauge: Gauge, rows: Array) -> Array:
    """Return a mask of the particles in `rows` that a gauge counts."""
    scene, particles = rank.scene, rank.up_to_date()
    found = np.ones(len(rows), bool)
    if gauge.bodies is not None:
        numbers = [scene.body_names.index(name) for name in gauge.bodies]
        found &= np.isin(particles.body[rows], numbers)
    region: Region | None = getattr(gauge, "within", None)
    if region is not None:
        found &= region.contains(place_of(rank, rows))
    return found


def place_of(rank: RankState, rows: Array) -> Array:
    """Return positions of particles, within the domain."""
    return within(rank.up_to_date().x[rows], rank.scene.domain.ends)


def gauge_surface(scene: Scene, region: Region) -> Surface:
    """Return the surface of a cut or a flux in the scene's domain."""
    grid = scene.case.grid
    ends = list(zip(grid.origin, grid.corner, strict=True))
    return surface_of(region, grid.cell, ends, scene.domain.periods.tolist())


def sum_vertices(rank: RankState, time: float, gauge: Gauge, external: bool) -> Vertices:
    """Sum the forces of some particles at the vertices; collective.

    Parameters
    ----------
    gauge : Gauge
        Chooses the particles.
    external : bool
        Whether loads and gravity count, and not only stresses.
    """
    scene, grid = rank.scene, rank.grid
    loads = scene.interaction.loads.at(time)
    if not external:
        loads = loads._replace(tractions=(), force=(), surfaces=())
    groups = groups_of(rank)
    if gauge.bodies is not None or getattr(gauge, "within", None) is not None:
        groups = tuple(_part(rank, gauge, group) for group in groups)
    sum_particles(rank, groups, loads, False, call=Bound())
    rank.halo.finish(grid)
    join_seams(rank, False)
    return _forces(rank, scene.domain.gravity(time) if external else (0.0, 0.0, 0.0))


def _part(rank: RankState, gauge: Gauge, group: ParticleGroup) -> ParticleGroup:
    """Return the chosen particles of a group."""
    rows, start = group.order
    if not len(rows):  # in a rehearsal `start` may not be set
        return group
    counted = chosen(rank, gauge, rows)
    before = np.concatenate([[0], np.cumsum(counted)])
    return replace(group, order=Order(rows[counted], before[start].astype(np.int64)))


def _forces(rank: RankState, gravity: tuple[float, float, float]) -> Vertices:
    """Return the vertices of the rank's own planes that have a force, or weight."""
    scene, grid, own = rank.scene, rank.grid, rank.grid.owned
    D, extent = scene.dimension, grid.window.extent
    G = grid.G.reshape(grid.planes, 1 + max(grid.fields, default=0), *extent[1:], RECORD)[:own]
    force = G[..., FORCE : FORCE + 3].copy()
    for d, pull in enumerate(gravity):
        if pull:
            force[..., d] += G[..., MASS] * pull
    force[grid.active[:own] == 0] = 0.0
    used = (force != 0.0).any(axis=-1)
    if scene.domain.seams:
        used &= G[..., MASS] > 0.0
    index = np.nonzero(used)
    position = np.zeros((len(index[0]), 3))
    for d, number in enumerate((index[0], index[2], index[3])[:D]):
        number = number + (grid.window.lower[d] - scene.domain.frame.ghost)
        position[:, d] = scene.domain.frame.origin[d] + number * scene.domain.frame.cell[d]
    now = position
    if grid.motion:
        values = grid.by_vertex(grid.kept.values)[:own]
        moved = values[index][:, DISPLACEMENT : DISPLACEMENT + 3]
        now = position + np.where(grid.kept.fields[index[1]][:, None], moved, 0.0)
    return Vertices(index[0], own, position, now, force[index])


def through_cut(scene: Scene, vertices: Vertices, gauge: Gauge) -> Array:
    """Return sums by plane of the force and the moment on what is inside a cut."""
    assert isinstance(gauge, CutGauge)
    inside = gauge_surface(scene, gauge.cut).inside(vertices.position)
    force = inside[:, None] * vertices.force
    x, y, z = (vertices.now - np.array(_about(gauge))).T
    fx, fy, fz = force.T
    moment = [y * fz - z * fy, z * fx - x * fz, x * fy - y * fx]
    return vertices.sums(np.column_stack([force, *moment]))


def _about(gauge: CutGauge) -> tuple[float, ...]:
    """Point of the moment of a cut."""
    if gauge.about is not None:
        point = gauge.about
    elif isinstance(gauge.cut, HalfSpace):
        point = gauge.cut.point
    else:
        assert isinstance(gauge.cut, Box)
        pairs = zip(gauge.cut.min, gauge.cut.max, strict=True)
        point = tuple(0.5 * (low + high) for low, high in pairs)
    return (*point, 0.0, 0.0)[:3]


def on_wall(scene: Scene, vertices: Vertices, gauge: Gauge) -> Array:
    """Return sums by plane of the force on a wall, positive in compression.

    The wall bears the force of what is on it, and of what lies beyond it. Beyond a mirror it turns
    that round, so that it bears it twice.
    """
    assert isinstance(gauge, WallGauge)
    axis, sign = "xyz".index(gauge.wall[0]), 1.0 if gauge.wall.endswith("max") else -1.0
    frame = scene.domain.frame
    at = frame.origin[axis] + (frame.cells[axis] * frame.cell[axis] if sign > 0.0 else 0.0)
    beyond = np.round(sign * (vertices.position[:, axis] - at) * frame.inverse[axis])
    mirrored = any(m.axis == axis and m.side == sign for m in scene.domain.mirrors)
    weight = np.where(beyond > 0.0, 2.0 if mirrored else 1.0, np.where(beyond == 0.0, 1.0, 0.0))
    return vertices.sums((sign * weight * vertices.force[:, axis])[:, None])


def wall_area(scene: Scene, gauge: WallGauge) -> float:
    """Return the area of the wall within the domain and the box around the gauge's region."""
    grid, axis = scene.case.grid, "xyz".index(gauge.wall[0])
    ends = list(zip(grid.origin, grid.corner, strict=True))
    if gauge.within is not None:
        low, high = gauge.within.bounds()
        ends = [(max(a, c), min(b, d)) for (a, b), c, d in zip(ends, low, high, strict=True)]
    area = 1.0
    for d, (low, high) in enumerate(ends):
        if d == axis:
            continue
        if d == 0 and scene.case.axisymmetric:
            area *= np.pi * (high**2 - low**2)
        else:
            area *= high - low
    if axis == 0 and scene.case.axisymmetric:
        area *= 2.0 * np.pi * (grid.corner if gauge.wall.endswith("max") else grid.origin)[0]
    return area if area > 0.0 else np.inf
