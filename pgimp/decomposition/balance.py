"""Load balance: when and where slab boundaries move.

All ranks measure, rank 0 decides. The cost of a layer is counted in particles: its own, and its
plane of vertices. A factor applies where a rank's time per particle has differed from other ranks'
for a while, because of material or machine. Boundaries move when the expected saving until the next
change exceeds the cost of moving so far. Bits do not depend on the boundaries.
"""

from collections import deque

import numpy as np

from pgimp.decomposition.slabs import common, cut, imbalance_of, slab_of
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.switches import switched_on

#: Environment variable that turns it off.
SWITCH = "PGIMP_BALANCE"
_MEANING = "keeps slab boundaries where they are", "lets them follow the load"

#: Imbalance, as a part of the mean cost of a rank, below which slabs do not change.
_SMALL = 0.03
#: Parts of the mean cost by which a move must lower the most expensive rank's cost.
_LEAST_GAIN = 0.02
#: Greatest lifetime, in steps, that is expected of an imbalance.
_LONGEST = 1000
#: Intervals in which a rank must have differed before it counts as slower or faster.
_EVIDENCE, _MOST_EVIDENCE = 4, 64
#: Number of stored intervals, and seconds of each: disturbances last for tenths of one.
_REMEMBERED, _SECONDS = 8, 1.0
#: Cost of a move until it is measured, in steps of the particles that move and of some more;
#: and the greatest cost.
_MOVE_COST, _FIXED_COST, _MOST_MOVE_COST = 2.0, 8000.0, 200.0


