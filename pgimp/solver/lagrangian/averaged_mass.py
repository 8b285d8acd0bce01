"""Averaged mass in a step: a part of the forces for bodies in the initial configuration."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.grid.image_values import copy_accelerations
from pgimp.kernels.grid.mirror import fold_forces
from pgimp.kernels.lagrangian.averaged_mass import NUMBERS, Accelerations, MassRows, average_forces
from pgimp.mpi.communicator import Communicator
from pgimp.scene.averaging import averaged_parts
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.mass_rows import find_rows
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

#: Tags of messages with accelerations.
_UP, _DOWN = 23, 24

#: Part of a new value in the smoothed accelerations by contact.
_SMOOTH = 0.65

#: Numbers of accelerations that are found and used together: with forces 3 MB.
_CACHED = 1 << 17


class Pushed(NamedTuple):
    """What contact adds to the accelerations of vertices of all ranks."""

    keys: IntArray  #: (m,) int64: The vertices, ascending, see `reference_grid`.
    smooth: FloatArray  #: (m, 3) float64: In the last step, smoothed.
    forecast: FloatArray  #: (m, 3) float64: In the next one.


class AveragedMass(StepPart):
    """The averaged mass on one rank, see `pgimp.kernels.lagrangian.averaged_mass`.

    While a run comes to rest the lumped mass is enough.

    Contact acts later in a step. Accelerations have a forecast of what it will add, from the steps
    before: what rests on another body stays in equilibrium.

    Attributes
    ----------
    alpha : (bodies,) float64
        Part of the consistent mass by body; 0 for those with lumped mass.
    """

    def __init__(self, scene: Scene, alpha: np.ndarray) -> None:
        self.scene, self.alpha = scene, alpha
        self._known: Field | None = None
        self._rows: MassRows | None = None
        self._values = self._buffer = self._scratch = np.empty(0)
        #: First arguments of `average_forces` in this step; whether forces are left to `by_planes`,
        #: and accelerations, too.
        self._arguments: tuple[Any, ...] = ()
        self._left = self._streams = False
        self._contact = Pushed(np.empty(0, np.int64), *np.empty((2, 0, 3)))

    @property
    def lumped(self) -> np.ndarray:
        """Part of the lumped mass in kinetic energy and angular momentum, (bodies,)."""
        return 1.0 - (np.zeros_like(self.alpha) if self.scene.domain.settling else self.alpha)

    def add_forces(self, rank: RankState, update: VertexUpdate) -> None:
        """Take alpha (C - L) a from the forces at a rank's vertices; collective."""
        domain, grid = self.scene.domain, rank.grid
        if domain.settling:
            return
        frame, field, reach = domain.frame, grid.field, grid.vertices - 1
        half = grid.window.stride[0] // 2
        if self._known is not field:
            self._known, self._rows = field, find_rows(rank, self.alpha)
            self._buffer = aligned(half)
        mirrors = *domain.absorbing_mirrors, *domain.mirrors
        images = *domain.seams, *sorted(mirrors, key=lambda each: each.releases)  # as sums fold
        acts, slaves = rank.grips and rank.grips.acts, rank.slaves
        self._left = rank.contact.by_planes and not (images or slaves)
        pressed = rank.contact.bears and needed(len(self._contact.keys))
        self._streams = self._left and not (acts or pressed or rank.slab.neighbours)
        forcing, setting = update.forcing, (frame, field, update.faces)
        self._arguments, self._scratch = (*setting, forcing), np.empty((len(domain.faces), 3))
        if self._streams:
            return
        A, rows = self._room(grid.planes, reach), self._rows
        accelerations, every, none = self._accelerations(reach), (0, grid.planes), (0, 0)
        if acts:  # they move by the accelerations of what they hold
            rank.call(average_forces, *setting, forcing, accelerations, rows, every, none)
            constraints = rank.grips.forecast(rank, update, A, reach)
            forcing = forcing._replace(marked=(constraints, *forcing.marked[1:]))
            self._arguments = *setting, forcing
        rank.call(average_forces, *self._arguments, accelerations, rows, every, none)
        if pressed:
            from pgimp.kernels.contact.lagrangian.reference_grid import add_accelerations

            keys, _, forecast = self._contact
            rank.call(add_accelerations, frame, field, keys, forecast, A, reach)
        if slaves:
            own = A[reach * half : (reach + grid.planes) * half]
            masters = slaves.spread(rank, own, 1, NUMBERS)
        for each in reversed(images):
            rank.call(copy_accelerations, frame, field, each, A, reach)
        self._exchange(rank, reach)
        if not self._left:
            rank.call(average_forces, *self._arguments, accelerations, rows, none, every)
        for each in images:
            rank.call(fold_forces, frame, field, each, forcing.dt, update.ledger)
        if slaves:
            slaves.fold_averages(rank, self.alpha, masters)

    def by_planes(self, rank: RankState) -> Iterator[np.ndarray]:
        """Average forces that `add_forces` has left; yield which planes may then be updated.

        Forces of a few planes are still in the cache then. So are accelerations: where no others
        need them, there are only those of the same planes, and of planes beside them.
        """
        if not self._left:
            yield rank.grid.active
            return
        assert self._rows
        self._left, grid, rows, half = False, rank.grid, self._rows, len(self._buffer)
        active, count = np.zeros_like(grid.active), grid.planes
        size, far = max(1, min(_CACHED // half, count)), rows.reach
        reach, known, A = grid.vertices - 1, count, self._values
        if self._streams:
            known, A = 0, self._room(size, far)
        for first in range(0, count, size):
            last, ahead = min(first + size, count), known
            if self._streams:
                reach, known = far - first, min(first + size + far, count)
            planes = (ahead, known), (first, last)
            rank.call(average_forces, *self._arguments, self._accelerations(reach), rows, *planes)
            if self._streams:
                A[: 2 * far * half] = A[size * half :]
            active.fill(0)
            active[first:last] = grid.active[first:last]
            yield active

    def _room(self, planes: int, beyond: int) -> np.ndarray:
        """Room for the accelerations of some planes, and of those `beyond` on either side."""
        size = (planes + 2 * beyond) * len(self._buffer)
        if len(self._values) != size:
            self._values = aligned(size)
        return self._values

    def _accelerations(self, first: int) -> Accelerations:
        """The accelerations, with the number among their planes of the rank's first one."""
        return Accelerations(self._values, first, self._scratch, self._buffer)

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Forecast what contact adds to accelerations in the next step.

        The last value alone would lag by a step, and feed what rests on another body with energy.
        The line through the last two would make light vertices unstable. So values are drawn
        towards their forecast first; that is stable up to an alpha of 1.05.
        """
        keys, now = np.empty(0, np.int64), np.empty((0, 3))
        if changes := rank.contact.changes:
            moved = np.flatnonzero(changes.velocities.any(axis=1))
            moved = moved[changes.keys[moved].argsort()]
            keys, now = changes.keys[moved], changes.velocities[moved] / update.t.dt
        contact = Pushed(keys, now, now.copy())
        before, known = self._contact, np.isin(keys, self._contact.keys, assume_unique=True)
        there = np.searchsorted(before.keys, keys[known])
        contact.smooth[known] = _SMOOTH * now[known] + (1.0 - _SMOOTH) * before.forecast[there]
        contact.forecast[known] = 2.0 * contact.smooth[known] - before.smooth[there]
        self._contact = contact

    @property
    def state(self) -> np.ndarray:
        """What contact does, for checkpoints: (m, 7) float64."""
        keys, smooth, forecast = self._contact
        return np.concatenate([keys[:, None].view(np.float64), smooth, forecast], axis=1)

    def restore(self, state: np.ndarray) -> None:
        """Continue with the `state` of a checkpoint."""
        keys, smooth, forecast = (np.ascontiguousarray(a) for a in np.split(state, (1, 4), axis=1))
        self._contact = Pushed(keys[:, 0].view(np.int64), smooth, forecast)

    def _exchange(self, rank: RankState, reach: int) -> None:
        """Get the accelerations of planes that only the neighbours have; collective."""
        slab, comm, grid = rank.slab, rank.comm, rank.grid
        if not slab.neighbours:
            return
        size, A = reach * (grid.window.stride[0] // 2), self._values
        planes = A.reshape(grid.planes + 2 * reach, -1)
        below, above = planes[:reach], planes[reach + grid.planes :]
        low, high = planes[2 * reach : 3 * reach], planes[slab.layers : slab.layers + reach]
        assert low.size == high.size == size
        if slab.lower == slab.upper == comm.rank:
            below[:], above[:] = high, low
            return
        requests = []
        for neighbour, received, sent, tags in (
            (slab.lower, below, low, (_UP, _DOWN)),
            (slab.upper, above, high, (_DOWN, _UP)),
        ):
            if neighbour is not None:
                requests.append(comm.Irecv(received, neighbour, tags[0]))
                requests.append(comm.Isend(sent, neighbour, tags[1]))
        for request in requests:
            request.Wait()


def averaged_mass_of(
    scene: Scene, _: Communicator, before: AveragedMass | None = None
) -> AveragedMass | None:
    """Return the averaged mass of a scene; None where all masses are lumped."""
    if not scene.settings.averaged.any():
        return None
    return AveragedMass(scene, averaged_parts(scene))
