"""Probes: a particle followed by its id, or the material at a fixed position.

Work is done only when a line is due, outside the step. Values do not depend on the ranks. A
particle is on one of them, and sums at a position go layer by layer in canonical order, as in the
history.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.decomposition.population import Population
from pgimp.physics.columns import FOLLOWED, PLACE, Around
from pgimp.physics.derived import OF_STRESS, RECOVERED
from pgimp.physics.fields import FIELDS, TENSOR, volume
from pgimp.solver.lagrangian.pieces import source_at
from pgimp.solver.lagrangian.recovered_stress import recovered_stresses
from pgimp.storage.framefile import blocks

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene
    from pgimp.solver.state.progress import SimulationProgress

AXES = "xyz"
#: Components of a symmetric tensor by the number of dimensions.
_COMPONENTS = ((0, 1, 2), (0, 1, 2, 3), range(6))
#: Components of a strain.
_STRAINS = ((0,), (0, 1, 3), range(6))

#: Part of a cell's volume around a position that must be filled: a flat surface has half of it.
FILLED = 0.25

_BLOCK = 1 << 16

Line = dict[str, float | None]


class Point:
    """A material point: the particle of an id, on any rank.

    Parameters
    ----------
    number : int
        Its id.
    origin : sequence of float
        Where its displacement counts from.
    fields : sequence of str
        Derived fields that it has besides.
    at : sequence of float
        Place in the undeformed body that the case names.
    """

    def __init__(
        self, number: int, origin: Sequence[float], fields: Sequence[str] = (),
        at: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self.number, self.at = number, tuple(at)
        self.recovered = np.zeros((1, 6))  # of the line that is due
        self.fields = tuple(fields)
        self.origin = tuple(origin)
        #: Whether it has left all ranks, and its row on this rank, else -1.
        self.gone = False
        self.row = -1

    def known(self, population: Population) -> bool:
        """Return whether the particle is on this rank, in its last row."""
        p, row, self.row = population.columns, self.row, -1
        if 0 <= row < p.capacity and p.id[row] == self.number:
            layer = int(p.layer[row]) - population.first
            if 0 <= layer < population.layers:
                # The row of a particle that has left keeps its number, but is in no layer's order.
                rows = population.order[population.start[layer] : population.start[layer + 1]]
                self.row = row if (rows == row).any() else -1
        return self.row >= 0

    def search(self, population: Population) -> bool:
        """Search all of this rank's particles for it; returns whether it is there."""
        self.row = -1
        for begin, end in blocks(len(population.order), _BLOCK):
            rows = population.order[begin:end]
            there = np.flatnonzero(population.columns.id[rows] == self.number)
            if len(there):
                self.row = int(rows[there[0]])
        return self.row >= 0

    def own(self, sim: SimulationProgress) -> np.ndarray | None:
        """Columns of the particle, None on other ranks."""
        if self.row < 0:
            return None
        scene = sim.scene
        source = source_at(sim.rank, np.array([self.row]))
        place = "unwrapped" if scene.domain.ends else "position"
        found = []
        for name, components in _followed(scene, self.fields):
            if name == "displacement":
                now = scene.fields[place].values(source)[0, : scene.dimension]
                found.append(now - self.origin)
            elif name == RECOVERED:
                found.append(self.recovered[0, list(components)])
            else:
                values = np.atleast_1d(scene.fields[name].values(source)[0])
                found.append(values[list(components)])
        return np.concatenate(found)

    def line(self, sim: SimulationProgress, parts: list[np.ndarray | None]) -> Line:
        """A line on rank 0, from each rank's part; nothing but the time after its removal."""
        names = []
        for name, components in _followed(sim.scene, self.fields):
            parts_of = sim.scene.fields[name].components.split()
            names += [f"{name}-{parts_of[i]}" for i in components] if parts_of else [name]
        values = next((part for part in parts if part is not None), None)
        return _line(sim, names, values)


