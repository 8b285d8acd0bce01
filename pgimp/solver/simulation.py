"""The simulation: a scene's particles on this rank, advanced step by step with all others."""

from time import perf_counter
from typing import Any

import numpy as np

from pgimp.case.schema import Case
from pgimp.errors import RunError
from pgimp.kernels.jit import discard_damaged
from pgimp.kernels.order import layers_of
from pgimp.kernels.sums import fastest_rate
from pgimp.materials.outside import explained
from pgimp.parallel.halo import Halo
from pgimp.parallel.migrate import Migration
from pgimp.parallel.node import one_rank_first
from pgimp.parallel.slabs import Slab
from pgimp.scene.geometry import do_without, release, share
from pgimp.scene.lattice import Lattice
from pgimp.scene.scene import Scene, count_particles
from pgimp.solver.balance import Balance
from pgimp.solver.clock import clock_of
from pgimp.solver.decomposition import occupy, owned, rebalance, share_out
from pgimp.solver.diagnostics import Diagnostics
from pgimp.solver.faults import ROOM, Failure, collect
from pgimp.solver.grid import Grid
from pgimp.solver.memory import require
from pgimp.solver.particles import Particles
from pgimp.solver.population import Population
from pgimp.solver.stability import doubt, require_end, require_stable
from pgimp.solver.state import restore
from pgimp.solver.step import PHASES, step
from pgimp.solver.warmup import warm_up

#: Steps between two re-sorts of the particles' rows: a sort costs half a step, and a step becomes
#: slower by up to a thousandth with every step that the rows grow stale.
RESORT = 48

#: A vertex lighter than this part of the lightest initial particle is not accelerated.
LIGHT = 1e-12

#: What a rank may wish for after a step; the greatest wish of all ranks is granted on all.
#: PENDING: the rank still waits for the disk, see `pgimp.output.frames`.
NOTHING, PENDING, CHECKPOINT, STOP, FAULT = range(5)


