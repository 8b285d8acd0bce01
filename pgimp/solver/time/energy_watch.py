"""Spurious energy: the guard of steps that are as long as possible (`courant: auto`, settling).

Kinetic and strain energy are compared with the initial energy plus the work of the loads since. If
the step is too long, energy grows without bound, from rounding on, long before other signs: the
steps then become shorter.

Velocities are half a step behind positions, so that the sum of both energies swings in any wave.
With theta = omega dt/2 of a wave, 1 at the limit, it swings by theta/(1 - theta), a third for waves
of eight cells. Take the mean of K before and after a time, with a mean of the strain energies U,

    (K(n - 1/2) + K(n + 1/2))/2 + (U(n - 1) + 6 U(n) + U(n + 1))/8.

It swings by theta^4/(2 (1 - theta^2)), 3 % for such waves, and grows without bound in an unstable
wave. (Without the means (1 - theta^2) U + v(n - 1/2) v(n + 1/2)/2 would be constant, in either
case.) Every `EVERY` steps both energies are summed; in doubt every step is checked, and the mean
counts. With `stress: average` velocities are of the time of strains, whose energies are summed as
they are. Sums are taken layer by layer, as in the history, so that they have the same bits on any
number of ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

import numpy as np

from pgimp.errors import EndlessError
from pgimp.kernels.data.ledger import DAMPED_ENERGY
from pgimp.kernels.sums.sums import KINETIC, MASS, STRAIN
from pgimp.solver.lagrangian.layer_sums import sum_layers
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import CourantClock, FixedClock

#: Steps from one check to the next.
EVERY = 10

#: Spurious energy, relative to the greatest energy so far, at which steps become shorter. Then the
#: factor on the step, and the next bound over the spurious energy found.
BOUND, SHORTER, AGAIN = 0.05, 0.75, 1.5

#: Steps in a row that have to be beyond the bound, and part of it from which each step is checked.
#: An excess found before stays below this part.
ROW, DOUBT = 6, 0.8

#: Factor on the bound from which one check is enough, by the number of sums in the energy's mean.
#: It is about twice the swing of waves of four cells in the longest steps.
AT_ONCE = (100.0, 40.0, 10.0)

#: The least part of the first Courant number, and the spurious energy that ends the run.
MIN_COURANT_PART, HOPELESS = 0.3, 10.0


#: Negligible energy, over the energy of all mass at the wave speed: far more than rounding.
NONE = 1e-12


class EnergyWatch:
    """The guard of a run whose Courant number is chosen by pgimp; equal on all ranks.

    Parameters
    ----------
    speed : float
        Of the fastest wave at rest.
    stress : str
        The order of phases, `method.stress`.

    Attributes
    ----------
    part : float
        Current Courant number, relative to the first one.
    said : list of str
        Messages not shown yet.
    """

    def __init__(self, speed: float, stress: str = "last") -> None:
        self.speed = speed
        self._terms = 1 if stress == "average" else 3
        self.part = 1.0
        self.said: list[str] = []
        self._first = self._most = 0.0
        self._bound = BOUND
        #: Kinetic energy, strain energy and work after the last steps checked in a row.
        self._kept: list[tuple[float, float, float]] = []
        #: Whether the reference lacks the steps after it; steps in a row beyond the bound.
        self._new, self._row = False, 0

    @property
    def close(self) -> bool:
        """Whether the next step is to be checked, too."""
        return bool(self._kept)

    def due(self, step: int) -> bool:
        """Whether the energy is to be checked after this step."""
        return self.close or step % EVERY == 0

    @property
    def numbers(self) -> list[float]:
        """The state for a checkpoint."""
        whole = (float(self._new), float(self._row))
        kept = (each for sums in self._kept for each in sums)
        return [self.part, self._first, self._most, self._bound, *whole, *kept]

    @numbers.setter
    def numbers(self, numbers: list[float]) -> None:
        self.part, self._first, self._most, self._bound = numbers[:4]
        kept = numbers[6:]  # an older checkpoint has four numbers in all
        self._kept = list(zip(kept[::3], kept[1::3], kept[2::3], strict=False))
        if len(numbers) > 5:
            self._new, self._row = bool(numbers[4]), int(numbers[5])

    def shorten(self, clock: FixedClock | CourantClock) -> None:
        """Apply the reduction to the steps that pgimp has chosen, and to all of settling."""
        clock.part = min(max(self.part, MIN_COURANT_PART), 1.0)

    def begin(self, rank: RankState) -> None:
        """Set the current energy as the reference, with the next steps' energy; collective."""
        kinetic, strain, work, mass = self._sums(rank)
        self._kept = [(kinetic, strain, work)]
        self._first = kinetic + strain - work
        self._most = max(kinetic + strain, NONE * mass * self.speed * self.speed)
        self._new, self._row = True, 0

    def look(
        self, rank: RankState, step: int, time: float, clock: FixedClock | CourantClock
    ) -> None:
        """Look for spurious energy, and shorten the steps; collective.

        Raises
        ------
        EndlessError
            On every rank, if the solution has blown up.
        """
        begin = perf_counter()
        self._compare(rank, step, time)
        self.shorten(clock)
        rank.timings["order"] += perf_counter() - begin

    def _compare(self, rank: RankState, step: int, time: float) -> None:
        """Compare the energy with its balance; collective.

        Raises
        ------
        EndlessError
            On every rank, if the solution has blown up.
        """
        sums = *self._kept, self._sums(rank)[:3]
        energy, work = _balanced(sums[-self._terms :])
        self._kept = [*sums[-2:]]
        if self._new:
            if len(sums) < len(AT_ONCE):
                return
            self._first, self._new = energy - work, False
        excess = energy - self._first - work
        self._most = max(self._most, energy - max(excess, 0.0))
        bound = self._bound * self._most
        if not excess > DOUBT * bound:
            self._kept = []
        self._row = self._row + 1 if excess > bound else 0
        if self._row < ROW and not excess > AT_ONCE[len(sums) - 1] * bound:
            return
        self._row = 0
        part = excess / self._most
        there = f"at step {step}, time {time:.6g}, {100.0 * part:.3g} % of the energy"
        if not part < HOPELESS:
            raise EndlessError(
                f"{there} has come from nothing: the solution is not stable\n"
                "  try: time.step: {courant: 0.2}; look for loads that set in at once, and for "
                "parts of bodies that are thinner than a cell"
            )
        self._bound = AGAIN * part
        if self.part * SHORTER < MIN_COURANT_PART:
            self.said.append(f"{there} has come from nothing, though steps are short")
            return
        self.part *= SHORTER
        self.said.append(
            f"{there} has come from nothing; from now on steps have {100.0 * self.part:.0f} % of "
            "the Courant number that this shape should stand"
        )

    @staticmethod
    def _sums(rank: RankState) -> tuple[float, float, float, float]:
        """Kinetic energy, strain energy, external work and mass, with particles that have left."""
        scene, own = rank.scene, rank.booked()
        sums = np.zeros((rank.slab.layers, len(scene.body_names), scene.materials.sums))
        sum_layers(rank, scene, rank.population.ordered, sums)
        escaped = (
            own.escaped
            if scene.settings.escapes
            else np.zeros((len(own.work), 1, scene.materials.sums))
        )
        rows = [
            found[:, :, which].sum(axis=1)
            for found in (sums, escaped)
            for which in (KINETIC, STRAIN, MASS)
        ]
        # Energy taken by unilateral walls and by damping cannot come from nothing.
        work = own.work - own.wall_energy.sum(axis=(1, 2))
        if rank.damping:
            work -= own.damping[:, DAMPED_ENERGY]
        parts = rank.comm.allgather((work, *rows))
        work, *found = (float(np.concatenate(each).sum()) for each in zip(*parts, strict=True))
        kinetic, strain, mass = (a + b for a, b in zip(found[:3], found[3:], strict=True))
        if rank.inflow:
            entered = rank.inflow.sums
            kinetic, strain, mass = (
                a - float(entered[which])
                for a, which in ((kinetic, KINETIC), (strain, STRAIN), (mass, MASS))
            )
        return kinetic, strain, work, mass


def _balanced(sums: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Energy at one time, as far as sums of one to three steps give it, and work until then."""
    kinetic, strain, work = sums[-1]
    if len(sums) > 1:
        kinetic_before, now, work_before = sums[-2]
        kinetic, work = 0.5 * (kinetic_before + kinetic), 0.5 * (work_before + work)
        if len(sums) > 2:
            now += 0.125 * (sums[-3][1] - 2.0 * now + strain)
        strain = now
    return kinetic + strain, work
