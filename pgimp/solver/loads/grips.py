"""Grips that given forces move: constraints whose velocity follows from the force.

The vertices of a grip move as one along the directions of the force. Its acceleration a is that of
a rigid body: of the vertices' mass and the mass that is added, under the force, the spring and
dashpot, and all forces at its vertices. Planes are summed in order, so that all ranks find the
same bits.
"""

from __future__ import annotations

import numpy as np

from pgimp.kernels.loads.grips import GAINED, GRIP_MASS, GRIPPED, RELAXED_MASS, sum_grips
from pgimp.mpi.communicator import Communicator
from pgimp.physics.loads.constraints import Constraint, ConstraintEntry
from pgimp.scene.scene import Scene
from pgimp.schema.time_functions import TimeFunction
from pgimp.solver.rank_state import RankState
from pgimp.solver.reduction import sum_planes
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import StepPart, VertexUpdate

#: Rows of `Grips.state`: velocity; displacement since the start; of the spring; and the impulse
#: that grips have borne in contact, which moves them in the next step.
VELOCITY, DISPLACEMENT, DEFLECTION, BORNE, STATES = 0, 1, 2, 3, 4

_NONE = np.empty(0)


class Grips(StepPart):
    """The grips of a scene that given forces move; every rank has all of them.

    Attributes
    ----------
    controls : (constraints, 3) int64
        See `pgimp.kernels.loads.grips.sum_grips`.
    state : (constraints, STATES, 3) float64
        The state of motion; zeros along other directions.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm = scene, comm
        self.entries = scene.interaction.loads.constraints
        self.controls = np.zeros((len(self.entries), 3), np.int64)
        for k, entry in enumerate(self.entries):
            if entry.field:
                self.controls[k, : scene.dimension] = 2
            for d, (v, f) in enumerate(zip(entry.motion, entry.forces, strict=True)):
                self.controls[k, d] = 2 if v is not None else int(f is not None)
        self.state = np.zeros((len(self.entries), STATES, 3))
        self._before = np.empty(0)
        self._rates = np.zeros((len(self.entries), 3))

    def start(self, rank: RankState, kept: np.ndarray | None = None) -> None:
        """Take the mean velocity of each grip's particles, with other states `kept`; collective."""
        if kept is not None:
            self.state[:] = kept
        p, (rows, start) = rank.population.up_to_date(), rank.population.ordered
        layers, number = len(start) - 1, p.constraint[rows, 0]
        sums = np.zeros((layers, len(self.entries) + 1, 4))
        layer = np.repeat(np.arange(layers), np.diff(start))
        np.add.at(sums[..., 3], (layer, number), p.m[rows])  # in canonical order
        for d in range(p.v.shape[1]):
            np.add.at(sums[..., d], (layer, number), p.m[rows] * p.v[rows, d])
        total = np.add.reduce(np.concatenate(self.comm.allgather(sums)), axis=0)[1:]
        found = total[:, :3] / np.where(total[:, 3:] > 0.0, total[:, 3:], 1.0)
        self.state[:, VELOCITY] = np.where(self.controls == 1, found, 0.0)

    def relax(self, n: int, dt: float) -> None:
        """Damp the grips that forces move, as their vertices; see `kernels.grid.damping.relax`."""
        change = (2.0 * self.state[:, VELOCITY] - dt * self._rates) / (n + 1.0)
        change[self.controls != 1] = 0.0
        self.state[:, VELOCITY] -= change
        self.state[:, DISPLACEMENT : DEFLECTION + 1] -= dt * change[:, None]

    @property
    def acts(self) -> bool:
        """Whether any force acts; else only the displacements of earlier stages are kept."""
        return bool((self.controls == 1).any())

    @property
    def moved(self) -> np.ndarray:
        """Displacements since the start, (constraints, 3)."""
        return self.state[:, DISPLACEMENT]

    def rest(self) -> None:
        """Take all velocity from the grips."""
        self.state[:, [VELOCITY, BORNE]] = 0.0

    def undisturbed(self, constraints: tuple[Constraint, ...]) -> tuple[Constraint, ...]:
        """Constraints for local damping: what a grip holds is not damped there."""
        return tuple(
            _with(one, way, (np.nan,) * 3, (0.0,) * 3)
            for one, way in zip(constraints, self.controls == 1, strict=True)
        )

    def current(self, constraints: tuple[Constraint, ...]) -> tuple[Constraint, ...]:
        """Constraints with the velocities of the grips at the step's beginning."""
        return tuple(
            _with(one, way, tuple(state[VELOCITY].tolist()), (0.0,) * 3)
            for one, way, state in zip(constraints, self.controls == 1, self.state, strict=True)
        )

    def find(self, rank: RankState, update: VertexUpdate) -> tuple[Constraint, ...]:
        """Find the velocities of the grips in a step; return all constraints; collective."""
        moved = self.controls == 1
        found = self.forecast(rank, update)
        for k, one in enumerate(found):
            velocity = np.array(one.velocity)[moved[k]]
            self.state[k, VELOCITY, moved[k]] = velocity
            self.state[k, DISPLACEMENT : DEFLECTION + 1, moved[k]] += (
                update.t.dt * velocity[:, None]
            )
            self._rates[k] = np.where(moved[k], one.rate, 0.0)
        return found

    def forecast(
        self, rank: RankState, update: VertexUpdate, A: np.ndarray = _NONE, reach: int = 0
    ) -> tuple[Constraint, ...]:
        """Return all constraints, with the motion of the grips by current forces; collective.

        Before the momentum update `A` has the accelerations; see `sum_grips`.
        """
        t, grid, forcing = update.t, rank.grid, update.forcing
        sums = np.zeros((grid.planes, len(self.entries), 3, GRIPPED))
        rank.call(sum_grips, grid.field, forcing, self.controls, A, reach, sums)
        total = self._sum(rank, sums[: grid.owned])
        constraints, found = forcing.marked[0], []
        for k, (one, entry) in enumerate(zip(constraints, self.entries, strict=True)):
            velocity, rate = [0.0] * 3, [0.0] * 3
            for d in np.flatnonzero(self.controls[k] == 1):
                rate[d] = self._acceleration(entry, k, int(d), total[k, d], t)
                velocity[d] = float(self.state[k, VELOCITY, d]) + t.dt * rate[d]
            found.append(_with(one, self.controls[k] == 1, tuple(velocity), tuple(rate)))
        return tuple(found)

    def _acceleration(
        self, entry: ConstraintEntry, k: int, d: int, sums: np.ndarray, t: Step
    ) -> float:
        """Acceleration of a grip along a direction.

        The spring acts by its deflection at the beginning, the dashpot by the mean velocity. A
        quarter of k dt^2 is added to the mass, so that no spring shortens the steps.
        """
        own, force, dt = entry.forces[d], 0.0, t.dt
        if own is not None:
            force = own.value(t.start) if isinstance(own, TimeFunction) else float(own)
        v, _, deflection, borne = self.state[k, :, d].tolist()
        stiffness, dashpot = 0.0, 0.0
        if entry.spring:
            stiffness, dashpot = entry.spring.stiffness, entry.spring.dashpot
        mass = float(sums[GRIP_MASS]) + entry.mass + 0.5 * dt * dashpot + 0.25 * dt**2 * stiffness
        gained = float(sums[GAINED]) - float(sums[RELAXED_MASS]) * v + borne
        impulse = gained + dt * (force - stiffness * deflection - dashpot * v)
        return impulse / (dt * mass) if mass > 0.0 else 0.0

    def _sum(self, rank: RankState, own: np.ndarray) -> np.ndarray:
        """Sum over all planes, in their order; collective."""
        planes = rank.scene.domain.frame.vertices[0] + rank.grid.vertices - 1
        return sum_planes(self.comm, own, rank.grid.slab.first, planes)

    def await_contact(self, rank: RankState) -> None:
        """Note what constraints have given before contact at vertices that they hold."""
        if self.acts and rank.contact.bears:
            self._before = rank.ledger.constraint_impulse[: rank.grid.owned].copy()

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Note the impulses of contact that the grips have borne; collective."""
        if self.acts and rank.contact.bears:
            now = rank.ledger.constraint_impulse[: rank.grid.owned]
            borne = self._sum(rank, self._before - now)[: len(self.entries)]
            self.state[:, BORNE] = np.where(self.controls == 1, borne, 0.0)


def _with(
    one: Constraint, way: np.ndarray, velocity: tuple[float, ...], rate: tuple[float, ...]
) -> Constraint:
    """Return a constraint that also holds the directions of a force, with these velocities."""
    held, v, a = (
        [new if own else old for own, new, old in zip(way, more, given, strict=True)]
        for more, given in zip((way.tolist(), velocity, rate), one[:3], strict=True)
    )
    return one._replace(
        held=(bool(held[0]), bool(held[1]), bool(held[2])),
        velocity=(v[0], v[1], v[2]),
        rate=(a[0], a[1], a[2]),
    )


def grips_of(scene: Scene, comm: Communicator, before: Grips | None = None) -> Grips | None:
    """Return the grips that given forces move in a scene, or did `before`; None without any.

    Without constraints there are none: those that a stage has ended leave nothing.
    """
    every = scene.case.constraints.values()
    forced = any(f is not None for entry in every for f in entry.force)
    return Grips(scene, comm) if forced or (before and every) else None
