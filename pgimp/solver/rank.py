"""One rank's part of a simulation: its slab's particles, grid, messages and ledger."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pgimp.case.gauges import flux_gauges
from pgimp.decomposition.grid import LAG, Grid
from pgimp.decomposition.halo import Halo
from pgimp.decomposition.migrate import Migration
from pgimp.decomposition.population import Population
from pgimp.decomposition.redistribute import redistribute
from pgimp.decomposition.slabs import Slab, slab_of
from pgimp.jit.bound import Bound
from pgimp.kernels.data.ledger import DAMPED, Ledger
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.node import shares_cores
from pgimp.scene.scene import Scene
from pgimp.solver.contact.clearances import Clearances
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.contact.kinds import contact_kind
from pgimp.solver.lagrangian.cells import LatticeCells, find_cells
from pgimp.solver.lagrangian.displacement import Displacement
from pgimp.solver.parts import PARTS, parts_of
from pgimp.solver.time.stopwatch import stopwatch

#: Phases of a step, as `Rank.timings` names them, and what each is for.
PHASES = {
    "P2G": "particles to grid: mass, momentum and forces of the vertices",
    "exchange": "sums of shared planes, from and for the neighbours; the step's length",
    "contact": "contact of bodies, and rigid bodies",
    "momentum": "velocities of the vertices, with walls and constraints",
    "G2P": "grid to particles: velocity, position, deformation, stress",
    "migrate": "particles that change the rank",
    "order": "the canonical order of the particles, restored",
}

#: Tag of messages with the motion of shared planes.
_MOTION = 8

#: Particles at fault that are listed on each rank; further ones are only counted.
MOST_LISTED = 1024


class Rank:
    """One rank's part of a simulation; `move` changes its slab.

    Parameters
    ----------
    slab : Slab
        The rank's layers.
    particles : Particles
        Particles of these layers.
    count : int
        Number of particles.
    start : (layers + 1,) int64, optional
        Beginnings of the layers, for particles in canonical order.

    Attributes
    ----------
    population : Population
        The particles in their order.
    grid, halo, migration : Grid, Halo, Migration
        The slab's planes, and the messages to the neighbours.
    ledger : Ledger
        Sums booked by plane.
    contact : NoContact
        The contact of bodies, or one of its kinds.
    displacement : Displacement
        Updates of lattice particles, in the initial configuration.
    parts_rate : float
        The greatest `rate` of these.
    calls : tuple of Bound
        Calls of a step's kernels, for each group; see `pgimp.solver.particle_groups`.
    mass_cutoff : float
        Mass below which a vertex is not accelerated.
    vertex_bounds : (2, 2) int64
        First vertices of the particles' supports so far, see `StepReduction`.
    timings : dict of str to float
        Seconds spent in each phase.
    worked : dict of str to float
        CPU seconds, where ranks share cores; else equal to `timings`.
    numbered : int
        Particles that all ranks have had so far: the number of the next one.
    particle_steps, clamped, held : int
        Particle-steps in this process. Since the start, particle-steps with a half-width clamped to
        one cell, and with a particle held in by a wall.
    errors, failed : (n, 2) int64, int
        Rows and errors of particles at fault in the last step; their number, which may be greater.
    error_buffer : (calls, size, 2) int64
        Where the kernels write them.
    """

    # The parts of a step of `pgimp.solver.parts`.
    surface_kinematics: Any
    grips: Any
    absorbing: Any
    slaves: Any
    mean_dilatation: Any
    damping: Any
    averaged_mass: Any
    phases: Any
    crossings: Any
    flows: Any
    penetration: Any
    sinks: Any
    inflow: Any

    def __init__(
        self,
        scene: Scene,
        comm: Communicator,
        slab: Slab,
        particles: Particles,
        count: int,
        start: np.ndarray | None = None,
    ) -> None:
        self.scene, self.comm = scene, comm
        self.mass_cutoff = 0.0
        self.calls = tuple(Bound() for _ in range(1 + scene.settings.mixed))
        self.population = Population(
            particles, count, scene.settings.shape, scene.order_frame, slab, start
        )
        self.timings = dict.fromkeys((*PHASES, "sort", "balance"), 0.0)
        self.worked = dict.fromkeys(PHASES, 0.0) if shares_cores(comm) else self.timings
        self.particle_steps = self.clamped = self.held = self.numbered = 0
        self.error_buffer = np.zeros((2 * (1 + scene.settings.mixed), MOST_LISTED, 2), np.int64)
        self.errors, self.failed = self.error_buffer[0, :0], 0
        self.vertex_bounds = np.zeros((2, 2), np.int64)
        self._equip()
        self._lattice: LatticeCells | None = None
        self.displacement = Displacement(self)
        self.population.update = self.displacement.update
        #: Whether the layers have changed since rows were last sorted.
        self.moved = False
        self._allocate(slab)

    def _equip(self) -> None:
        """Make what the scene needs beside grid and particles; parts go on from those before."""
        scene, comm = self.scene, self.comm
        before, self.contact = getattr(self, "contact", None), contact_kind(scene)(scene, comm)
        if before:
            self.contact.follow(before)
        self.clearances = Clearances(scene)
        for name, make in PARTS.items():
            setattr(self, name, make(scene, comm, getattr(self, name, None)))
        self.parts_rate = max((part.rate for part in parts_of(self)), default=0.0)

    def _allocate(self, slab: Slab) -> None:
        """Allocate grid, messages and ledger for a slab; the window is still to be set."""
        scene, comm = self.scene, self.comm
        self.slab, self._lattice = slab, None
        lag = LAG if comm.size > 1 and not scene.settings.initial else 0
        bounds = scene.domain.bounds if scene.settings.initial else None
        self.grid = Grid(
            scene.domain.frame, scene.settings.vertices, slab, lag, self.contact.fields, bounds,
            scene.settings.lagrangian_bodies, scene.domain.periodic,
        )  # fmt: skip
        self.grid.weighs = bool(scene.interaction.loads.least_parts.any())
        self.halo = Halo(comm, slab, scene.settings.vertices - 1)
        self.migration = Migration(comm, slab, self.population.columns, scene.domain.ring_layers)
        bodies, settings = len(scene.body_names), scene.settings
        outflow = (bodies, scene.materials.sums) if settings.escapes else (0, 0)
        constraints = len(scene.interaction.loads.booked_constraints)
        contacts = len(scene.interaction.pairs.kind) if scene.interaction.pairs else 0
        placed = contacts if scene.settings.by_vertex else 0
        self.ledger = Ledger.empty(
            self.grid.planes, len(scene.domain.faces), constraints, outflow, contacts,
            len(scene.interaction.rigid_bodies),
            (bodies if scene.interaction.flows else 0,
             DAMPED if settings.damps or settings.settles else 0,
             len(flux_gauges(scene.case.gauges)), len(scene.interaction.loads.booked_tractions),
             placed),
        )  # fmt: skip

    def lattice_cells(self) -> LatticeCells:
        """Return the cells of lattice particles, in the initial configuration; found once."""
        if self._lattice is None:
            self._lattice = find_cells(self)
        return self._lattice

    def outdate_cells(self) -> None:
        """Note that cells of lattice particles have to be found anew."""
        self._lattice = None

    def by_cells_alone(self) -> bool:
        """Return whether all particles are in cells and have no state of their own."""
        return self.scene.stateless and not len(self.lattice_cells().off_lattice.rows)

    def sort(self) -> None:
        """Sort the particles' rows."""
        self.population.sort()
        self.moved, self._lattice = False, None

    @property
    def call(self) -> Bound:
        """Calls the kernels of a step that are common to all groups."""
        return self.calls[0]

    def up_to_date(self) -> Particles:
        """Return the particles, with holes; see `live` and `Population.up_to_date`."""
        return self.population.up_to_date()

    @property
    def count(self) -> int:
        """Number of the rank's particles."""
        return len(self.population.order)

    @property
    def migrates(self) -> bool:
        """Whether particles may migrate to or from other ranks in a step."""
        apart = self.slab.neighbours and self.slab.lower != self.comm.rank
        return apart and not self.scene.settings.initial

    @property
    def free(self) -> FreeBodies | None:
        """The free rigid bodies, equal on all ranks; None without any."""
        return self.contact.free

    def fastest(self, rate: float) -> float:
        """Cells crossed in a unit of time by waves and particles, `rate`, or by rigid bodies.

        At least the rate of the parts of a step.
        """
        rate, free = max(rate, self.scene.interaction.rigid_bodies.rate, self.parts_rate), self.free
        return max(rate, free.rate) if free else rate

    def live(self) -> np.ndarray:
        """Rows of the particles in canonical order, (n,) int64."""
        return self.population.order.astype(np.int64)

    def booked(self) -> Ledger:
        """Return the ledger of the planes that the rank owns."""
        return self.ledger.first(self.grid.owned)

    def move(self, old: list[int], new: list[int]) -> None:
        """Change the decomposition between two steps; collective.

        No bit of the results depends on it.

        Parameters
        ----------
        old, new : list of int
            As from `pgimp.decomposition.slabs.cut`, equal on every rank.
        """
        window, ring = self.grid.base, self.scene.domain.ring
        extra = self.scene.settings.vertices - 1 if ring is None else 0
        owned = (*self.booked(), *self.grid.owned_motion())
        sums = redistribute(self.comm, old, new, extra, self.population, owned, ring)
        self.moved = True
        self._allocate(slab_of(new, self.comm.rank, ring))
        self.contact.moved()
        self.grid.store(window)
        for mine, values in zip((*self.booked(), *self.grid.owned_motion()), sums, strict=True):
            mine[:] = values
        self.share_motion()

    def share_motion(self) -> None:
        """Get the motion of shared planes from the upper neighbour, which owns them; collective."""
        if not self.grid.motion:
            return
        values, owned = self.grid.by_vertex(self.grid.kept.values), self.grid.owned
        lower, upper = self.slab.lower, self.slab.upper
        if lower == self.comm.rank:
            values[owned:] = values[: self.grid.shared_lower]
            return
        sent = None
        if lower is not None:
            sent = self.comm.isend(values[: self.grid.shared_lower].copy(), lower, _MOTION)
        if upper is not None:
            values[owned:] = self.comm.recv(source=upper, tag=_MOTION)
        if sent is not None:
            sent.wait()

    def drop_gradients(self) -> None:
        """Drop the particles' velocity gradients, which only the vertices' start needed."""
        particles, ring = self.population.up_to_date(), self.scene.domain.ring_layers
        self.population.replace(particles._replace(L=np.zeros((particles.capacity, 0))))
        self.migration = Migration(self.comm, self.slab, self.population.columns, ring)

    def enter(self, scene: Scene, particles: Particles) -> None:
        """Change to the scene of another stage between two steps; the ledger starts from zero.

        It has the same bodies, and the particles the columns of the scene.
        """
        window, self.scene = self.grid.base, scene
        self.calls = tuple(Bound() for _ in range(1 + scene.settings.mixed))
        self.population.replace(particles)
        self._equip()
        self._allocate(self.slab)
        self.grid.store(window)

    def stopwatch(self) -> Callable[[str], None]:
        """Return a function that adds the time since its last call to a phase."""
        return stopwatch(self.timings, self.worked)
