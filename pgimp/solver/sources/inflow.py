"""Inflow: layers of particles that enter as those before them have moved on.

A constraint holds what is in an inflow's region, so that it moves exactly as prescribed. Whenever
it has moved by the distance of two layers, another one enters behind the last. Its positions,
numbers and sums follow from the case and from the steps so far alone. So every rank knows them, and
makes the particles of its own layers.
"""

from __future__ import annotations

from math import floor, prod

import numpy as np

from pgimp.case.schema import Case
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import grow_vertex_bounds, locate
from pgimp.kernels.sums.sums import layer_sums
from pgimp.kernels.update.turns import turn_particles
from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.populate import populate
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import StepPart

#: Part of a layer's distance by which the next one may be early, for rounding; and by which
#: rounding may move particles from where their layer should be.
_EARLY, _DRIFT = 1e-9, 1e-6

#: Times as many particles as at the start may be in a cell, as what enters also leaves.
_CROWD = 2

_NONE = np.empty(0, np.int32)


class Source:
    """An inflow: its first layer, and what has entered.

    Parameters
    ----------
    name : str
        The inflow, and its body.
    particles : Particles
        The particles of all bodies with an inflow, as they are at the start.

    Attributes
    ----------
    layer : Particles
        The layer farthest upstream, at its initial position.
    number : int
        Number of its constraint, from 0.
    moved, entered : float, int
        How far the particles in its region have moved, along the axis; layers so far.
    freed : bool
        Whether it has ended and let go of all, in this process.
    """

    def __init__(self, scene: Scene, name: str, particles: Particles) -> None:
        case, self.name = scene.case, name
        self.entry: InflowEntry = case.inflow[name]
        self.axis, self.sign = self.entry.axis, self.entry.sign
        self.number = list(case.constraints).index(name)
        per_cell = case.method.particles_per_cell[self.axis]
        self.spacing = case.grid.cell[self.axis] / per_cell
        region = case.bodies[name].region.bounds()
        self.exit = float(region[int(self.sign > 0.0)][self.axis])
        mine = np.flatnonzero(particles.body == scene.body_names.index(name))
        along = self.sign * particles.x[mine, self.axis]
        self.layer = _chosen(particles, mine[along < along.min() + 0.5 * self.spacing])
        self.moved, self.entered = 0.0, 0
        self.freed, self._bodies = False, list(case.bodies.values())

    def passes(self, way: float) -> bool:
        """Whether a layer passes the end of the region, or is about to, as all move on."""
        layers = [self.sign * at / self.spacing + 0.5 for at in (self.moved, self.moved + way)]
        return any(floor(layers[0] + e) != floor(layers[1] + e) for e in (-_DRIFT, _DRIFT))

    def ended(self, time: float) -> bool:
        """Whether nothing enters any more."""
        return self.entry.until is not None and time >= self.entry.until * (1.0 - _EARLY)

    def due(self) -> bool:
        """Whether the next layer has room."""
        return self.sign * self.moved >= (self.entered + 1 - _EARLY) * self.spacing

    def next(self, velocity: tuple[float, ...], first: int) -> Particles:
        """Return the next layer, with particles from number `first` on."""
        self.entered += 1
        new = _chosen(self.layer, np.arange(self.layer.capacity))
        new.x[:, self.axis] += self.moved - self.sign * self.entered * self.spacing
        new.v[:] = velocity[: new.v.shape[1]]
        new.id[:] = np.arange(first, first + new.capacity)
        new.initialise(self._bodies)
        return new


