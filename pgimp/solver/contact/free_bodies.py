"""Free rigid bodies: their velocities at a step's end, and their states.

The impulses on a body at the vertices depend on its velocity at the end, which depends on them.
Newton's method solves for both together, so that no ratio of masses shortens the steps. However
large the residual, the body gets exactly the momentum that the material loses.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor, hypot, inf
from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.errors import EndlessError
from pgimp.kernels.rigid.bodies import RESPONSE, RigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.scene.rigid.checks import may_collide, require_clear
from pgimp.scene.rigid.free_body import FreeBody, State
from pgimp.scene.rigid.rotation import Matrix, solve
from pgimp.scene.scene import Scene
from pgimp.solver.reduction import place_planes
from pgimp.solver.time.clock import Step

#: Iterations of Newton's method. Contact that only opens, closes, sticks or slides takes two or
#: three. A correction not smaller than the one before is made by half, then by a quarter.
#: Bodies that are light for their friction or adhesion may alternate between slip directions:
#: every other `NEWTON` iterations treat slip as viscous, which never overshoots.
TRIES, NEWTON = 72, 12

#: Convergence: change of the velocities over the body's greatest.
TOLERANCE = 1e-11

#: Greatest error of a body's displacement in a step, in cells, if Newton does not converge.
ASTRAY = 0.05

#: Most steps between two checks for overlap with objects without contact, and most cells of motion
#: meanwhile.
LOOKS, TRAVEL = 16, 0.2


class FreeBodies:
    """The free rigid bodies; every rank has all of them.

    Attributes
    ----------
    states : list of State
        Their states of motion.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm, self.rigid_bodies = scene, comm, scene.interaction.rigid_bodies
        self.numbers, self.bodies = (
            list(scene.interaction.rigid_bodies.free),
            list(scene.interaction.rigid_bodies.free.values()),
        )
        self.states = scene.interaction.rigid_bodies.first
        self._inertia: list[Matrix] = []
        self._free_momenta: list[list[float]] = []
        self._touched = False

    @property
    def now(self) -> dict[int, tuple[FreeBody, State]]:
        """The bodies and their states, by number."""
        each = zip(self.bodies, self.states, strict=True)
        return dict(zip(self.numbers, each, strict=True))

    @property
    def rate(self) -> float:
        """Greatest speed of a point of any of the bodies, in cells per unit of time."""
        return max(self.rigid_bodies.rates(self.states))

    def require_clear(self, done: Step, dt: float) -> None:
        """Refuse bodies that overlap objects without contact; collective, every few steps.

        `dt` is the length of the next step. The start has been checked already.
        """
        travel = max(self.rate, self.rigid_bodies.rate) * dt
        pause = max(1, min(LOOKS, int(TRAVEL / travel))) if travel > 0.0 else LOOKS
        faces, states = self.scene.domain.faces, self.states
        if (
            done.number
            and done.number % pause == 0
            and may_collide(self.rigid_bodies, faces, states)
        ):
            require_clear(self.rigid_bodies, faces, states, done.number, done.end, self.comm)

    def require_slow(self, t: Step) -> None:
        """Refuse a step in which a body would move by more than a cell; on every rank."""
        for number, rate in zip(self.numbers, self.rigid_bodies.rates(self.states), strict=True):
            if not rate * t.dt <= 1.0 + 1e-9:
                raise EndlessError(
                    f"step {t.number}, from time {t.start:.6g}: the rigid body "
                    f"'{self.rigid_bodies.names[number]}' moves by {rate * t.dt:.3g} cells "
                    f"in a step of "
                    f"{t.dt:.3g}, and would pass through what it meets\n"
                    f"  try: time.step: {0.3 / rate:.3g}, or {{courant: 0.3}}"
                )

    def solve_velocities(
        self,
        rigid_bodies: RigidBodies,
        grid: Grid,
        t: Step,
        gravity: tuple[float, ...],
        find_rigid_impulses: Callable[[], None],
    ) -> None:
        """Find the velocities at the end of a step, and set them; collective.

        Parameters
        ----------
        rigid_bodies : RigidBodies
            The bodies in the step, without impulses yet.
        grid : Grid
            The rank's planes.
        gravity : tuple of 3 float
            Force per mass.
        find_rigid_impulses : callable
            Sets `responses` for the velocities in `rigid_bodies`.
        """
        tried = self._begin(rigid_bodies, t, gravity)
        self._touched, part, before = False, 1.0, inf
        for number in range(TRIES):
            cautious = number // NEWTON % 2 == 1
            if number % NEWTON == 0:
                part, before = 1.0, inf
            self._set(rigid_bodies, tried, cautious)
            find_rigid_impulses()
            sums = self._sum(rigid_bodies, grid)
            if not sums.view(np.float64).any():
                return
            self._touched = True
            changes = [self._change(number, sums[number], v) for number, v in enumerate(tried)]
            left = max(map(self._size, range(len(tried)), tried, changes))
            if not cautious:
                part = min(1.0, 2.0 * part) if left < before else max(0.5 * part, 1.0 / 64.0)
            before = left
            for v, change in zip(tried, changes, strict=True):
                for i in range(6):
                    v[i] += part * change[i]
            if left < TOLERANCE:
                break
        self._set(rigid_bodies, tried)
        if not left < TOLERANCE:
            find_rigid_impulses()
            self._require_found(self._sum(rigid_bodies, grid), tried, t)

    def _begin(
        self, rigid_bodies: RigidBodies, t: Step, gravity: tuple[float, ...]
    ) -> list[list[float]]:
        """Return the velocities at the end of a step without impulses."""
        self._inertia, self._free_momenta = [], []
        found: list[list[float]] = []
        for body, state in zip(self.bodies, self.states, strict=True):
            inertia = body.halfway(state, t.dt)
            push = body.carried(state, t.start, t.dt, gravity)
            momenta = [
                p if may else 0.0 for p, may in zip((*push, *state.spin), body.may, strict=True)
            ]
            number = self.numbers[len(found)]
            rigid_bodies.motion["velocity_before"][number] = _booked_velocities(
                body, state, inertia
            )
            self._inertia.append(inertia)
            self._free_momenta.append(momenta)
            found.append(solve(body.mass_matrix(inertia), momenta))
        return found

    def begin(self, rigid_bodies: RigidBodies, t: Step, gravity: tuple[float, ...]) -> None:
        """Set the velocities without impulses, and the responses to impulses.

        For `pgimp.kernels.contact.impulses.gauss_seidel`, where impulses change the velocities
        one by one; `end` then moves the bodies.
        """
        self._set(rigid_bodies, self._begin(rigid_bodies, t, gravity))
        rigid_bodies.responses[:] = np.zeros((), RESPONSE)
        for number, body in enumerate(self.bodies):
            M = body.mass_matrix(self._inertia[number])
            for i in range(6):
                if body.may[i]:
                    unit = [float(j == i) for j in range(6)]
                    rigid_bodies.responses["derivative"][0, number, i] = solve(M, unit)

    def end(self, rigid_bodies: RigidBodies, dt: float) -> None:
        """Move the bodies with the impulses since `begin`, on all ranks alike."""
        self._move(rigid_bodies.responses["trial_impulse"][0], dt)

    def _set(
        self, rigid_bodies: RigidBodies, velocities: list[list[float]], cautious: bool = False
    ) -> None:
        for number, v in zip(self.numbers, velocities, strict=True):
            rigid_bodies.motion["velocity_after"][number] = v
            rigid_bodies.motion["viscous_slip"][number] = cautious

    def _require_found(self, sums: np.ndarray, tried: list[list[float]], t: Step) -> None:
        """Refuse velocities that have not converged; on every rank."""
        inverse = max(self.scene.domain.frame.inverse)
        for number, (body, v) in enumerate(zip(self.bodies, tried, strict=True)):
            M = body.mass_matrix(self._inertia[number])
            off = solve(M, self._rest(number, sums[number], v))
            away = (
                (hypot(*off[:3]) + hypot(*off[3:]) * self.rigid_bodies.arms[number])
                * inverse
                * t.dt
            )
            if not away < ASTRAY:
                raise EndlessError(
                    f"step {t.number}, from time {t.start:.6g}: the velocity of the rigid body "
                    f"'{body.name}' cannot be found, it may be off by {away:.2g} cells in a step\n"
                    "  try: smaller steps (time.step), less friction, a heavier body; smaller "
                    "cells where two rigid bodies hold the same material between them"
                )

    def _rest(self, number: int, sums: Any, v: list[float]) -> list[float]:
        """Return a body's residual: its momenta less the momenta of the trial velocities."""
        body = self.bodies[number]
        M, rest = body.mass_matrix(self._inertia[number]), [0.0] * 6
        impulse = sums["trial_impulse"].tolist()
        for i in range(6):
            if body.may[i]:
                has = sum(M[i][j] * v[j] for j in range(6))
                rest[i] = self._free_momenta[number][i] + impulse[i] - has
        return rest

    def _change(self, number: int, sums: Any, v: list[float]) -> list[float]:
        """Return Newton's correction of the trial velocities."""
        M, may = self.bodies[number].mass_matrix(self._inertia[number]), self.bodies[number].may
        derivative = sums["derivative"].tolist()
        for i in range(6):
            for j in range(6):
                if may[i] and may[j]:
                    M[i][j] += derivative[i][j]
        return solve(M, self._rest(number, sums, v))

    def _size(self, number: int, v: list[float], change: list[float]) -> float:
        """Return the relative size of a change of velocities."""
        scale = [1.0] * 3 + [self.rigid_bodies.arms[number]] * 3
        most = max(abs(x) * s for x, s in zip(v, scale, strict=True))
        by = max(abs(x) * s for x, s in zip(change, scale, strict=True))
        return by / max(most, by) if by != 0.0 else 0.0

    def _sum(self, rigid_bodies: RigidBodies, grid: Grid) -> np.ndarray:
        """Sum up `responses`, plane by plane in their order; collective."""
        lattice = rigid_bodies.lattice[self.numbers]
        low, high = int(lattice["least"][:, 0].min()), int(lattice["most"][:, 0].max())
        first = int(grid.window.lower[0])
        begin = max(low, first)
        mine = slice(begin - first, max(begin, min(high + 1, first + grid.owned)) - first)
        own = rigid_bodies.responses[mine].copy()
        own[grid.active[mine] == 0] = np.zeros((), RESPONSE)
        numbers = own.view(np.float64).reshape(*own.shape, RESPONSE.itemsize // 8)
        every = place_planes(self.comm, numbers, begin - low, high - low + 1)
        return np.add.reduce(self.in_order(every, low), axis=0).view(RESPONSE)[:, 0]

    def in_order(self, values: np.ndarray, low: int) -> np.ndarray:
        """Return values by plane, from `low` on, and body in the order in which they are summed.

        Where x is periodic they begin half a period below the body: so sums do not depend on where
        the seam is.
        """
        if not self.rigid_bodies.periods[0]:
            return values
        frame = self.scene.domain.frame
        cells, found = frame.cells[0], np.zeros((frame.cells[0], *values.shape[1:]))
        numbers = np.arange(low, low + len(values)) - frame.ghost
        mine = (numbers >= 0) & (numbers < cells)
        found[numbers[mine]] = values[mine]
        for number, state in enumerate(self.states):
            first = floor((state.home[0] - frame.origin[0]) * frame.inverse[0]) + cells // 2
            found[:, number] = np.roll(found[:, number], -first, axis=0)
        return found

    def move(self, rigid_bodies: RigidBodies, grid: Grid, dt: float) -> None:
        """Apply the step's impulses to the bodies, and move them; collective."""
        got = np.zeros(len(self.bodies), RESPONSE)
        if self._touched:
            got = self._sum(rigid_bodies, grid)
        self._move(got["impulse"], dt)

    def _move(self, taken: np.ndarray, dt: float) -> None:
        """Move the bodies; `taken` are impulse and moment on each."""
        for number, (body, given) in enumerate(zip(self.bodies, taken.tolist(), strict=True)):
            momenta = tuple(p + J for p, J in zip(self._free_momenta[number], given, strict=True))
            self.states[number] = body.moved(
                self.states[number], momenta, self._inertia[number], dt
            )


def _booked_velocities(body: FreeBody, state: State, inertia: Matrix) -> list[float]:
    """Velocities before a step, for the energy ledger.

    A moment also changes the rotation of the axis in the step. Twice the change of speed by this
    rotation at the step's middle is left out, so that the booked energy is the body's loss.
    """
    turned = solve(body.mass_matrix(inertia), [*state.momentum, *state.spin])
    return [2.0 * v - w for v, w in zip(body.velocities(state), turned, strict=True)]
