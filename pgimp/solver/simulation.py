"""The simulation: a scene's particles on this rank, advanced step by step with all others."""

from time import perf_counter
from typing import Any

import numpy as np

from pgimp.case.places import located
from pgimp.case.schema import Case
from pgimp.decomposition.balance import Balance
from pgimp.decomposition.grid import Grid
from pgimp.decomposition.halo import Halo
from pgimp.decomposition.migrate import Migration
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab
from pgimp.errors import CaseError, RunError
from pgimp.jit.cache import told
from pgimp.jit.kernel import FOLDER
from pgimp.kernels.order import layers_of
from pgimp.kernels.particles import Particles
from pgimp.kernels.sums import fastest_rate
from pgimp.mpi.node import shares_cores
from pgimp.scene import nearness
from pgimp.scene.geometry import do_without, release, share
from pgimp.scene.lattice import Lattice
from pgimp.scene.scene import Scene, count_particles
from pgimp.solver.agreement import FAULT, NOTHING, PENDING, Agreement
from pgimp.solver.clock import clock_of
from pgimp.solver.decomposition import occupy, owned, rebalance, share_out
from pgimp.solver.diagnostics import Diagnostics
from pgimp.solver.faults import ROOM, Failure, collect
from pgimp.solver.memory import require
from pgimp.solver.stability import check_first_step
from pgimp.solver.state import restore
from pgimp.solver.step import PHASES, step
from pgimp.solver.warmup import warm_up
from pgimp.solver.window import open_window, shrink_window

#: Steps between two re-sorts of the particles' rows: a sort costs half a step, and a step becomes
#: slower by up to a thousandth with every step that the rows grow stale.
RESORT = 48

#: A vertex lighter than this part of the lightest initial particle is not accelerated.
LIGHT = 1e-12


