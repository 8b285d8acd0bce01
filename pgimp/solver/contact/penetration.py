"""Rigid bodies that hold particles out: their state at a step's end, and their impulses."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.hold import PenetrationLimits, count_inside, count_near
from pgimp.kernels.data.arguments import Forcing, Order
from pgimp.kernels.data.ledger import RIGID_WORK
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.rigid.bodies import MOTION, RigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.physics.rigid import Motion
from pgimp.scene.rigid.free_body import State
from pgimp.scene.rigid.rigid import SceneRigidBodies
from pgimp.scene.rigid.rotation import solve
from pgimp.scene.scene import Scene
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.rank_state import RankState
from pgimp.solver.reduction import place_planes
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import StepPart

#: Depth in a rigid body, in cells, from which a particle counts as inside.
QUARTER = 0.25


def placed(rigid_bodies: SceneRigidBodies, time: float, states: list[State] | None) -> RigidBodies:
    """Return rigid bodies with their positions and velocities at a time."""
    kept, states = rigid_bodies.arrays(), rigid_bodies.first if states is None else states
    if not kept.motion["rotation"].any():  # never placed yet
        rigid_bodies.at(time, time, states)
    motion = kept.motion.view(np.float64).copy().view(MOTION)  # all at once, not field by field
    free = dict(zip(rigid_bodies.free, states, strict=True))
    for number in rigid_bodies.moving:
        row, rigid = motion[number], rigid_bodies.entries[number].rigid
        rigid_bodies.place(row, number, rigid_bodies.pose(number, time, free), time, free)
        if isinstance(rigid, Motion):
            linear, angular = rigid.velocities(time)
            row["velocity_after"] = linear + angular
    for (number, body), state in zip(rigid_bodies.free.items(), states, strict=True):
        motion["velocity_after"][number] = body.velocities(state)
    return kept._replace(motion=motion, responses=())


class PenetrationCorrection(StepPart):
    """The rigid bodies of a scene that hold particles out, on one rank."""

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm = scene, comm
        self._impulses = np.zeros((0, len(scene.interaction.rigid_bodies), 6))
        self._compliance = np.zeros((len(scene.interaction.rigid_bodies), 6, 6))
        self._kept: Any = ()
        self._call = Bound()
        self._moves = any(entry.moves for entry in scene.interaction.rigid_bodies.entries)

    def force_particles(self, rank: RankState, order: Order, t: Step, forcing: Forcing) -> Forcing:
        """Add the data to hold particles out at the end of a step; collective."""
        pairs, free = self.scene.interaction.pairs, rank.free
        assert pairs is not None
        if len(self._impulses) != rank.slab.layers:
            self._impulses = np.zeros((rank.slab.layers, *self._impulses.shape[1:]))
            self._kept = ()
        if not self._kept or self._moves:
            states, population = free.states if free else None, rank.population
            bodies = placed(self.scene.interaction.rigid_bodies, t.end, states)
            if free:
                mass = self._near(bodies, population.columns, population.order)
                self._set_compliance(free, mass)
            self._kept = PenetrationLimits(bodies, pairs, self._compliance, self._impulses)
        return forcing._replace(limits=self._kept)

    def _set_compliance(self, free: FreeBodies, mass: np.ndarray) -> None:
        """Set the velocities of each free body per impulse and moment, times a mass."""
        for number, (body, state) in free.now.items():
            M = body.mass_matrix(body.inertia(state.turn))
            for i in range(6):
                if body.may[i]:
                    unit = [float(mass[number]) * (j == i) for j in range(6)]
                    self._compliance[number, i] = solve(M, unit)

    def _near(
        self, rigid_bodies: RigidBodies, particles: Particles, rows: np.ndarray
    ) -> np.ndarray:
        """Bounds of the mass that each body may hold in a step, equal on any number of ranks."""
        counts, most = (
            np.zeros(len(rigid_bodies.motion), np.int64),
            np.zeros(len(rigid_bodies.motion)),
        )
        cell = max(self.scene.domain.frame.cell)
        self._call(count_near, rigid_bodies, particles, rows, 2.0 * cell, counts, most)
        if self.comm.size > 1:
            every = np.array(self.comm.allgather((counts, most)))
            counts, most = every[:, 0].sum(axis=0), every[:, 1].max(axis=0)
        return counts * most

    def complete(self, rank: RankState) -> None:
        """Give free bodies the impulses of the particles that they held; collective.

        The work of these bodies is booked in the domain's first layer.
        """
        free, ledger = rank.free, rank.ledger
        if not free or not self._kept:
            return
        numbers, first = free.numbers, int(rank.grid.window.lower[0])
        layers = self.scene.domain.frame.vertices[0]
        every = place_planes(self.comm, self._impulses[:, numbers], first, layers)
        self._impulses.fill(0.0)
        work = _push(free, np.add.reduce(free.in_order(every, 0), axis=0))
        if self.comm.rank == 0 and len(ledger.work):
            ledger.work[0] += sum(work)
            ledger.rigid_bodies[0, numbers, RIGID_WORK] += work


def penetration_of(
    scene: Scene, comm: Communicator, _: PenetrationCorrection | None = None
) -> PenetrationCorrection | None:
    """Return the rigid bodies that hold particles out; None without any."""
    bodies, settings = scene.interaction.rigid_bodies, scene.settings
    if not bodies or not scene.interaction.pairs or (settings.initial and not settings.mixed):
        return None
    return PenetrationCorrection(scene, comm)


def particles_inside(rank: RankState, rows: np.ndarray, time: float, depth: float) -> np.ndarray:
    """Count this rank's particles that are deeper than `depth` cells in each rigid body.

    Parameters
    ----------
    rows : (n,) int32
        Rows of the particles.
    depth : float
        In smallest sides of a cell.

    Returns
    -------
    (rigid bodies,) int64
    """
    scene, bodies = rank.scene, rank.scene.interaction.rigid_bodies
    counts = np.zeros(len(bodies), np.int64)
    if len(counts) and scene.interaction.pairs:
        at = placed(bodies, time, rank.free.states if rank.free else None)
        deep = depth * min(scene.domain.frame.cell)
        particles, exact = rank.up_to_date(), scene.settings.exact_surfaces
        if exact.any():  # such are at their centroids
            offset = np.where(exact[particles.body][:, None], 0.0, particles.offset)
            particles = particles._replace(offset=offset)
        count_inside(at, scene.interaction.pairs, particles, rows, deep, counts)
    return counts


def _push(free: FreeBodies, given: np.ndarray) -> list[float]:
    """Apply impulse and moment, (bodies, 6), at once; return the energy lost by each."""
    lost = []
    for number, (body, J) in enumerate(zip(free.bodies, given.tolist(), strict=True)):
        state, before = free.states[number], body.energy(free.states[number])
        if any(J):
            free.states[number] = state = body.pushed(state, J)
        lost.append(before - body.energy(state))
    return lost
