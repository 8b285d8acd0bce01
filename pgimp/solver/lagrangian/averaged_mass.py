"""Averaged mass in a step: a part of the forces for bodies in the initial configuration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.image_values import copy_accelerations
from pgimp.kernels.grid.mirror import fold_forces
from pgimp.kernels.lagrangian.averaged_mass import (
    NUMBERS,
    Accelerations,
    Links,
    MassRows,
    average_forces,
    leave_links,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.averaging import averaged_parts
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.bearing import links_at
from pgimp.solver.lagrangian.mass_rows import find_rows
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

#: Tags of messages with accelerations.
_UP, _DOWN = 23, 24

#: Numbers of accelerations that are found and used together: with forces 3 MB.
_CACHED = 1 << 17


class AveragedMass(StepPart):
    """The averaged mass on one rank, see `pgimp.kernels.lagrangian.averaged_mass`.

    While a run comes to rest the lumped mass is enough.

    Contact acts later in a step: vertices that it has moved in the last one keep the lumped mass,
    see `pgimp.solver.lagrangian.bearing`.

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
        #: (m,) int64: Vertices that contact moves, ascending, see `reference_grid`; which slaves
        #: move with these, and their links, once they are found.
        self._bearing = np.empty(0, np.int64)
        self._slaves = np.empty(0, bool)
        self._links: Links | None = None

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
            self._known, self._rows, self._links = field, find_rows(rank, self.alpha), None
            self._buffer = aligned(half)
        mirrors = *domain.absorbing_mirrors, *domain.mirrors
        images = *domain.seams, *sorted(mirrors, key=lambda each: each.releases)  # as sums fold
        acts, slaves = rank.grips and rank.grips.acts, rank.slaves
        self._left = rank.contact.by_planes and not (images or slaves)
        pressed = rank.contact.bears and needed(len(self._bearing))
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
        if slaves:
            own = A[reach * half : (reach + grid.planes) * half]
            masters = slaves.spread(rank, own, 1, NUMBERS)
        for each in reversed(images):
            rank.call(copy_accelerations, frame, field, each, A, reach)
        self._exchange(rank, reach)
        if not self._left:
            rank.call(average_forces, *self._arguments, accelerations, rows, none, every)
        if pressed:
            self._links = self._links or self._find_links(rank, images, reach)
            rank.call(leave_links, field, self._links, A)
        for each in images:
            rank.call(fold_forces, frame, field, each, forcing.dt, update.ledger)
        if slaves:
            slaves.fold_averages(rank, self.alpha, masters, self._slaves)

    def _find_links(self, rank: RankState, images: Sequence[Any], reach: int) -> Links:
        """Find the links that end at vertices that contact moves, and these slaves; collective."""
        from pgimp.kernels.contact.impulses.reference_grid import add_accelerations

        frame, field, keys = self.scene.domain.frame, rank.grid.field, self._bearing
        slaves, kept = rank.slaves, self._values
        first = reach * (rank.grid.window.stride[0] // RECORD)
        self._values = np.zeros_like(kept)  # marks go the way of accelerations
        ones, marks = np.ones((len(keys), 3)), self._values.reshape(-1, NUMBERS)
        rank.call(add_accelerations, frame, field, keys, ones, self._values, reach)
        if slaves:
            self._slaves = slaves.led_by(rank, marks[first:].any(axis=1))
            marks[first + slaves.records(rank, self._slaves)] = 1.0
        for each in reversed(images):
            rank.call(copy_accelerations, frame, field, each, self._values, reach)
        self._exchange(rank, reach)
        self._values = kept
        assert self._rows
        return links_at(self._rows, np.flatnonzero(marks.any(axis=1)), reach, rank.grid.window)

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
        """Keep which vertices contact moves."""
        keys = np.empty(0, np.int64)
        if changes := rank.contact.changes:
            keys = np.sort(changes.keys[changes.velocities.any(axis=1)])
        if not np.array_equal(keys, self._bearing):
            self.restore(keys)

    @property
    def state(self) -> np.ndarray:
        """The vertices that contact moves, for checkpoints: (m,) float64, the bits of int64."""
        return self._bearing.view(np.float64)

    def restore(self, state: np.ndarray) -> None:
        """Continue with the vertices of a checkpoint, (m,) int64."""
        self._bearing, self._links, self._slaves = state, None, np.empty(0, bool)

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