class Simulation:
    """A case on the ranks of a communicator; creating it and advancing it are collective.

    Parameters
    ----------
    case : Case
        What to simulate.
    comm : communicator
        mpi4py's, or `pgimp.mpi.comm.Serial`.
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
    worked : dict of str to float
        Those in which it had a core, where ranks must share cores; else the same.
    balance : Balance
        What is known of the load of the ranks.
    particle_steps, clamped, held : int
        Particle-steps of this rank in this process; those, since the start, with a half-width
        held at one cell, and those in which a wall held a particle in.
    wish : int
        What this rank asks for, `NOTHING` to `FAULT`; it goes with the reduction of every step.
    granted : int
        The greatest wish of all ranks that has become known since the last step began, the same
        on all; `PENDING` if none has.
    faults, failed : (n, 2) int64, int
        Rows and faults of this rank's particles at fault in the last step, and their number, which
        may be greater.
    fault_room : (2, room, 2) int64
        Where the kernels write them.
    agreement : Agreement
        What all ranks say of the last step, or will have said.
    failure : Failure or None
        The step that failed; `time`, `step` and `dt` are then those of the step before.

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
    reach: np.ndarray
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
        self.worked = dict.fromkeys(PHASES, 0.0) if shares_cores(comm) else self.timings
        self.dt = 0.0
        self.particle_steps = self.clamped = self.held = 0
        self.fault_room = np.zeros((2, ROOM, 2), np.int64)
        self.faults, self.failed = self.fault_room[0, :0], 0
        self.failure: Failure | None = None
        self.wish = self.granted = NOTHING
        self.agreement = Agreement(comm)
        self._before = (0, 0.0, 0.0)  # step, time and dt before the last step
        D = scene.dimension
        self.identity = tuple(float(i == j) for i in range(D) for j in range(D))
        self.clock = clock_of(case)
        (share if source is None else do_without)(case, comm)
        require(scene, comm, None if source is None else source.count)
        warm_up(scene, self.identity, comm)
        self._tell_of_kernels()

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
        self.warnings += nearness.doubts(case)
        release(case)
        self.warnings += check_first_step(self)

    def _tell_of_kernels(self) -> None:
        """Take up, once each, what ranks have to say of the cache on their nodes."""
        said = self.comm.allgather((told(), FOLDER.warning))
        self.notes += dict.fromkeys(line for lines, _ in said for line in lines)
        self.warnings += dict.fromkeys(warning for _, warning in said if warning)

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
        mine = particles.m[:count]
        masses = comm.allgather((float(mine.min(initial=np.inf)), float(mine.sum())))
        self.lightest = LIGHT * min(least for least, _ in masses)
        total = sum(mass for _, mass in masses)
        if total > 2.0 * scene.most_mass:  # only particles from a file can
            with located(self.case):
                raise CaseError(
                    f"bodies: the particles weigh {total:.6g}, and the whole domain, filled with "
                    f"the densest material, {scene.most_mass:.6g}; look at the volumes of points"
                )
        self.population = Population(particles, count, scene.shape, scene.frame, slab, start)
        self.balance.watch(count)
        occupy(self)
        open_window(self)
        if start is None:
            scene.loads.settle(self.population, comm)
        self.faces, self.walls = scene.face_parameters(0.0, 0.0), scene.walls(0.0)
        self.diagnostic_sums = Diagnostics()
        fastest = fastest_rate(
            scene.frame, self.identity, scene.materials, self.particles, self.population.order,
            scene.material_of,
        )  # fmt: skip
        self.rate = max(comm.allgather(fastest))

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
    def agreed(self) -> bool:
        """Whether all that the ranks say of the last step is known."""
        return not self.agreement.open

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

    def advance(self, agree: bool = True) -> None:
        """Do one step; collective.

        Parameters
        ----------
        agree : bool
            Whether to wait until all ranks have done it. Otherwise it is the next step, or
            `agree`, that finds out whether it has failed.

        Raises
        ------
        RunError
            On every rank, if particles of any are at fault; that step is then done but for the
            clock, and there will be no other.
        """
        if self.failure:
            raise RunError(self.failure.text)
        self.granted = PENDING
        before = self.step, self.time, self.dt
        self.dt, end, self.failed, rate = step(self)
        self._before = before
        self.clock.advance(end)
        if self.comm.size > 1:
            self.balance.note(self.worked, self.local_count, self.step)
        wish = FAULT if self.failed else self.wish
        asked = self.agreement.asks
        self.agreement.begin(rate, wish, self.balance.asks, self.reach)
        sort = self.step % RESORT == 0
        if agree or asked or sort or self.comm.size == 1:
            self.agree()
        if not self.grid.covers(self.agreement.reach):
            self.grid.extend(self.agreement.reach)
        if asked:
            rebalance(self)
            self.agreement.asks = False
        if sort:
            self._sort()

    def agree(self) -> None:
        """Learn what all ranks say of the last step, if that is not known; collective.

        Raises
        ------
        RunError
            On every rank, as from `advance`.
        """
        agreement = self.agreement
        if not agreement.end():
            return
        known = self.granted if self.granted != PENDING else NOTHING
        self.rate, self.granted = agreement.rate, max(known, agreement.wish)
        if agreement.wish == FAULT:
            dt, end = self.dt, self.time
            step, time, self.dt = self._before
            self.clock.restore(step, time)
            self.failure = collect(self, end, dt)
            raise RunError(self.failure.text)

    def _sort(self) -> None:
        """Sort the rows anew, report the load, and shrink a window that has become far too wide."""
        begin = perf_counter()
        self.population.sort()
        self.timings["sort"] += perf_counter() - begin
        if self.comm.size > 1:
            planes = int(self.grid.active.sum())
            self.balance.report(self.comm, self.local_count, planes, self.step)
        shrink_window(self)

    def diagnostics(self) -> dict[str, float] | None:
        """The columns of history.csv, in order, on rank 0; None elsewhere; collective."""
        return self.diagnostic_sums.line(self)
