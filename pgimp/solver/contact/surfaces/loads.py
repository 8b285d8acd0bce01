"""Loads of contact on the facets of all bodies: since the last frame, and since the start."""

from __future__ import annotations

import numpy as np

from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.contact.surfaces.loads import LOADS, SLIP
from pgimp.mpi.communicator import Communicator
from pgimp.solver.contact.surfaces.groups import Groups

#: Columns of the loads that last from step to step, which checkpoints have.
LASTING = 6


class SurfaceLoads:
    """Impulses on facets since the last frame; slip and heat of friction since the start.

    They are state, of which a step uses nothing. A row of loads belongs to a group of bodies, and
    so to the rank that solves for it. Facets of rigid bodies with prescribed motion, which may meet
    several groups, have rows for each body that they have met. So the sums depend on no ranks.

    Attributes
    ----------
    values : (rows, LOADS) float64
        See `pgimp.kernels.contact.surfaces.loads`: of all facets, then of those of rigid bodies
        with prescribed motion, for each body that these have met.
    time : float
        Time since the last frame.
    """

    def __init__(self, comm: Communicator) -> None:
        self.comm, self.time = comm, 0.0
        self.values = np.zeros((0, LOADS))
        self._of: Surface | None = None
        self._slot = np.empty(0, np.int64)  # numbers of facets of such rigid bodies; -1 of others
        self._begin = np.empty(0, np.int64)  # first row of these by the other body; -1 without any
        self._owner = np.empty(0, np.int64)  # the rank that has each body's rows
        self._touched = np.empty(1, np.int64)
        self._restored = np.empty((0, LASTING))

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """For `add_loads`."""
        return self.values, self._slot, self._begin, self._touched

    def divide(
        self, surface: Surface, labels: np.ndarray, groups: Groups, met: np.ndarray, root: int
    ) -> None:
        """Take the rows of the rank's groups; collective.

        Parameters
        ----------
        labels : (bodies,) int64
            See `pgimp.solver.contact.surfaces.groups.labels_of`.
        met : (n, 2) int64
            Pairs of bodies with facets near each other.
        root : int
            The rank that solves for what meets no facets.
        """
        self.know(surface, labels)
        fixed = np.zeros(len(labels), bool)
        fixed[np.unique(surface.body[self._slot >= 0])] = True
        some = met[fixed[met].any(axis=1)]
        for body in np.unique(some[~fixed[some]]).tolist():
            self._rows_by(body)
        self._owner = np.full(len(labels), root)
        there = groups.of >= 0
        self._owner[there] = groups.rank[groups.of[there]]

    def _rows_by(self, body: int) -> None:
        """Make rows for what rigid bodies with prescribed motion get from a body."""
        if self._begin[body] < 0:
            self._begin[body] = len(self.values)
            more = np.zeros((int(self._slot.max(initial=-1)) + 1, LOADS))
            self.values = np.concatenate([self.values, more])
            self._touched = np.empty(1 + len(self.values), np.int64)

    def know(self, surface: Surface, labels: np.ndarray) -> None:
        """Have all rows on all ranks, of a surface that may be another than before; collective.

        Then bodies that are the same keep their loads.
        """
        self._gather()
        if self._of is surface:
            return
        before, had = self._of, (self.values, self._slot, self._begin)
        fixed = labels[surface.body] < 0
        self._of, self._slot = surface, np.where(fixed, np.cumsum(fixed) - 1, -1)
        self._begin = np.full(len(labels), -1)
        self.values = np.zeros((len(surface.x), LOADS))
        self._touched = np.empty(1 + len(self.values), np.int64)
        self._owner = np.zeros(len(labels), np.int64)
        if before is None:
            self._take_restored()
            return
        values, slot, begin = had
        for body in np.flatnonzero(begin >= 0).tolist():
            self._rows_by(body)
        for body in np.unique(surface.body):
            own, old = surface.body == body, before.body == body
            if not np.array_equal(surface.x[own], before.x[old]):
                continue
            self.values[np.flatnonzero(own)] = values[np.flatnonzero(old)]
            if fixed[own].all():
                for other in np.flatnonzero(begin >= 0).tolist():
                    rows = begin[other] + slot[old]
                    self.values[self._begin[other] + self._slot[own]] = values[rows]

    def _take_restored(self) -> None:
        """Take over the loads of a checkpoint, if they are of these surfaces."""
        stored, facets = self._restored, len(self.values)
        count = int(stored[0, 1]) if len(stored) else 0
        fixed = int(self._slot.max(initial=-1)) + 1
        if len(stored) != 1 + count + facets + count * fixed:
            return
        bodies = stored[1 : 1 + count, 0].astype(np.int64)
        if len(stored) < 2 or ((bodies < 0) | (bodies >= len(self._begin))).any():
            return
        for body in bodies.tolist():
            self._rows_by(body)
        self.values[:, :LASTING] = stored[1 + count :]

    def _key(self) -> np.ndarray:
        """The body that each row belongs to."""
        assert self._of is not None
        found = np.empty(len(self.values), np.int64)
        found[: len(self._of.body)] = self._of.body
        fixed = int(self._slot.max(initial=-1)) + 1
        for body in np.flatnonzero(self._begin >= 0).tolist():
            found[self._begin[body] : self._begin[body] + fixed] = body
        return found

    def _gather(self) -> None:
        """Have all rows on all ranks; collective."""
        if self.comm.size == 1 or self._of is None:
            return
        mine = (self._owner[self._key()] == self.comm.rank) & self.values.any(axis=1)
        own = np.flatnonzero(mine)
        for rows, values in self.comm.allgather((own, self.values[own])):
            self.values[rows] = values

    def taken(self, surface: Surface, labels: np.ndarray) -> tuple[np.ndarray, float]:
        """Loads of all facets, and the time that they are of, which begins anew; collective."""
        self.know(surface, labels)
        found, fixed = self.values[: len(surface.x)].copy(), self._slot >= 0
        for begin in self._begin[self._begin >= 0].tolist():  # in the order of bodies
            found[fixed] += self.values[begin + self._slot[fixed]]
        time, self.time = self.time, 0.0
        self.values[:, :SLIP] = 0.0
        return found, time

    @property
    def stored(self) -> np.ndarray:
        """What a checkpoint has of them, (n, LASTING) float64, on rank 0, empty else; collective.

        Time and number of bodies with rows of their own; these; the rows.
        """
        self._gather()
        if self.comm.rank > 0 or self._of is None:
            return np.empty((0, LASTING))
        bodies = np.flatnonzero(self._begin >= 0)
        bodies = bodies[np.argsort(self._begin[bodies])]
        first = np.zeros((1 + len(bodies), LASTING))
        first[0, 0], first[0, 1], first[1:, 0] = self.time, len(bodies), bodies
        return np.concatenate([first, self.values[:, :LASTING]])

    def restore(self, stored: np.ndarray) -> None:
        """Continue with those of a checkpoint, on every rank."""
        self.time, self._restored = float(stored[0, 0]), stored
