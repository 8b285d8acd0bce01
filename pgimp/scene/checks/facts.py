"""Facts about the bodies before the run, from particles that are created block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pgimp.case.output import PlaceProbe
from pgimp.case.schema import Case
from pgimp.geometry.regions import Points
from pgimp.scene.bodies.lattice import Lattice, ParticleBlock
from pgimp.scene.bodies.populate import velocities
from pgimp.scene.checks.later_constraints import LaterConstraint, held, later_constraints
from pgimp.scene.scene import Scene
from pgimp.scene.wave_speeds import rest_rate, wave_speed

_Reals = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class BodyFacts:
    """Facts about a body before the run."""

    name: str
    particles: int
    #: wave_speed, top_speed: At rest; the greatest initial speed of a particle.
    wave_speed: float
    top_speed: float
    density: float
    #: low, high: Corners of its bounding box.
    low: tuple[float, ...]
    high: tuple[float, ...]
    velocity: tuple[float, ...]  #: Mean of the particles' initial velocities.
    rigid: bool  #: Whether all particles start with `velocity`.
    rest_rate: float  #: See `rest_rate`.
    #: dict of str to (float, float, float): Least, mean and greatest value of spatially varying
    #: material parameters, by key. Density, wave speed and rate are then maxima.
    varies: dict[str, tuple[float, float, float]]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Extent along each direction."""
        return tuple(b - a for a, b in zip(self.low, self.high, strict=True))

    @property
    def extent(self) -> float:
        """Largest extent."""
        return max(self.sizes)


@dataclass
class Findings:
    """Facts about the particles of a case, body by body."""

    bodies: list[BodyFacts]
    #: (constraints + 1,) int64: Number of particles that each constraint holds, from the second
    #: entry on.
    held: np.ndarray
    #: For each probe, the distance of the closest particle. For a material point: from the
    #: particle's centre. For a fixed position: the largest component, in cells.
    away: dict[str, float]
    later: list[LaterConstraint]  #: Constraints of later stages.
    #: (len(later),) int64: Number of particles in the regions of the later constraints.
    held_later: np.ndarray


def examine(
    scene: Scene, lattice: Lattice, counts: np.ndarray, stages: Sequence[Case] = ()
) -> Findings:
    """Create all particles, block by block, and collect the facts.

    Parameters
    ----------
    lattice, counts
        See `count_particles`.
    stages : sequence of Case
        The cases of all stages.

    Raises
    ------
    CaseError
        If a constraint contains no particle, as at the start of a run.
    """
    later = later_constraints(stages)
    found = Findings(
        [],
        np.zeros(len(scene.interaction.loads.constraints) + 1, np.int64),
        dict.fromkeys(scene.case.probes, np.inf),
        later,
        np.zeros(len(later), np.int64),
    )
    for body in range(len(scene.body_names)):
        found.bodies.append(_examine(scene, lattice, counts, body, found))
    scene.interaction.loads.require_held(found.held)
    return found


def _examine(
    scene: Scene, lattice: Lattice, counts: np.ndarray, body: int, found: Findings
) -> BodyFacts:
    D = scene.dimension
    low, high = np.full(D, np.inf), np.full(D, -np.inf)
    speeds, own = _Speeds(D), _Varied(scene, body)
    motion = scene.case.bodies[scene.body_names[body]].velocity
    for block in lattice.make((0, lattice.planes), counts, body):
        if block.velocities is not None:
            speeds.add(block.velocities, block.fractions)
        elif scene.settings.moves or not isinstance(motion, tuple):
            speeds.add(velocities(scene, body, block.centroids), block.fractions)
        elif not speeds.mass:  # one for all
            speeds.add(np.array([motion], float), np.ones(1))
        ends = block.positions.min(axis=0), block.positions.max(axis=0)
        low, high = np.minimum(low, ends[0]), np.maximum(high, ends[1])
        own.add(block)
        _count_held(scene, block, ends, found)
        if found.later:
            bodies = np.full(len(block.ids), body, np.int32)
            found.held_later += held(found.later, bodies, block.positions)
        _measure_probes(scene, block, ends, found)
    # Boxes around the particles, unless the region itself is smaller.
    half = 0.5 * np.array(scene.domain.frame.cell) / lattice.per_cell
    low, high = low - half, high + half
    region = scene.case.bodies[scene.body_names[body]].region
    if not isinstance(region, Points):
        low, high = np.maximum(low, region.bounds()[0]), np.minimum(high, region.bounds()[1])
    return BodyFacts(
        scene.body_names[body],
        int(counts[body].sum()),
        own.wave_speed,
        speeds.top,
        own.density,
        tuple(low.tolist()),
        tuple(high.tolist()),
        tuple((speeds.momentum / speeds.mass).tolist()),
        bool((speeds.least == speeds.most).all()),
        own.rest_rate,
        own.ranges,
    )