def _followed(scene: Scene, fields: Sequence[str]) -> list[tuple[str, Sequence[int]]]:
    """Quantities of a material point, and their components in the case."""
    D = scene.dimension
    found: list[tuple[str, Sequence[int]]] = []
    for name in (*FOLLOWED, *scene.materials.states.fields, *scene.materials.variations.fields):
        columns = scene.fields[name].columns
        tensor = _STRAINS[D - 1] if name == "strain" else _COMPONENTS[D - 1]
        found.append((name, tensor if columns == 6 else range(min(D, columns) or 1)))
    for name in fields:
        columns = scene.fields[name].columns
        found.append((name, _COMPONENTS[D - 1] if columns == 6 else range(columns or 1)))
    return found


class Place:
    """A position fixed in space: the mean over the particles around it.

    A particle counts by the weight of a grid vertex there in linear interpolation,
    w = product of max(0, 1 - |x_p - X|/L) over the directions. The columns are in `PLACE`. Where
    less than a quarter is filled, only the volume fraction is given.

    Parameters
    ----------
    place : sequence of float
        The position.
    fields : sequence of str
        Derived fields of the mean stress that it has besides.
    """

    def __init__(self, place: Sequence[float], fields: Sequence[str] = ()) -> None:
        self.place, self.fields = tuple(place), tuple(fields)

    def own(self, sim: SimulationProgress) -> list[np.ndarray]:
        """Sums of the layers of this rank whose particles may reach the position, in order."""
        population, frame, sums = sim.population, sim.scene.domain.frame, []
        periods = sim.scene.domain.periods
        cell = floor((self.place[0] - frame.origin[0]) * frame.inverse[0]) + frame.ghost
        # A particle is up to two cells beyond the first vertex of its support, now or initially.
        near = range(cell - 3, cell + 3)
        if sim.scene.settings.by_vertex or periods[0]:
            near = range(population.first, population.first + population.layers)
        for number in near:
            layer = number - population.first
            if not 0 <= layer < population.layers:
                continue
            rows = population.order[population.start[layer] : population.start[layer + 1]]
            source, weight = source_at(sim.rank, rows), np.ones(len(rows))
            x = source.take("x")
            for d, at in enumerate(self.place):
                distance = _apart(x[:, d] - at, periods[d]) * frame.inverse[d]
                weight *= np.maximum(0.0, 1.0 - distance)
            there = weight > 0.0
            if there.any():
                m, v, sigma = (source.take(name)[there] for name in ("m", "v", "sigma"))
                mass = (weight[there] * m)[:, None]
                filled = (weight[there] * volume(source)[there])[:, None]
                terms = np.hstack([filled, mass, mass * v, filled * sigma])
                sums.append(np.add.reduce(terms, axis=0))
        return sums

    def line(self, sim: SimulationProgress, parts: list[list[np.ndarray]]) -> Line:
        """A line on rank 0, from the sums of each rank."""
        D, S = sim.scene.dimension, sim.population.columns.sigma.shape[1]
        ends = {"AXIS": AXES[:D], "COMPONENT": TENSOR.split()[:S]}
        names = []
        for name in PLACE:
            stem, _, end = name.rpartition("-")
            names += [f"{stem}-{part}" for part in ends[end]] if end in ends else [name]
        for name in self.fields:
            names += [f"{name}-{part}" for part in FIELDS[name].components.split()] or [name]
        sums = [layer for part in parts for layer in part]
        total = np.add.reduce(np.array([np.zeros(2 + D + S), *sums]), axis=0)
        fraction = total[0] / sim.scene.domain.tent_volume(self.place)
        if fraction < FILLED:
            return _line(sim, names, np.array([fraction]))
        around = Around(fraction, total[0], total[1], total[2 : 2 + D], total[2 + D :])
        values = [mean.values(around) for mean in PLACE.values()]
        values += [OF_STRESS[name](around.mean)[0] for name in self.fields]
        return _line(sim, names, np.hstack(values))


def _apart(distance: np.ndarray, period: float) -> np.ndarray:
    """Distances along a direction, to the nearest image where there is a period."""
    if period > 0.0:
        distance = distance - np.round(distance / period) * period
    return np.abs(distance)


def _undeformed(sim: SimulationProgress, rows: np.ndarray) -> np.ndarray:
    """Positions that displacements of particles count from, (n, D), with turns through faces.

    Of particles that keep no such position, the present one.
    """
    p, periods = sim.population.columns, sim.scene.domain.periods
    x = p.origin[rows] if p.origin.shape[1] else sim.particles.x[rows]
    return x + p.winding[rows] * periods if periods.any() else x


