"""Simulations of small scenes similar to a case, for timing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from time import perf_counter

import numpy as np

from pgimp.case.schema import Case
from pgimp.decomposition.slabs import Slab
from pgimp.errors import CaseError, RunError
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import locate
from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.lattice import Lattice
from pgimp.solver.decomposition import RESORT
from pgimp.solver.simulation import Simulation
from pgimp.solver.start.creation import Creation
from pgimp.utilities.model.sample_cases import ENDLESS, plain, resized

#: Seconds, and least and most steps, of a timed block.
_BLOCK_SECONDS, _FEWEST, _MOST = 0.02, 2, 100
#: Small strains, so that a material's functions take the same branches as in a run.
_STRAIN = 1e-3
#: Change of phase of positions and strains from cell to cell [rad].
_WAVE = 0.6
#: Least mean displacement of particles in a step, in cells: enough for some changes of layers.
_DRIFT = 0.005
#: Greatest number of particles of a sample, over the requested number.
_LARGER = 4.0
#: Fraction of its particles that a sample must keep to be representative.
_KEPT = 0.98
#: Multiples of a case's end that no sample reaches; more would be refused, see
#: `pgimp.solver.time.stability.require_end`.
_MANY = 1e9


class ScatteredCreation(Creation):
    """Particles at scattered positions in their boxes, also from neighbours' layers."""

    def create(
        self, slab: Slab, lattice: Lattice, counts: np.ndarray, layer: np.ndarray
    ) -> tuple[Particles, int]:
        """See `Creation.create`."""
        end = slab.first + slab.layers
        if slab.layers == 0 or self.scene.by_cells:  # cells of the lattice cost far less
            return super().create(slab, lattice, counts, layer)
        # Particles of the neighbours' next layers may be scattered into this slab.
        wider = slab._replace(first=slab.first - 1, layers=slab.layers + 2)
        p, count = super().create(wider, lattice, counts, layer)
        scene, D = self.scene, self.scene.dimension
        cell = np.array(scene.domain.frame.cell)
        # Neighbours have similar offsets, as in a body that moves and deforms.
        phase = (p.x[:count] / cell).sum(axis=1)[:, None] * _WAVE
        p.x[:count] += 0.49 * cell / lattice.per_cell * np.sin(phase + np.arange(D))
        p.F[:count] += _STRAIN * np.sin(phase + np.arange(D * D))
        if scene.settings.initial or scene.settings.mixed:
            p.origin[:] = p.x
        rows = np.arange(count, dtype=np.int32)
        locate(scene.settings.shape, scene.order_frame, p, rows, scene.domain.frame.vertices)
        here = (p.layer[:count] >= slab.first) | (slab.lower is None)
        here &= (p.layer[:count] < end) | (slab.upper is None)
        rows = rows[here]
        kept = np.append(rows, 0)  # space for at least one
        return Particles._make(column[kept] for column in p), len(rows)


class Scattered(Simulation):
    """A simulation as if in mid-run: particles are scattered in their boxes, and drift."""

    creation = ScatteredCreation

    def __init__(self, case: Case, comm: Communicator) -> None:
        super().__init__(case, comm)
        dt = self.clock.next(self.done, self.rate).dt
        v, cell = self.particles.v, self.scene.domain.frame.cell[0]
        rows = self.live()
        crossings = dt / cell * float(np.abs(v[rows, 0]).sum())
        total, count = np.sum(comm.allgather((crossings, len(rows))), axis=0)
        if total < _DRIFT * count:
            v[rows, 0] += _DRIFT * cell / dt


class Sample:
    """A simulation timed block by block, in turn with others.

    It restarts before its scene has changed much.

    Parameters
    ----------
    make : callable
        Makes the simulation; again after a failure, as its results do not matter.

    Attributes
    ----------
    sim : Simulation
        Present state.
    failure : str
        Reason why the last steps were not timed; empty if they were.
    """

    def __init__(self, make: Callable[[], Simulation]) -> None:
        self._make, self.failure = make, ""
        self._blocks: list[dict[str, float]] = []
        self._begin()
        seconds: list[float] = []
        for _ in range(3):
            begin = perf_counter()
            self._advance(_FEWEST)
            seconds.append(perf_counter() - begin)
        each = median(seconds) / _FEWEST
        self._steps = int(min(max(_BLOCK_SECONDS / each, _FEWEST), _MOST))

    def _begin(self) -> None:
        self.sim = self._make()
        self._left = 2 * _MOST
        self._made = self.sim.present()
        self.sim.advance()  # touches its memory

    def _advance(self, steps: int) -> int:
        """Do steps; return their number, fewer at the end, 0 if a restart discards them."""
        self._left -= steps
        sim = self.sim
        first = sim.step
        try:
            while sim.step < first + steps and not sim.finished:
                sim.advance(complete=False)
            sim.complete_reduction()
        except RunError as error:
            self.failure = str(error).splitlines()[0]
            self._begin()
            return 0
        if sim.present() < _KEPT * self._made:
            self.failure = "its particles leave the domain"
            self._begin()
            return 0
        self.failure = ""
        return sim.step - first

    def run(self) -> None:
        """Time a block."""
        if self.sim.finished or self._left < self._steps:
            self._begin()
        sim = self.sim
        before = dict(sim.rank.timings)
        begin = perf_counter()
        steps = self._advance(self._steps)
        if not steps:
            self._steps = max(_FEWEST, self._steps // 2)  # it may always fail before this number
            return
        spent = perf_counter() - begin
        block = {name: sim.rank.timings[name] - before[name] for name in before}
        block["step"] = spent - block.pop("sort")
        block = {name: seconds / steps for name, seconds in block.items()}
        begin = perf_counter()
        sim.population.sort()
        block["sort"] = (perf_counter() - begin) / RESORT
        self._blocks.append(block)

    @property
    def timed(self) -> bool:
        """Whether there is a timed block."""
        return bool(self._blocks)

    def seconds(self, name: str = "step") -> float:
        """Seconds of a phase in a step, the median of all blocks.

        "step" is everything but the sort, "sort" the step's part of a sort.
        """
        return median(block[name] for block in self._blocks) if self._blocks else 0.0


def samples_of(case: Case, count: int, sizes: Sequence[int], steps: float = 1.0) -> list[Sample]:
    """Samples of a case with `count` particles, resized to about `sizes` particles.

    `steps` is the approximate number of its steps, if large.
    """
    longer = min(max(1.0, _MANY / steps), ENDLESS)

    def made(small: Case, any_will_do: bool = False) -> Sample:
        sample = Sample(lambda: Scattered(small, Serial()))
        if sample.failure and not any_will_do:
            raise RunError(sample.failure)
        return sample

    samples = []
    # Particles from a file do not become fewer with coarser cells; a mesh would be reread.
    regions = [part for body in case.bodies.values() for part in body.region.simple()]
    powers = () if any(part.FROM_FILE for part in regions) else (1.0, 0.9, 0.8, 0.7)
    for number, size in enumerate(sizes, 1):
        factor = (count / size) ** (1.0 / case.dimensions)
        # Coarse cells may be too large for some part of the case.
        for power in powers:
            if count / factor ** (power * case.dimensions) > _LARGER * size:
                break
            try:
                samples.append(made(resized(case, factor**power, longer)))
                break
            except (ValueError, CaseError, RunError):
                continue
        if len(samples) < number:
            samples.append(made(plain(case, size, longer), any_will_do=True))
    return samples
