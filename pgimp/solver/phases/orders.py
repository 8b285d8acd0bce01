"""Orders of phases other than `stress: last`: strain before the forces, and mapped velocities.

With `last` particles strain and move by the new velocities of the vertices, g + dt A, though their
own change by S dt A only. So forces do more work than particles gain: they lose dt A (1 - S) A in
each step. The energy of particles grows by dt f (g + g')/2, with the velocities g and g' that they
give the vertices before and after a step. So with `average` they strain by g for half a step before
the forces, and by g' for half a step after them: the work is the gain. They move by g'.

Between the forces of two steps both halves are of one motion, with the same velocities of particles
from positions before and after it. Forces and strain of a step have its weights. Both g and g'
satisfy the conditions of faces, constraints and contact. Nothing else outlasts the step: F and the
stress of particles at its end are those in the middle of their last motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pgimp.kernels.data.arguments import Field, Forcing, Order, Phase
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.record import FORCE
from pgimp.kernels.grid.constraints import apply_constraints
from pgimp.kernels.grid.image_values import ALL, fold_values
from pgimp.kernels.grid.mirror import fold, reflect
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.step.mapped import MappedMomentum
from pgimp.kernels.step.strain import strain_particles
from pgimp.kernels.update.phases import Strain
from pgimp.mpi.communicator import Communicator
from pgimp.physics.shapes.phases import STRAIN_BEFORE
from pgimp.scene.scene import Scene
from pgimp.solver.particle_groups import ParticleGroup
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.transfers import finish_sums, sum_particles
from pgimp.solver.vertex_sums import VertexSums
from pgimp.solver.vertices import StepPart, VertexUpdate, fold_mirrors


class Phases(StepPart):
    """The strain before forces and the mapped velocities of a rank."""

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.before = scene, STRAIN_BEFORE[scene.case.method.stress]
        unknown: Any = ()
        self._sums = VertexSums(scene, comm, unknown)
        self._F = self._v = self._L = np.empty((0, 0))
        self._books: tuple[Ledger, Ledger] | None = None

    @property
    def field(self) -> Field:
        """The field that moves and strains particles: velocities mapped from them."""
        return self._sums.grid.field

    def strain(
        self, rank: RankState, groups: Sequence[ParticleGroup], update: VertexUpdate, loads: Loads
    ) -> None:
        """Strain by the velocities at the beginning, and sum anew with the stress; collective."""
        population, grid = rank.population, rank.grid
        columns, contact = population.up_to_date(), rank.contact
        if self._F.shape != columns.F.shape:
            self._F, self._v = np.empty_like(columns.F), np.empty_like(columns.v)
            self._L = np.empty_like(columns.L)
        self._still = self._free_of_forces(rank, update)
        if not self.before:
            return
        grid.by_vertex(grid.G)[grid.active > 0, ..., FORCE:] = 0.0
        fold_mirrors(rank, self._still)
        self._hold(rank, grid.field)
        strain = Strain(self.before * update.t.dt, loads, update.forcing.gravity)
        rank.call(
            strain_particles, groups[0].setting, grid.field, columns, groups[0].order, strain,
            self._F, rank.ledger,
        )  # fmt: skip
        marked = bool(update.forcing.marked)
        sum_particles(rank, groups, loads, marked)
        finish_sums(rank, groups, marked)
        if contact.data and (self.scene.domain.seams or self.scene.domain.mirrors):
            contact.detect(rank, update.t, rank.ledger)  # its sums have been folded

    def force_particles(self, rank: RankState, order: Order, t: Step, forcing: Forcing) -> Forcing:
        """Map the new velocities to the vertices, for the rest of the strain; collective."""
        columns, loads, grid = rank.population.up_to_date(), forcing.loads, rank.grid
        self._sums.quantity = MappedMomentum(
            grid.field,
            t.dt,
            loads.relaxation,
            loads.affine,
            self._v,
            self._L,
            forcing.gravity,
            rank.ledger.work,
        )
        self._sums.fit(grid, rank.contact.fields)
        self._sums.add(columns, order, np.arange(grid.planes))
        field, domain, still = self.field, self.scene.domain, self._still
        for seam in domain.seams:
            rank.call(fold_values, domain.frame, field, seam, ALL, True)
        if still.forcing.marked:
            marked = forcing.constraints, *still.forcing.marked[1:]
            self._still = still._replace(forcing=still.forcing._replace(marked=marked))
        for releases in (False, True):
            for mirror in (*domain.absorbing_mirrors, *domain.mirrors):
                if mirror.releases == releases:
                    rank.call(fold, domain.frame, field, mirror, still.forcing, still.ledger)
        self._hold(rank, field)
        strained = columns._replace(F=self._F) if self.before else columns
        return forcing._replace(phase=Phase((1.0 - self.before) * t.dt, strained, self._v))

    def _free_of_forces(self, rank: RankState, update: VertexUpdate) -> VertexUpdate:
        """The step's conditions for velocities that no force changes; nothing is booked."""
        if self._books is None or self._books[0] is not rank.ledger:
            self._books = rank.ledger, Ledger(*(np.zeros_like(part) for part in rank.ledger))
        marked = update.forcing.marked
        if rank.grips and marked:
            marked = rank.grips.current(marked[0]), *marked[1:]
        forcing = update.forcing._replace(gravity=(0.0, 0.0, 0.0), marked=marked)
        return update._replace(forcing=forcing, ledger=self._books[1])

    def _hold(self, rank: RankState, field: Field) -> None:
        """Let momenta become velocities that satisfy faces, contact and constraints."""
        still, domain = self._still, self.scene.domain
        rank.contact.hold(rank, still, field)
        if still.forcing.marked:
            rank.call(apply_constraints, field, still.forcing, still.ledger)
        for images in reversed((*domain.seams, *domain.absorbing_mirrors, *domain.mirrors)):
            rank.call(reflect, domain.frame, field, images, still.forcing, still.ledger)


def phases_of(scene: Scene, comm: Communicator, _: Phases | None = None) -> Phases | None:
    """Return what a scene's order of phases adds to a step; None where stress is last."""
    if scene.settings.initial or scene.case.method.stress == "last":
        return None
    return Phases(scene, comm)
