"""Forces of contact in the last steps, at which the sweeps of the next one begin."""

from __future__ import annotations

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.lagrangian.coupling import Coupling
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs
from pgimp.kernels.contact.lagrangian.rows import Solved
from pgimp.kernels.contact.lagrangian.warm_start import KEPT_FORCE, begin_impulses, keep_impulses
from pgimp.mpi.communicator import Communicator

#: Numbers of a kept force: vertex, bodies, force and its change.
WIDTH = KEPT_FORCE.itemsize // 8


class WarmStart:
    """Forces of pairs in the last step, and their changes, on the rank that solves.

    They are found by vertex and bodies, so that nothing depends on the ranks. A stage begins
    without them, as a checkpoint from before they were kept does.
    """

    def __init__(self, comm: Communicator) -> None:
        self.comm, self.call = comm, Bound()
        self._root: int | None = None
        self._kept = np.empty(0, KEPT_FORCE)
        self._storage = (self._kept, self._kept)

    def clear(self) -> None:
        """Let the next step begin at zero: nothing touches."""
        self._kept = self._kept[:0]

    def move_to(self, root: int) -> None:
        """Hand the forces to the rank that solves from now on; collective."""
        before, self._root = self._root, root
        if before is None or before == root:
            return
        numbers = np.array([len(self._kept)])
        self.comm.Bcast(numbers, before)
        message = np.empty((int(numbers[0]), WIDTH))
        if self.comm.rank == before:
            message[:] = self._kept.view(np.float64).reshape(-1, WIDTH)
        self.comm.Bcast(message, before)
        self._kept = (
            message.reshape(-1).view(KEPT_FORCE) if self.comm.rank == root else self._kept[:0]
        )

    def begin(
        self, contact: Contact, pairs: ContactPairs, coupling: Coupling, solved: Solved, dt: float
    ) -> None:
        """Set and apply the impulses that the last steps predict, on the rank that solves."""
        self.call(begin_impulses, contact, self._kept, pairs, coupling, solved, dt)

    def keep(self, pairs: ContactPairs, dt: float) -> None:
        """Keep the impulses of a step, on the rank that solves."""
        used, free = self._storage
        if len(free) < len(pairs.ends):
            free = np.empty(len(pairs.ends) + len(pairs.ends) // 8, KEPT_FORCE)
        found = self.call(keep_impulses, pairs, dt, self._kept, free)
        self._kept, self._storage = free[:found], (free, used)

    @property
    def kept(self) -> np.ndarray:
        """The forces of the last step, (n,) KEPT_FORCE, on the rank that solves."""
        return self._kept

    @property
    def stored(self) -> np.ndarray:
        """What a checkpoint has of this rank, (n, `WIDTH`) float64."""
        kept = self._kept
        if self._root is None and self.comm.rank != 0:  # all ranks have those of a checkpoint
            kept = kept[:0]
        whole = [kept[name].astype(np.float64) for name in ("vertex", "bodies")]
        return np.concatenate([*whole, kept["force"], kept["change"]], axis=1)

    def restore(self, stored: np.ndarray) -> None:
        """Continue with those of a checkpoint, on every rank."""
        kept = np.empty(len(stored), KEPT_FORCE)
        parts = np.split(stored, (3, 5, 8), axis=1)
        for name, values in zip(("vertex", "bodies", "force", "change"), parts, strict=True):
            kept[name] = values
        self._kept, self._root = kept, None
