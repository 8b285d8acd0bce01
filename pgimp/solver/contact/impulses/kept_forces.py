"""Forces of contact in the last steps, at which the sweeps of the next one begin."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.rows import Solved
from pgimp.kernels.contact.impulses.warm_start import KEPT_FORCE, begin_impulses, keep_impulses
from pgimp.mpi.communicator import Communicator

#: Numbers of a kept force: vertex, bodies, force, its change, and an acceleration.
WIDTH = KEPT_FORCE.itemsize // 8


class KeptForces:
    """Forces of pairs in the last step, and their changes: each rank has those of its groups.

    They are found by place and bodies, so that nothing depends on the ranks. A stage begins without
    them, as a checkpoint from before they were kept does.
    """

    def __init__(self, comm: Communicator) -> None:
        self.comm, self.call = comm, Bound()
        self._kept = np.empty(0, KEPT_FORCE)
        self._storage = (self._kept, self._kept)
        self._whole = False  # all ranks have all of them, as after a restart

    def clear(self) -> None:
        """Let the next step begin at zero: nothing touches."""
        self._kept = self._kept[:0]

    def divide(self, mine: Callable[[np.ndarray], np.ndarray]) -> None:
        """Keep those that are `mine`, a mask given bodies (n, 2), of all; collective."""
        if self.comm.size == 1:
            return
        if not self._whole:
            self._kept = self._together()
        self._whole = False
        self._kept = self._kept[mine(self._kept["bodies"])]

    def begin(
        self, contact: Contact, pairs: ContactPairs, coupling: Coupling, solved: Solved, dt: float
    ) -> None:
        """Set and apply the impulses that the last steps predict, on a rank that solves."""
        self.call(begin_impulses, contact, self._kept, pairs, coupling, solved, dt)

    def keep(
        self, pairs: ContactPairs, coupling: Coupling, solved: Solved, values: np.ndarray, dt: float
    ) -> None:
        """Keep the impulses of a step, on a rank that solves."""
        used, free = self._storage
        if len(free) < len(pairs.ends):
            free = np.empty(len(pairs.ends) + len(pairs.ends) // 8, KEPT_FORCE)
        found = self.call(keep_impulses, pairs, coupling, solved, values, dt, self._kept, free)
        self._kept, self._storage = free[:found], (free, used)

    @property
    def kept(self) -> np.ndarray:
        """The forces of the last step, (n,) KEPT_FORCE, on a rank that solves."""
        return self._kept

    def _together(self) -> np.ndarray:
        """Those of all ranks in the order of patches; collective."""
        own = np.ascontiguousarray(self._kept).view(np.float64).reshape(-1, WIDTH)
        every = np.concatenate(self.comm.allgather(own)).reshape(-1).view(self._kept.dtype)
        return every[np.lexsort((*every["bodies"].T[::-1], *every["vertex"].T[::-1]))]

    @property
    def stored(self) -> np.ndarray:
        """What a checkpoint has, on the first rank, (n, `WIDTH`) float64; collective."""
        kept = self._kept if self._whole else self._together()
        kept = kept if self.comm.rank == 0 else kept[:0]
        whole = [kept[name].astype(np.float64) for name in ("vertex", "bodies")]
        return np.column_stack([*whole, kept["force"], kept["change"], kept["acceleration"]])

    def restore(self, stored: np.ndarray) -> None:
        """Continue with those of a checkpoint, on every rank."""
        kept = np.zeros(len(stored), KEPT_FORCE)
        parts = np.split(stored, (3, 5, 8, 11), axis=1)
        for name, values in zip(("vertex", "bodies", "force", "change"), parts, strict=False):
            kept[name] = values
        if stored.shape[1] == WIDTH:  # older checkpoints have none
            kept["acceleration"] = stored[:, -1]
        self._kept, self._whole = kept, True
