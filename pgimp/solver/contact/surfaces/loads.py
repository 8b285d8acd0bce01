"""Loads of contact on the facets of all bodies: since the last frame, and since the start.

For frames they are made smooth, as forces of neighbouring patches alternate about a smooth
pressure. With the pressures p, D p is what p lacks of a linear fit to its neighbourhood, and A the
areas:

    A p <- A p - D^T A D p.

D of a linear function is zero. So the sum and the moments stay, and what is linear stays as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.contact.surfaces.loads import LOADS, SLIP
from pgimp.kernels.contact.surfaces.search import find_beside
from pgimp.mpi.communicator import Communicator
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.surfaces.groups import Groups
from pgimp.solver.contact.surfaces.table import bins_of

#: Columns of the loads that last from step to step, which checkpoints have.
LASTING = 6

#: Radius of a neighbourhood in cells, and how often loads are made smooth: two passes leave 3 % of
#: what alternates from cell to cell.
RADIUS, PASSES = 1.5, 2

#: Least cosine between normals of neighbours; least eigenvalue of second moments, over the
#: greatest, of a neighbourhood with a fit.
_ALIKE, _LEAST = 0.7, 0.02


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


class Smoothed(NamedTuple):
    """Facets under load, or about to be."""

    x: np.ndarray  #: (n, 3) float64: Centroids.
    normal: np.ndarray  #: (n, 3) float64: Unit normals.
    area: np.ndarray  #: (n,) float64: Areas.
    body: np.ndarray  #: (n,) int64: Bodies.


def smooth(call: Bound, facets: Smoothed, loads: np.ndarray, cell: float, D: int) -> np.ndarray:
    """Loads of facets made smooth, (n, columns); `loads` are not over the areas."""
    x, normal, area, body = facets
    if D == 1 or not len(x):
        return loads
    own, other = _pairs(call, x, body, RADIUS * cell, D)
    alike = (normal[own] * normal[other]).sum(axis=1) > _ALIKE
    own, other = own[alike], other[alike]
    count, way = len(x), x[other] - x[own]
    a, b = _tangents(normal)
    xi = [(way * t[own]).sum(axis=1) for t in (a, b)[: D - 1]]
    far = np.sqrt((way * way).sum(axis=1)) / (RADIUS * cell)
    weight = area[other] * np.maximum(0.0, 1.0 - far)

    def added(values: np.ndarray) -> np.ndarray:
        return np.bincount(own, values, count)

    moments = np.empty((count, D, D))
    every = [np.ones(len(own)), *xi]
    for i in range(D):
        for j in range(D):
            moments[:, i, j] = added(weight * every[i] * every[j])
    second = moments[:, 1:, 1:] / (moments[:, :1, :1] * cell * cell)
    good = np.linalg.eigvalsh(second)[:, 0] > _LEAST
    moments[~good] = np.eye(D)
    fit = np.linalg.inv(moments)[:, 0]
    part = weight * sum(fit[own, i] * each for i, each in enumerate(every))
    part[~good[own]] = 0.0
    found = loads.copy()
    for _ in range(PASSES):
        for n in range(loads.shape[1]):
            p = found[:, n] / area
            lacks = np.where(good, p - added(part * p[other]), 0.0) * area
            found[:, n] -= lacks - np.bincount(other, part * lacks[own], count)
    return found


def _pairs(
    call: Bound, x: np.ndarray, body: np.ndarray, radius: float, D: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of facets of one body within a radius, also each with itself; by the first one."""
    key_of, strides = bins_of(x, radius, D)
    order, start = np.argsort(key_of, kind="stable"), np.zeros(len(x) + 1, np.int64)
    bins = key_of[order], order
    beside, found = grown(
        64 * len(x),
        lambda size: np.empty(size, np.int64),
        lambda room: call(find_beside, x, body, key_of, bins, strides, radius, start, room),
    )
    number = np.arange(len(x))
    own = np.concatenate([number, np.repeat(number, np.diff(start))])
    return own, np.concatenate([number, beside[:found]])


def _tangents(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across each normal; of normals in the plane of x and y the first is, too."""
    axis = np.argmin(np.abs(normal).round(9)[:, ::-1], axis=1)
    a = np.cross(normal, np.eye(3)[2 - axis])
    a /= np.sqrt((a * a).sum(axis=1))[:, None]
    return a, np.cross(normal, a)