class Inflow(StepPart):
    """The inflows of a scene, the same on every rank.

    Parameters
    ----------
    before : Inflow, optional
        That of the stage before, which goes on.

    Attributes
    ----------
    sums : (columns,) float64
        What has entered, as in `layer_sums`.
    """

    def __init__(self, scene: Scene, before: Inflow | None = None) -> None:
        self.scene = scene
        lattice, counts, _ = count_particles(scene, Serial(), [*scene.case.inflow])
        particles = populate(scene, lattice, counts, (0, lattice.planes))
        if particles.L.shape[1] and not scene.carried.affine:  # gradients are of the start alone
            particles = particles._replace(L=np.zeros((particles.capacity, 0)))
        self.sources = [Source(scene, name, particles) for name in scene.case.inflow]
        self.sums = np.zeros(scene.materials.sums)
        if before is not None:
            self.restore(before.numbers)

    @property
    def numbers(self) -> list[float]:
        """Its state: how far each has moved, and its layers; then the sums."""
        found = [number for one in self.sources for number in (one.moved, float(one.entered))]
        return [*found, *self.sums.tolist()]

    def restore(self, numbers: list[float]) -> None:
        """Take a state over."""
        for i, one in enumerate(self.sources):
            one.moved, one.entered = numbers[2 * i], int(numbers[2 * i + 1])
        rest = numbers[2 * len(self.sources) :]
        self.sums[: len(rest)] = rest[: len(self.sums)]

    def change_particles(self, rank: RankState, t: Step) -> None:
        """Insert the layers that have room after a step; all ranks do the same."""
        if needed(0):  # in a rehearsal nothing enters
            return
        prescribed = self.scene.interaction.loads.constraints_at(t.start, t.end)
        arrived = [_NONE]
        for one in self.sources:
            velocity = prescribed[one.number].velocity
            way, ended = velocity[one.axis] * t.dt, one.ended(t.end)
            if one.passes(way) or ended:
                self._release(rank, one, ended)
            one.moved += way
            while not ended and one.due():
                new = one.next(velocity, rank.numbered)
                rank.numbered += new.capacity
                arrived.append(self._enter(rank, new))
        rows = np.concatenate(arrived)
        if len(rows):
            population, shape = rank.population, self.scene.settings.shape
            population.restore_order(_NONE, rows)
            bounds = rank.vertex_bounds
            grow_vertex_bounds(shape, self.scene.order_frame, population.columns, rows, bounds)

    def _release(self, rank: RankState, one: Source, ended: bool) -> None:
        """Hold the particles no more that have left the region, or all."""
        if one.freed:
            return
        one.freed, p = ended, rank.population.columns
        held = np.flatnonzero(p.constraint[:, 0] == one.number + 1)
        beyond = one.sign * (p.x[held, one.axis] - one.exit) > 0.0
        p.constraint[held if ended else held[beyond], 0] = 0

    def _enter(self, rank: RankState, new: Particles) -> np.ndarray:
        """Book a layer, and take its particles in the rank's layers; returns their rows."""
        scene, every = self.scene, np.arange(new.capacity, dtype=np.int32)
        shape, frame = scene.settings.shape, scene.order_frame
        if any(scene.domain.periodic):
            turn_particles(shape, frame, scene.domain.exits, new, every)
        locate(shape, frame, new, every, scene.domain.frame.vertices)
        sums = np.zeros((1, len(scene.body_names), scene.materials.sums))
        order = Order(every, np.array([0, len(every)]))
        layer_sums(scene.setting.without_shape(), new, order, sums)
        self.sums += np.add.reduce(sums[0], axis=0)
        slab = rank.slab
        mine = (slab.first <= new.layer) & (new.layer < slab.first + slab.layers)
        rows: np.ndarray = rank.population.insert(int(np.count_nonzero(mine)))
        stored = rank.population.columns
        for name, column in new._asdict().items():
            getattr(stored, name)[rows] = column[mine]
        return rows


def _chosen(particles: Particles, rows: np.ndarray) -> Particles:
    """A copy of some particles."""
    return Particles._make(column[rows] for column in particles)


def inflow_of(scene: Scene, _: Communicator, before: Inflow | None = None) -> Inflow | None:
    """Return the inflows of a scene, None without any."""
    return Inflow(scene, before) if scene.case.inflow else None


def to_enter(case: Case, counts: np.ndarray, end: float) -> dict[str, int]:
    """Particles that enter by each inflow until `end`; `counts` as from `count_particles`."""
    found = {}
    for name, entry in case.inflow.items():
        body = list(case.bodies).index(name)
        low, high = case.bodies[name].region.bounds()
        length = float(high[entry.axis] - low[entry.axis])
        found[name] = int(counts[body].sum() * entry.travel(end) / length)
    return found


def most_at_once(case: Case, counts: np.ndarray, entering: dict[str, int]) -> int:
    """Particles to have memory for: all that enter, but no more than `_CROWD` full domains."""
    full = prod(round(a / b) for a, b in zip(case.grid.size, case.grid.cell, strict=True))
    full *= prod(case.method.particles_per_cell)
    begin = int(counts.sum())
    return min(begin + sum(entering.values()), max(begin, _CROWD * full))