class Simulation:
    """A case on the ranks of a communicator; creating it and advancing it are collective.

    Parameters
    ----------
    case : Case
        What to simulate.
    comm : communicator
        mpi4py's, or `pgimp.parallel.comm.Serial`.
    source : CheckpointFile, optional
        The state to go on from; without it the case begins.

    Attributes
    ----------
    time, step, dt : float, int, float
        Simulated time, steps done, length of the last step (0 before the first).
    finished : bool
        Whether the end of the case is reached.
    count : int
        Particles of all ranks at the start, which is one more than the greatest id; see `present`.
    local_count : int
        Particles of this rank.
    particles : Particles
        This rank's; rows of living particles are given by `live`.
    notes, warnings : list of str
        What the user should know, the same on every rank.
    timings : dict of str to float
        Seconds spent in each phase by this rank.
    balance : Balance
        What is known of the load of the ranks.
    particle_steps, clamped : int
        Particle-steps of this rank in this process, and those, since the start, with a half-width
        held at one cell.
    wish : int
        What this rank asks for, `NOTHING` to `FAULT`; it goes with the reduction of every step.
    granted : int
        The greatest wish of all ranks at the end of the last step, the same on all.
    faults, failed : (room, 2) int64, int
        Rows and faults of this rank's particles at fault, and their number, which may be greater.
    failure : Failure or None
        The step that failed.

    Raises
    ------
    CaseError
        The same on every rank, for what only the scene's particles show.
    DamagedError
        The same on every rank, if the checkpoint does not hold a state of this case.
    """

    slab: Slab
    balance: Balance
    grid: Grid
    halo: Halo
    migration: Migration
    owned_planes: int
    work: np.ndarray
    impulse: np.ndarray
    beyond: np.ndarray
    grip_impulse: np.ndarray
    escaped: np.ndarray

    def __init__(self, case: Case, comm: Any, source: Any = None) -> None:
        self.case, self.comm = case, comm
        self.scene = scene = Scene(case)
        self.notes: list[str] = []
        self.warnings: list[str] = []
        self.timings = dict.fromkeys((*PHASES, "sort", "balance"), 0.0)
        self.dt = 0.0
        self.particle_steps = self.clamped = 0
        self.faults, self.failed = np.zeros((ROOM, 2), np.int64), 0
        self.failure: Failure | None = None
        self.wish = self.granted = NOTHING
        self._wishes = np.zeros((2, 7))  # this rank's, and the greatest of all
        if comm.size > 1:
            from mpi4py import MPI

            self._greatest = MPI.MAX
        D = scene.dimension
        self.identity = tuple(float(i == j) for i in range(D) for j in range(D))
        self.clock = clock_of(case)
        (share if source is None else do_without)(case, comm)
        require(scene, comm, None if source is None else source.count)
        with one_rank_first(comm), explained(scene.materials, D):
            discard_damaged(lambda: warm_up(scene, self.identity))

        if source is not None:
            restore(self, source)
            return
        lattice, counts, notes = count_particles(scene, comm)
        self.notes += notes
        self.count = int(counts.sum())
        require(scene, comm, self.count)
        layer = np.empty(len(lattice.coordinates[0]), np.int64)
        layers_of(scene.shape, scene.frame, self.identity, lattice.coordinates[0], layer)
        self.decompose(np.bincount(layer, counts.sum(axis=0), scene.frame.vertices[0]))
        self.settle(*self._create(lattice, counts, layer))
        release(case)
        self._check_step()

    def _create(
        self, lattice: Lattice, counts: np.ndarray, layer: np.ndarray
    ) -> tuple[Particles, int]:
        """Particles of this rank's layers, and their number; `layer` holds that of each plane."""
        own = np.searchsorted(layer, (self.slab.first, self.slab.first + self.slab.layers))
        begin, end = int(own[0]), int(own[1])
        particles = self.scene.populate(lattice, counts, (begin, end), owned(self))
        return particles, int(np.count_nonzero(particles.m))

    def decompose(self, layer_counts: np.ndarray) -> None:
        """Give each rank its layers, so that no rank has more particles than need be."""
        share_out(self, layer_counts, RESORT)

    def settle(self, particles: Particles, count: int, start: np.ndarray | None = None) -> None:
        """Put this rank's particles in order, and make grid and accumulators for them.

        With `start`, the beginnings of the layers, they are in order and have all they carry.
        """
        scene, comm, slab = self.scene, self.comm, self.slab
        masses = comm.allgather(float(particles.m[:count].min(initial=np.inf)))
        self.lightest = LIGHT * min(masses)
        self.population = Population(particles, count, scene.shape, scene.frame, slab, start)
        self.balance.watch(count)
        occupy(self)
        self.reach = self._agree_on_reach(self.population.reach())
        self.grid.cover(self.reach)
        self.reach[:] = self.grid.base
        if start is None:
            scene.loads.settle(self.population, comm)
        self.faces = scene.face_parameters(0.0, 0.0)
        self.diagnostic_sums = Diagnostics()
        rates = comm.allgather(self._fastest())
        self.rate = max(rates)

    def _fastest(self) -> float:
        scene, population = self.scene, self.population
        return fastest_rate(
            scene.frame, self.identity, scene.materials, population.particles,
            population.order, scene.material_of,
        )  # fmt: skip

    def _agree_on_reach(self, reach: np.ndarray) -> np.ndarray:
        """Least and greatest first vertices of all ranks; 0 where there are no particles."""
        if self.comm.size > 1:
            every = np.array(self.comm.allgather(reach))
            reach = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
        return np.where(reach[0] > reach[1], 0, reach)

    def _check_step(self) -> None:
        """Compare the step with the stability limit."""
        require_end(self.scene, self.rate)
        dt = self.clock.next(self.rate)[0]
        stable = self.case.method.stable
        require_stable(dt, self.rate, stable)
        if warning := doubt(dt, self.rate, stable):
            self.warnings.append(warning)

    @property
    def time(self) -> float:
        """Simulated time."""
        return self.clock.time

    @property
    def step(self) -> int:
        """Steps done."""
        return self.clock.step

    @property
    def finished(self) -> bool:
        """Whether the end of the case is reached."""
        return self.clock.finished

    @property
    def particles(self) -> Particles:
        """The particles of this rank, with holes; see `live`."""
        return self.population.particles

    @property
    def local_count(self) -> int:
        """Number of this rank's particles."""
        return len(self.population.order)

    @property
    def known_count(self) -> int:
        """Particles of all ranks, where there are several as of the last re-sort."""
        return self.balance.total if self.comm.size > 1 else self.local_count

    def present(self) -> int:
        """Particles of all ranks now; collective."""
        return int(self.comm.allreduce(self.local_count))

    def live(self) -> np.ndarray:
        """Rows of this rank's particles in canonical order, (n,) int64."""
        return self.population.order.astype(np.int64)

    def advance(self) -> None:
        """Do one step.

        Raises
        ------
        RunError
            On every rank, if particles of any are at fault; the step is then done but for the
            clock, and there will be no other.
        """
        if self.failure:
            raise RunError(self.failure.text)
        dt, end = self.clock.next(self.rate)
        self.failed, rate = step(self, dt, end)
        if self.comm.size > 1:
            self.balance.note(self.timings, self.local_count)
        if self.failed:
            self.wish = FAULT
        self._agree(rate)
        if self.granted == FAULT:
            self.failure = collect(self, end, dt)
            raise RunError(self.failure.text)
        self.dt = dt
        self.clock.advance(end)
        if self.comm.size > 1 and self._wishes[1, 6]:
            rebalance(self)
        if self.step % RESORT == 0:
            self._sort()

    def _agree(self, rate: float) -> None:
        """Let all ranks know the greatest speed and wish, and the window that all need."""
        self.rate, self.granted = rate, self.wish
        if self.comm.size > 1:
            mine, every = self._wishes
            mine[0], mine[5], mine[6] = rate, self.wish, self.balance.asks
            np.negative(self.reach[0], out=mine[1:3])
            mine[3:5] = self.reach[1]
            self.comm.Allreduce(mine, every, self._greatest)
            self.rate, self.granted = float(every[0]), int(every[5])
            np.negative(every[1:3], out=self.reach[0], casting="unsafe")
            self.reach[1] = every[3:5]
        if not self.grid.covers(self.reach):
            self.grid.extend(self.reach)
            self.reach[:] = self.grid.base

    def _sort(self) -> None:
        """Sort the rows anew, report the load, and shrink a window that has become far too wide."""
        begin = perf_counter()
        self.population.sort()
        self.timings["sort"] += perf_counter() - begin
        if self.comm.size > 1:
            planes = int(self.grid.active.sum())
            self.balance.report(self.comm, self.local_count, planes, self.step)
        reach = self._agree_on_reach(self.population.reach())
        needed = np.prod(np.maximum(reach[1] - reach[0], 0) + 4.0)
        stored = np.prod(self.grid.base[1] - self.grid.base[0] + 1.0)
        if stored > 2.0 * needed + 64.0:
            self.grid.cover(reach)
            self.reach[:] = self.grid.base

    def diagnostics(self) -> dict[str, float] | None:
        """The columns of history.csv, in order, on rank 0; None elsewhere; collective."""
        return self.diagnostic_sums.line(self)