def _line(sim: SimulationProgress, names: list[str], values: np.ndarray | None) -> Line:
    """A line with `values` in the first columns, and nothing in the others."""
    line: Line = {"time": sim.time, "step": sim.step} | dict.fromkeys(names)
    if values is not None:
        # Added zero turns -0 into 0.
        line |= {name: float(value) + 0.0 for name, value in zip(names, values, strict=False)}
    return line


def nearest(
    sim: SimulationProgress, body: int, at: Sequence[float], fields: Sequence[str] = ()
) -> Point:
    """The particle of a body whose centre was closest to a position, undeformed; collective.

    Of several that are equally close, the one with the lowest number.
    """
    population, found = sim.population, (np.inf, -1, ())
    p = population.columns
    for begin, end in blocks(len(population.order), _BLOCK):
        rows = population.order[begin:end]
        rows = rows[p.body[rows] == body]
        undeformed, distance = _undeformed(sim, rows), np.zeros(len(rows))
        for d, x in enumerate(at):
            distance += _apart(undeformed[:, d] - x, sim.scene.domain.periods[d]) ** 2
        if len(rows):
            close = np.flatnonzero(distance == distance.min())
            k = close[np.argmin(p.id[rows[close]])]
            best: Any = (float(distance[k]), int(p.id[rows[k]]), tuple(undeformed[k].tolist()))
            found = min(found, best) if found[1] >= 0 else best
    _, number, origin = min(each for each in sim.comm.allgather(found) if each[1] >= 0)
    return Point(number, origin, fields, at)


def begin_at_rest(sim: SimulationProgress, points: Sequence[Point]) -> None:
    """Let displacements of points count from where those of frames do, after settling; collective.

    These are the undeformed positions in the initial configuration, else those at rest.
    """
    _find(sim, points)
    mine = [None if point.row < 0 else _undeformed(sim, np.array([point.row])) for point in points]
    every = sim.comm.allgather(mine)
    for i, point in enumerate(points):
        origin = next((part[i] for part in every if part[i] is not None), None)
        if origin is not None:
            point.origin = tuple(origin[0].tolist())


def _find(sim: SimulationProgress, points: Sequence[Point]) -> None:
    """Find the rows of points on their ranks; those on none have gone; collective."""
    comm, population = sim.comm, sim.population
    if points:
        known = comm.allreduce(np.array([point.known(population) for point in points], int))
        lost = [point for point, there in zip(points, known, strict=True) if not there]
        if lost:
            found = comm.allreduce(np.array([point.search(population) for point in lost], int))
            for point, there in zip(lost, found, strict=True):
                point.gone = not there


def _recover(sim: SimulationProgress, points: Sequence[Point]) -> None:
    """Find the recovered stresses of points, at their places in the case; collective.

    These are within half a cell of the particle.
    """
    if not points:
        return
    p, half = sim.population.columns, 0.5 * np.array(sim.scene.domain.frame.cell)
    mine = [point for point in points if point.row >= 0]
    rows = np.array([point.row for point in mine], np.int64)
    x = p.origin[rows]
    for i, point in enumerate(mine):
        away = np.array(point.at) - x[i]
        for d, period in enumerate(sim.scene.domain.periods):
            away[d] -= np.round(away[d] / period) * period if period > 0.0 else 0.0
        x[i] += np.clip(away, -half, half)
    stress = recovered_stresses(sim.rank, x, p.body[rows])
    for point, values in zip(mine, stress, strict=True):
        point.recovered[0, : len(values)] = values


def sample(sim: SimulationProgress, probes: Sequence[Point | Place]) -> list[Line]:
    """Lines of probes about the current state on rank 0, empty elsewhere; collective."""
    comm = sim.comm
    points = [probe for probe in probes if isinstance(probe, Point) and not probe.gone]
    _find(sim, points)
    _recover(sim, [point for point in points if RECOVERED in point.fields])
    parts = comm.gather([probe.own(sim) for probe in probes])
    if parts is None:
        return []
    return [probe.line(sim, [part[i] for part in parts]) for i, probe in enumerate(probes)]