class Balance:
    """The load of the ranks, as stored on one.

    Parameters
    ----------
    cuts : list of int
        The decomposition, see `pgimp.decomposition.slabs.cut`.
    total : int
        Particles of all ranks.
    vertices : int
        Vertices in one direction of a particle's support.
    ends : int
        See `cut`.
    interval : int
        Steps between two reports.

    Attributes
    ----------
    on : bool
        Whether boundaries may move.
    rebalance_requested : bool
        Whether this rank requests a decision.
    pause : int
        Steps until a rank may request again because of particles it already had at the last
        decision.
    move_cost : float
        Cost of a move, in steps of the particles that move, see `_MOVE_COST`; measured on rank 0.
    total
        Particles of all ranks at the last report.
    imbalance : float or None
        Busiest rank's time in the kernels over the mean, less one, in the last report.
    moves : list of (float, float)
        Imbalance by cost before and after each move; on rank 0.
    """

    def __init__(
        self, cuts: list[int], total: int, vertices: int, ends: int, interval: int
    ) -> None:
        self.cuts, self.total = cuts, total
        self.on = len(cuts) > 2 and switched_on(SWITCH, *_MEANING)
        self.rebalance_requested = False
        self.pause = 0
        self.imbalance: float | None = None
        self.moves: list[tuple[float, float]] = []
        self._vertices, self._ends, self._interval = vertices, ends, interval
        self._steps = np.zeros((interval, 2))
        self._taken = 0
        self._before = (0.0, 0.0)
        self._clear, self._known = 2**62, 0
        self._had: int | None = None
        self._changed, self._seconds = -1, 0.0
        self.move_cost = _MOVE_COST
        self._cold = True
        # The following attributes are of use on rank 0 only.
        self._density = np.ones(cuts[-1])
        self._expected = np.ones(len(cuts) - 1)
        self._plane = 0.0
        self._moved = 0.0
        self._back_off = self._wait = 0
        self._forget()
        self._evidence = _EVIDENCE
        self._doubted: float | None = None

    def _forget(self) -> None:
        """Clear the records of differences between ranks."""
        self._factors: deque[np.ndarray] = deque(maxlen=_REMEMBERED)
        self._watched = self._next = 0.0
        self._imbalances: deque[float] = deque(maxlen=_MOST_EVIDENCE)
        self._refused = 0.0

    def note(self, worked: dict[str, float], count: int, step: int) -> None:
        """Record a step.

        Parameters
        ----------
        worked : dict of str to float
            Seconds of work in each phase so far, see `Simulation.worked`.
        count, step : int
            This rank's particles; steps done.
        """
        spent = worked["P2G"] + worked["G2P"] + worked["order"], worked["momentum"]
        slot = self._taken % self._interval
        self._steps[slot] = spent[0] - self._before[0], spent[1] - self._before[1]
        self._before = spent
        self._taken += 1
        self.pause -= 1
        if self._changed < 0:
            self._changed = step - 1
        more, excess = count - self._known, count - (self._had or 0)
        clear = more > self._clear or (excess > self._clear and self.pause < 0)
        if clear and self.on and self._may_pay(excess, step):
            self.rebalance_requested = True

    def report(self, comm: Communicator, count: int, planes: int, step: int) -> None:
        """Share the load of all ranks since the last report; collective.

        Parameters
        ----------
        count, planes : int
            This rank's particles, and its active planes in the last step.
        step : int
            Steps done.
        """
        taken = self._steps[: min(self._taken, self._interval)]
        # An interruption makes some steps long, but rarely half of them.
        particle, plane = np.median(taken, axis=0) if len(taken) else (0.0, 0.0)
        mine = np.array([particle, plane, count, planes, self._seconds])
        every = np.empty((comm.size, len(mine)))
        comm.Allgather(mine, every)
        self._taken, self._seconds = 0, 0.0
        every = every[: len(self.cuts) - 1]
        self.total = int(every[:, 2].sum())
        self.watch(count)
        busy = every[:, 0] + every[:, 1]
        self.imbalance = float(busy.max() / busy.mean()) - 1.0 if busy.any() else None
        if comm.rank == 0 and self.on and self.imbalance is not None and self.total:
            self._learn(every, busy, step)

    def watch(self, count: int) -> None:
        """Request again when particles clearly outnumber the current count and the last move's.

        Parameters
        ----------
        count : int
            This rank's particles.
        """
        self._had = count if self._had is None else self._had
        self._clear = int(_SMALL * self.total / (len(self.cuts) - 1))
        self._known = count
        self.rebalance_requested = False

    def _may_pay(self, excess: float, step: int) -> bool:
        """Whether moving boundaries may pay off if a rank has `excess` particles too many."""
        cost = self.move_cost * (excess + _FIXED_COST)
        return excess > 0.0 and excess * self._lifetime(step) > cost

    def _lifetime(self, step: int) -> int:
        """Steps for which a move would help: as many as the imbalance took to build up."""
        return min(step - self._changed, _LONGEST)

    def _learn(self, every: np.ndarray, busy: np.ndarray, step: int) -> None:
        """Estimate on rank 0 the costs of particles and planes, and the differences of ranks."""
        counts, planes = every[:, 2], every[:, 3]
        particle = max(every[:, 0].sum() / counts.sum(), 1e-12)
        self._plane = every[:, 1].sum() / max(planes.sum(), 1.0) / particle
        if self._moved and every[:, 4].any():
            move_cost = float(every[:, 4].max() / particle / self._moved)
            # An interrupted move took long: approach such a value slowly, and leave it faster.
            move_cost = min(max(move_cost, 0.5 * self.move_cost), 1.5 * self.move_cost)
            self.move_cost = min(move_cost, _MOST_MOVE_COST)
            self._moved = 0.0
        work = counts + self._plane * planes
        self._watched += self._interval * float(busy.max())
        if self._watched >= self._next:
            factors = busy / particle / np.maximum(work, 1.0)
            self._factors.append(np.where(work > 0.0, factors, 1.0))
            self._next = self._watched + _SECONDS / _REMEMBERED
        self._imbalances.append(float(self.imbalance or 0.0))
        if self._doubted is not None and len(self._imbalances) >= _EVIDENCE - 1:
            helped = np.median(self._imbalances) < self._doubted - _LEAST_GAIN
            self._evidence = _EVIDENCE if helped else min(2 * self._evidence, _MOST_EVIDENCE)
            self._doubted = None
        costs = work * self._expected * self._differences()
        imbalance = float(costs.max() / costs.mean()) - 1.0
        self._wait -= 1
        clear = imbalance > max(_SMALL, self._refused + _LEAST_GAIN)
        again = imbalance > _SMALL and self._wait <= 0
        self.rebalance_requested = (clear or again) and self._may_pay(float(np.ptp(costs)), step)

    def _differences(self) -> np.ndarray:
        """Slowdown of each rank relative to the expected time, less its noise."""
        if len(self._imbalances) < self._evidence or self._watched < _SECONDS:
            return np.ones(len(self.cuts) - 1)
        seen = np.array(self._factors)
        deviation = np.median(seen, axis=0) / self._expected - 1.0
        clear = np.maximum(np.abs(deviation) - np.ptp(seen, axis=0), 0.0)
        return np.clip(1.0 + np.sign(deviation) * clear, 0.25, 4.0)

    def decide(self, counts: np.ndarray, step: int) -> list[int] | None:
        """Decide the positions of boundaries; on rank 0.

        Parameters
        ----------
        counts : (layers,) int or float
            Particles of each layer.
        step : int
            Steps done.

        Returns
        -------
        list of int or None
            As from `cut`; None for no change.
        """
        self.pause = _LONGEST
        if not self.on or not counts.any():
            return None
        planes = np.convolve(counts > 0, np.ones(self._vertices))[: len(counts)] > 0.5
        work = counts + self._plane * planes
        differences = self._differences()
        density = self._density * np.repeat(differences, np.diff(self.cuts))
        new, gain, move_cost = self._propose(counts, work * density, step)
        if gain <= move_cost:
            self._refused = imbalance_of(work * density, self.cuts)
            self._back_off = min(2 * self._back_off + 1, 32)
            self._wait = self._back_off
            # An imbalance that grows linearly in time has a gain that grows with its square.
            since = step - self._changed
            growth = (move_cost / gain) ** 0.5 if gain else 1.5
            self.pause = max(since // 8, int(since * min(growth - 1.0, 1.0)))
            return None
        # Would it have paid without the new differences?
        if (differences != 1.0).any():
            _, plain, move_cost = self._propose(counts, work * self._density, step)
            if plain <= move_cost:
                self._doubted = float(np.median(self._imbalances))
        self._density = density
        costs = work * density
        self.moves.append((imbalance_of(costs, self.cuts), imbalance_of(costs, new)))
        mean = costs.sum() / max(work.sum(), 1e-300)
        has = np.add.reduceat(work, new[:-1])
        expected = np.add.reduceat(costs, new[:-1]) / np.maximum(has, 1e-300) / mean
        self._expected = np.where(has == 0.0, 1.0, expected)
        self._moved += self._moving(counts, new) + _FIXED_COST
        self._back_off = self._wait = self.pause = 0
        self._forget()
        return new

    def summary(self) -> str:
        """Return a line on the moves made, on rank 0; empty if nothing moved."""
        if not self.moves:
            return ""
        before, after = (f"{100.0 * x:.0f} %" for x in np.mean(self.moves, axis=0))
        times = f"{len(self.moves)} times" if len(self.moves) > 1 else "once"
        return f"slab boundaries moved {times}: imbalance {before} before a move, {after} after it"

    def _propose(
        self, counts: np.ndarray, costs: np.ndarray, step: int
    ) -> tuple[list[int], float, float]:
        """The best boundaries, their saving, and the cost of moving, in particle-steps."""
        ranks = len(self.cuts) - 1
        new = cut(costs, ranks, self._vertices - 1, self._ends)
        now, then = (np.add.reduceat(costs, cuts[:-1]).max() for cuts in (self.cuts, new))
        if now - then < _LEAST_GAIN * costs.sum() / ranks:
            return new, 0.0, 0.0
        move_cost = self.move_cost * (self._moving(counts, new) + _FIXED_COST)
        return new, float(now - then) * self._lifetime(step), move_cost

    def _moving(self, counts: np.ndarray, new: list[int]) -> float:
        """Particles that the rank with most of them must send and receive."""
        total = np.concatenate([[0.0], np.cumsum(counts)])
        most = 0.0
        for rank in range(len(new) - 1):
            a, b = slab_of(self.cuts, rank), slab_of(new, rank)
            first, end = common(a, b)
            had, gets = (total[s.first + s.layers] - total[s.first] for s in (a, b))
            most = max(most, had + gets - 2.0 * (total[end] - total[first]))
        return most

    def moved(self, seconds: float, step: int) -> None:
        """Record a move and its duration on every rank."""
        self._changed, self._had, self._taken = step, None, 0
        if self._cold:  # the first one is not typical
            self._cold, self._moved = False, 0.0
        else:
            self._seconds += seconds
