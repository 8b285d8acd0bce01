"""Interface of a rank for the parts of a step, for type checkers; see `pgimp.solver.rank.Rank`."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.halo import Halo
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab
from pgimp.jit.bound import Bound
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene


class RankState(Protocol):
    """A rank's scene, planes, particles and books; for the attributes see `Rank`."""

    scene: Scene
    comm: Communicator
    slab: Slab
    grid: Grid
    halo: Halo
    population: Population
    ledger: Ledger
    calls: tuple[Bound, ...]
    mass_cutoff: float
    vertex_bounds: np.ndarray
    error_buffer: np.ndarray
    failed: int
    numbered: int
    timings: dict[str, float]
    errors: np.ndarray
    contact: Any
    clearances: Any
    flows: Any
    surface_kinematics: Any
    damping: Any
    averaged_mass: Any
    phases: Any
    absorbing: Any
    slaves: Any
    mean_dilatation: Any
    inflow: Any
    sinks: Any
    grips: Any
    crossings: Any
    penetration: Any
    displacement: Any

    @property
    def call(self) -> Bound:
        """Calls the kernels of a step that are common to all groups."""

    @property
    def count(self) -> int:
        """Number of the rank's particles."""

    @property
    def free(self) -> Any:
        """The free rigid bodies, equal on all ranks; None without any."""

    def lattice_cells(self) -> Any:
        """Return the cells of lattice particles."""

    def by_cells_alone(self) -> bool:
        """Return whether all particles are in cells and have no state of their own."""

    def up_to_date(self) -> Particles:
        """Return the particles, see `Population.up_to_date`."""

    def live(self) -> np.ndarray:
        """Rows of the particles in canonical order, (n,) int64."""

    def booked(self) -> Ledger:
        """Return the ledger of the planes that the rank owns."""
