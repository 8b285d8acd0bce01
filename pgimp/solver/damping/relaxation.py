"""Dynamic relaxation: the damping by which a run settles, which finds its own strength.

The n-th step from rest leaves (n - 1)/(n + 1) of the velocity and gives n/(n + 1) of the kick,

    v'' + (2/t) v' = a,   t = n dt,

so that a mode of the angular frequency w falls as sin(w t)/(w t): the mean over time of the motion
without damping. Short waves die away in a few of their periods, whatever the slowest mode is. That
one reaches its static place at w t = pi, with little overshoot of stresses on the way. There the
motion begins to slow down by itself: all velocities become zero, and n begins anew.

It is gradient-based adaptive restart (O'Donoghue and Candes 2015) of Nesterov's method. Its
equation of motion is that of Su, Boyd and Candes (2016), with 2 in place of their 3. Kinetic
damping has 0, and stops in the short waves where a load sets in; viscous damping needs the slowest
frequency.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.ledger import INTERNAL, KINETIC_BEFORE, KINETIC_NOW, UNBALANCED
from pgimp.kernels.grid.damping import relax
from pgimp.kernels.grid.unbalanced import (
    note_first_energy,
    sum_internal_forces,
    sum_unbalanced_forces,
)
from pgimp.solver.damping.damping import bring_to_rest, total_sums
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Steps between two sums of forces while a run comes to rest.
EVERY = 10

#: Without a fall of the unbalanced part by this factor in so many steps, and so many restarts, the
#: run gives up; likewise in so many steps in any case, as of what falls freely. On the way to the
#: static place it falls by it in a quarter of the way.
FALL, PATIENCE, RESTARTS, ENDLESS = 0.9, 5000, 20, 10000


class Relaxation(StepPart):
    """Dynamic relaxation on one rank; its numbers are equal on all ranks.

    Attributes
    ----------
    since : int
        Steps since the last restart.
    least, steps, restarts : float, int, int
        Least unbalanced part so far; steps and restarts since it was found.
    way, left : float, float
        Length of the way so far and of what is left until the motion turns, in the norm of the
        kinetic energy, times the root of half and over the step.
    """

    def __init__(self) -> None:
        self.since, self.least, self.steps, self.restarts = 0, np.inf, 0, 0
        self.way = self.left = 0.0

    @property
    def numbers(self) -> list[float]:
        """The state for a checkpoint."""
        least = self.least if np.isfinite(self.least) else -1.0
        return [self.since, least, self.steps, self.restarts, self.way]

    @numbers.setter
    def numbers(self, numbers: Sequence[float]) -> None:
        self.least = numbers[1] if numbers[1] >= 0.0 else np.inf
        self.since, self.steps, self.restarts = (int(numbers[i]) for i in (0, 2, 3))
        self.way = numbers[4] if len(numbers) > 4 else 0.0  # older checkpoints have none

    @property
    def cycle(self) -> float:
        """Mean number of steps between restarts, half a period of the motion that is left."""
        return self.steps / max(self.restarts, 1)

    @property
    def left_part(self) -> float:
        """Part of the whole way that is left until the motion turns."""
        return self.left / self.way if self.way else 0.0

    @property
    def stagnant(self) -> bool:
        """Whether the unbalanced part has not fallen for long."""
        tried = self.steps > PATIENCE and self.restarts >= RESTARTS
        return tried or self.steps > ENDLESS

    def note(self, unbalanced: float) -> None:
        """Note the unbalanced part."""
        if unbalanced < FALL * self.least:
            self.least, self.steps, self.restarts = unbalanced, 0, 0

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """Begin anew from rest if the motion slows down by itself; collective.

        The energies are sums by plane, each of one rank, in the planes' order. They are stored
        with the other sums, so that a resumed run decides alike. The last but one step left a part
        of the velocity that it began with: less than that is the work of the unbalanced forces, as
        far as it stays in the motion. In the current configuration some does not: vertices of
        little mass are driven in vain, and their power would hide that of the slow motion.

        The part of v that the forces add in a step tells the way x to the static place: they add
        w^2 dt x. With n steps since rest w dt is pi/n near the turn, at most.
        """
        now, before = total_sums(rank)[KINETIC_NOW : KINETIC_BEFORE + 1]
        left = (self.since - 2.0) / max(self.since, 1)
        against = self.since > 2 and now < left * left * before
        self.way += sqrt(now)
        gain = sqrt(now / before) - left if self.since > 2 and before > 0.0 else 0.0
        self.left = sqrt(now) * max(gain, 0.0) * (self.since / pi) ** 2
        if against or not self.since:
            self.left = 0.0
            bring_to_rest(rank)
            self.since, self.restarts = 0, self.restarts + int(against)

    def add_forces(self, rank: RankState, update: VertexUpdate) -> None:
        """Sum the forces of stresses and loads, now and then."""
        if needed(update.t.number % EVERY == 0):
            rank.call(sum_internal_forces, rank.grid.field, update.forcing, rank.ledger)

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Sum unbalanced forces and kinetic energy after all conditions and contact, and damp."""
        field, forcing, ledger = rank.grid.field, update.forcing, rank.ledger
        rank.call(note_first_energy, field, forcing, ledger)
        if needed(update.t.number % EVERY == 0):
            rank.call(sum_unbalanced_forces, field, forcing, ledger)
        self.since += 1
        self.steps += 1
        rank.call(relax, field, forcing, self.since, ledger)
        if rank.grips and rank.grips.acts:
            rank.grips.relax(self.since, update.t.dt)


def unbalanced_sums(rank: RankState) -> tuple[float, float]:
    """Sums of the magnitudes of the unbalanced forces, and of those of stresses; collective."""
    sums = total_sums(rank)
    return float(sums[UNBALANCED]), float(sums[INTERNAL])