class _Speeds:
    """Bounds and mean of velocities, and the greatest speed."""

    def __init__(self, dimension: int) -> None:
        self.top = self.mass = 0.0
        self.least, self.most = np.full(dimension, np.inf), np.full(dimension, -np.inf)
        self.momentum = np.zeros(dimension)

    def add(self, v: _Reals, mass: _Reals) -> None:
        """Add some particles."""
        with np.errstate(over="ignore"):
            self.top = max(self.top, float(np.sqrt((v * v).sum(axis=1)).max()))
        self.least = np.minimum(self.least, v.min(axis=0))
        self.most = np.maximum(self.most, v.max(axis=0))
        self.momentum += mass @ v
        self.mass += float(mass.sum())


class _Varied:
    """Wave speed, density and rate at rest of a body; maxima where its material varies."""

    def __init__(self, scene: Scene, body: int) -> None:
        self._scene, self._body = scene, body
        number = scene.materials.body_material[body]
        self._layout = scene.materials.variations.layouts[number]
        self.wave_speed = self.rest_rate = self.density = 0.0
        self._count, self._sums, self._least, self._most = 0, 0.0, np.inf, -np.inf
        if self._layout is None:
            self.wave_speed, self.rest_rate = wave_speed(scene, body), rest_rate(scene, body)
            self.density = scene.materials.parameters[number].density

    def add(self, block: ParticleBlock) -> None:
        """Add some particles."""
        own = self._scene.materials.variations.of(
            block, self._scene.materials.body_material[self._body]
        )
        if own is None:
            return
        _, first = np.unique(own.columns, axis=0, return_index=True)
        points = own.columns[first], own.state[first]
        self.wave_speed = max(self.wave_speed, wave_speed(self._scene, self._body, points))
        self.rest_rate = max(self.rest_rate, rest_rate(self._scene, self._body, points=points))
        self.density = max(self.density, float(own.density.max()))
        self._count += len(own.values)
        self._sums = self._sums + own.values.sum(axis=0)
        self._least = np.minimum(self._least, own.values.min(axis=0))
        self._most = np.maximum(self._most, own.values.max(axis=0))

    @property
    def ranges(self) -> dict[str, tuple[float, float, float]]:
        """Least, mean and greatest value of varying parameters, by key."""
        if self._layout is None:
            return {}
        rows = np.stack([self._least, self._sums / self._count, self._most], axis=1).tolist()
        keys = (".".join(path) for path in self._layout.paths)
        return {key: (row[0], row[1], row[2]) for key, row in zip(keys, rows, strict=True)}


def _gap(ends: tuple[_Reals, _Reals], low: Any, high: Any) -> _Reals:
    """Distance between two boxes by direction; zero where they overlap."""
    return np.maximum(0.0, np.maximum(ends[0] - high, np.array(low) - ends[1]))


def _count_held(
    scene: Scene, block: ParticleBlock, ends: tuple[_Reals, _Reals], found: Findings
) -> None:
    entries = scene.interaction.loads.constraints
    name = scene.body_names[block.body]
    if any(c.body == name and not _gap(ends, *c.region.bounds()).any() for c in entries):
        numbers = scene.interaction.loads.held(block.body, block.positions)
        found.held += np.bincount(numbers, minlength=len(found.held))


def _measure_probes(
    scene: Scene, block: ParticleBlock, ends: tuple[_Reals, _Reals], found: Findings
) -> None:
    cell, name_of_body = np.array(scene.domain.frame.cell), scene.body_names[block.body]
    for name, probe in scene.case.probes.items():
        place = isinstance(probe, PlaceProbe)
        at = np.array(probe.place if place else probe.at, float)
        # Lower bound from the bounding box; a fixed position needs no closest particle.
        apart = _gap(ends, at, at)
        if place:
            if found.away[name] < 1.0 or (apart / cell).max() >= 1.0:
                continue
            least = float((np.abs(block.positions - at) / cell).max(axis=1).min())
        elif probe.body != name_of_body or np.hypot.reduce(apart) > found.away[name]:
            continue
        else:
            least = float(np.sqrt(((block.positions - at) ** 2).sum(axis=1).min()))
        found.away[name] = min(found.away[name], least)
