"""Spurious energy: the guard of steps that are as long as possible (`courant: auto`).

Every `EVERY` steps kinetic and strain energy are compared with the initial energy plus the work of
the loads since. If the step is too long, energy grows without bound, from rounding on, and shows
that long before anything else does: the steps then become shorter. Sums are taken layer by layer,
as those of the history, so that they have the same bits on any number of ranks.
"""

from typing import Any

import numpy as np

from pgimp.errors import EndlessError
from pgimp.kernels.sums import KINETIC, MASS, STRAIN, layer_sums
from pgimp.solver.clock import CourantClock, FixedClock

#: Steps from one check to the next.
EVERY = 10

#: Spurious energy, relative to the greatest energy so far, at which steps become shorter; the
#: factor on the step; the next bound, relative to the spurious energy found.
BOUND, SHORTER, AGAIN = 0.05, 0.75, 1.5

#: The least part of the first Courant number, and the spurious energy that ends the run.
LEAST, HOPELESS = 0.3, 10.0


#: Negligible energy, over that of all mass at the speed of waves: far more than rounding.
NONE = 1e-12


class EnergyWatch:
    """The guard of a run whose Courant number is chosen by pgimp; the same on all ranks.

    Parameters
    ----------
    speed : float
        Of the fastest wave at rest.

    Attributes
    ----------
    part : float
        Present Courant number, relative to that at the start.
    said : list of str
        Messages that have not been shown yet.
    """

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.part = 1.0
        self.said: list[str] = []
        self._first = self._most = 0.0
        self._bound = BOUND

    @property
    def numbers(self) -> list[float]:
        """The state for a checkpoint."""
        return [self.part, self._first, self._most, self._bound]

    @numbers.setter
    def numbers(self, numbers: list[float]) -> None:
        self.part, self._first, self._most, self._bound = numbers

    def shorten(self, clock: FixedClock | CourantClock) -> None:
        """Apply the reduction to the Courant number that pgimp has chosen."""
        assert isinstance(clock, CourantClock)
        clock.part = min(max(self.part, LEAST), 1.0)

    def begin(self, rank: Any) -> None:
        """Set the present energy as the reference; collective."""
        energy, work, mass = self._sums(rank)
        self._first = energy - work
        self._most = max(energy, NONE * mass * self.speed * self.speed)

    def look(self, rank: Any, step: int, time: float) -> None:
        """Compare the energy with its balance; collective.

        Raises
        ------
        EndlessError
            On every rank, if the solution has blown up.
        """
        energy, work, _ = self._sums(rank)
        excess = energy - self._first - work
        self._most = max(self._most, energy - max(excess, 0.0))
        if not excess > self._bound * self._most:
            return
        part = excess / self._most
        there = f"at step {step}, time {time:.6g}, {100.0 * part:.3g} % of the energy"
        if not part < HOPELESS:
            raise EndlessError(
                f"{there} has come from nothing: the solution is not stable\n"
                "  try: time.step: {courant: 0.2}; look for loads that set in at once, and for "
                "parts of bodies that are thinner than a cell"
            )
        self._bound = AGAIN * part
        if self.part * SHORTER < LEAST:
            self.said.append(f"{there} has come from nothing, though steps are short")
            return
        self.part *= SHORTER
        self.said.append(
            f"{there} has come from nothing; from now on steps have {100.0 * self.part:.0f} % of "
            "the Courant number that this shape should stand"
        )

    @staticmethod
    def _sums(rank: Any) -> tuple[float, float, float]:
        """Kinetic and strain energy, external work, and mass, with particles that have left."""
        scene, population, own = rank.scene, rank.population, rank.booked()
        sums = np.zeros((rank.slab.layers, len(scene.body_names), scene.sums))
        setting = scene.setting.without_shape()
        layer_sums(setting, population.particles, population.ordered, sums)
        escaped = own.escaped if scene.escapes else np.zeros((len(own.work), 1, scene.sums))
        mine = [(found[:, :, KINETIC] + found[:, :, STRAIN], found[:, :, MASS])
                for found in (sums, escaped)]  # fmt: skip
        rows = [each.sum(axis=1) for pair in mine for each in pair]
        # What walls that let go have taken cannot come from nothing.
        parts = rank.comm.allgather((own.work - own.walls.sum(axis=(1, 2)), *rows))
        work, *found = (float(np.concatenate(each).sum()) for each in zip(*parts, strict=True))
        return found[0] + found[2], work, found[1] + found[3]
