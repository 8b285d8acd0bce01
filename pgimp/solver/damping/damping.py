"""Damping of a rank's vertices and particles, in scenes with it: forces, and rest at peaks."""

from __future__ import annotations

from math import expm1

import numpy as np

from pgimp.case.damping import Damping
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.ledger import (
    DAMPED_ENERGY,
    DAMPED_MOMENTUM,
    KINETIC_BEFORE,
    KINETIC_NOW,
    TAKEN,
)
from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.damping import (
    DampingForces,
    book_damping,
    damp_forces,
    note_kinetic_energy,
    relax,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.layer_sums import energy_beyond_lumped
from pgimp.solver.rank_state import RankState
from pgimp.solver.reduction import sum_planes
from pgimp.solver.vertices import StepPart, VertexUpdate


class VertexDamping(StepPart):
    """Damping on one rank."""

    def __init__(self, entry: Damping) -> None:
        self.entry, self._rested = entry, False
        self._forces = bool(entry.mass or entry.local)
        self._impulse = np.empty(0)
        self._now: DampingForces | None = None

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """Set all velocities to zero if the kinetic energy has passed a peak; collective.

        The energies are sums by plane, each of one rank, added up in the planes' order. They are
        stored with the other sums, so that a resumed run decides alike.
        """
        if not self.entry.kinetic:
            return
        now, before = total_sums(rank)[KINETIC_NOW : KINETIC_BEFORE + 1]
        self._rested = bool(now < before)
        if self._rested:
            bring_to_rest(rank)

    def add_forces(self, rank: RankState, update: VertexUpdate) -> None:
        """Add the forces of damping to the sums at the vertices, before the momentum update."""
        if not self._forces:
            return
        entry = self.entry
        forcing, size = update.forcing, len(rank.grid.G) // RECORD * 3
        if rank.grips and rank.grips.acts:
            held = rank.grips.undisturbed(forcing.marked[0])
            forcing = forcing._replace(marked=(held, *forcing.marked[1:]))
        if len(self._impulse) < size:
            self._impulse = np.empty(size)
        scratch = np.empty((len(rank.scene.domain.faces), 3))
        lost = -expm1(-entry.mass * update.t.dt) if entry.mass else 0.0
        self._now = DampingForces(lost, entry.local or 0.0, self._impulse, scratch)
        frame = rank.scene.domain.frame
        rank.call(damp_forces, frame, rank.grid.field, update.faces, forcing, self._now)

    def slow(self, rank: RankState, update: VertexUpdate) -> None:
        """Take half of the kick from rest."""
        if self.entry.kinetic and needed(self._rested):
            rank.call(relax, rank.grid.field, update.forcing, 1, rank.ledger)

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Book what damping took in a step, after all conditions and contact."""
        field, forcing = rank.grid.field, update.forcing
        if self._forces:
            rank.call(book_damping, field, forcing, self._now, rank.ledger)
        if self.entry.kinetic:
            rank.call(note_kinetic_energy, field, rank.ledger)


def damping_of(
    scene: Scene, _: Communicator | None = None, __: StepPart | None = None
) -> VertexDamping | None:
    """Return the damping of a scene, None without any."""
    return VertexDamping(scene.case.damping) if scene.case.damping else None


def total_sums(rank: RankState) -> np.ndarray:
    """The sums of damping over all planes, in their order, (DAMPED,); collective."""
    grid = rank.grid
    planes = rank.scene.domain.frame.vertices[0] + grid.vertices - 1
    return sum_planes(rank.comm, rank.ledger.damping[: grid.owned], grid.slab.first, planes)


def bring_to_rest(rank: RankState) -> None:
    """Set the velocities of all particles and vertices to zero, and book what they had."""
    population, particles, grid = rank.population, rank.population.up_to_date(), rank.grid
    if rank.grips:
        rank.grips.rest()
    rows, start = population.order, population.start
    taken = np.zeros((len(rank.ledger.damping), TAKEN))
    if rank.averaged_mass:
        taken[: rank.slab.layers, DAMPED_ENERGY] = energy_beyond_lumped(rank)
    m, v = particles.m[rows, None], particles.v[rows]
    if rank.scene.settings.by_vertex:  # the vertices of these bodies have it
        m = np.where(rank.scene.settings.lagrangian[particles.body[rows], None], 0.0, m)
    _add(taken, np.repeat(np.arange(len(start) - 1), np.diff(start)), m, v)
    particles.v[rows] = 0.0
    if particles.L.shape[1]:
        particles.L[rows] = 0.0
    if grid.motion:
        values = grid.by_vertex(grid.kept.values)
        velocity = values[..., KEPT_VELOCITY : KEPT_VELOCITY + 3]
        moving = velocity.any(axis=-1) & grid.kept.fields[:, None, None]
        moving[grid.owned :] = False
        m, v = values[..., KEPT_MASS][moving][:, None], velocity[moving]
        _add(taken, np.nonzero(moving)[0], m, v)
        velocity[:, grid.kept.fields] = 0.0
        population.outdated |= rank.scene.by_cells
    rank.ledger.damping[:, :TAKEN] += taken
    rank.ledger.damping[:, [KINETIC_NOW, KINETIC_BEFORE]] = 0.0


def _add(taken: np.ndarray, plane: np.ndarray, m: np.ndarray, v: np.ndarray) -> None:
    """Add energy and momentum to the sums by plane, one after the other in their order."""
    np.add.at(taken[:, DAMPED_ENERGY], plane, (0.5 * m * v * v).sum(axis=1))
    for d in range(v.shape[1]):
        np.add.at(taken[:, DAMPED_MOMENTUM + d], plane, m[:, 0] * v[:, d])
