"""Averaged mass in a step: a part of the forces for bodies in the initial configuration."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.reference_grid import add_accelerations
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.grid.image_values import copy_accelerations
from pgimp.kernels.grid.mirror import fold_forces
from pgimp.kernels.lagrangian.averaged_mass import MassRows, average_forces
from pgimp.mpi.communicator import Communicator
from pgimp.scene.averaging import averaged_parts
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.mass_rows import find_rows
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

#: Tags of messages with accelerations.
_UP, _DOWN = 23, 24

#: Numbers of accelerations that are found and used together: with forces 1.5 MB.
_CACHED = 1 << 16


class AveragedMass(StepPart):
    """The averaged mass on one rank, see `pgimp.kernels.lagrangian.averaged_mass`.

    While a run comes to rest the lumped mass is enough.

    Contact acts later in a step. Accelerations have that of its last step: what rests on another
    body stays in equilibrium, and a wave meets the mass that it should.

    Attributes
    ----------
    alpha : (bodies,) float64
        Part of the consistent mass by body; 0 for those with lumped mass.
    """

    def __init__(self, scene: Scene, alpha: np.ndarray) -> None:
        self.scene, self.alpha = scene, alpha
        self._known: Field | None = None
        self._rows: MassRows | None = None
        self._accelerations = self._buffer = np.empty(0)
        #: Arguments of `average_forces` in this step, and the plane below which accelerations are
        #: known; whether forces are left to `by_planes`.
        self._arguments: tuple[Any, ...] = ()
        self._known_below = 0
        self._left = False
        #: keys, pushed: (m,) int64, (m, 3) float64: What contact added to accelerations of vertices
        #: in the last step.
        self._keys, self._pushed = np.empty(0, np.int64), np.empty((0, 3))

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
            self._accelerations = aligned((grid.planes + 2 * reach) * half)
            self._buffer = aligned(half)
        forcing, A = update.forcing, self._accelerations
        setting = frame, field, update.faces
        rest = np.empty((len(domain.faces), 3)), A, reach, self._rows
        every = (0, grid.planes), (0, 0), self._buffer
        pressed = rank.contact.bears and needed(len(self._keys))
        if rank.grips and rank.grips.acts:  # they move by the accelerations of what they hold
            rank.call(average_forces, *setting, forcing, *rest, *every)
            constraints = rank.grips.forecast(rank, update, A, reach)
            forcing = forcing._replace(marked=(constraints, *forcing.marked[1:]))
        self._arguments, self._known_below = (*setting, forcing, *rest), 0
        mirrors = *domain.absorbing_mirrors, *domain.mirrors
        images = *domain.seams, *sorted(mirrors, key=lambda each: each.releases)  # as sums fold
        if images or rank.slab.neighbours or pressed:
            rank.call(average_forces, *self._arguments, *every)
            self._known_below = grid.planes
            if pressed:
                rank.call(add_accelerations, frame, field, self._keys, self._pushed, A, reach)
            for each in reversed(images):
                rank.call(copy_accelerations, frame, field, each, A, reach)
            self._exchange(rank, reach)
        self._left = rank.contact.by_planes and not images
        if not self._left:
            self._average(rank, 0, grid.planes)
        for each in images:
            rank.call(fold_forces, frame, field, each, forcing.dt, update.ledger)

    def by_planes(self, rank: RankState) -> Iterator[np.ndarray]:
        """Average forces that `add_forces` has left; yield which planes may then be updated.

        Forces of a few planes are still in the cache then, as they are when they are averaged.
        """
        if not self._left:
            yield rank.grid.active
            return
        grid, active = rank.grid, np.zeros_like(rank.grid.active)
        size = max(1, _CACHED // len(self._buffer))
        for first in range(0, grid.planes, size):
            last = min(first + size, grid.planes)
            self._average(rank, first, last)
            active.fill(0)
            active[first:last] = grid.active[first:last]
            yield active
        self._left = False

    def _average(self, rank: RankState, first: int, last: int) -> None:
        """Take alpha (C - L) a from the forces of planes, all of those before them done."""
        assert self._rows
        until = min(last + self._rows.reach, rank.grid.planes)
        found = self._known_below, max(self._known_below, until)
        rank.call(average_forces, *self._arguments, found, (first, last), self._buffer)
        self._known_below = found[1]

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Keep what contact has added to accelerations."""
        self._keys, self._pushed = self._keys[:0], self._pushed[:0]
        if changes := rank.contact.changes:
            moved = changes.velocities.any(axis=1)
            self._keys, self._pushed = changes.keys[moved], changes.velocities[moved] / update.t.dt

    @property
    def state(self) -> np.ndarray:
        """What contact added in the last step, for checkpoints: (m, 4) float64."""
        return np.concatenate([self._keys[:, None].view(np.float64), self._pushed], axis=1)

    def restore(self, state: np.ndarray) -> None:
        """Continue with the `state` of a checkpoint."""
        self._keys = np.ascontiguousarray(state[:, 0]).view(np.int64)
        self._pushed = np.ascontiguousarray(state[:, 1:])

    def _exchange(self, rank: RankState, reach: int) -> None:
        """Get the accelerations of planes that only the neighbours have; collective."""
        slab, comm, grid = rank.slab, rank.comm, rank.grid
        if not slab.neighbours:
            return
        size, A = reach * (grid.window.stride[0] // 2), self._accelerations
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
