"""Forces of contact in the last steps, on the ranks that solve for their groups."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.solver.contact.lagrangian.warm_start import WIDTH, WarmStart


class KeptForces(WarmStart):
    """Forces of pairs in the last step: each rank has those of its groups."""

    _whole = False  # all ranks have all of them, as after a restart

    def divide(self, mine: Callable[[np.ndarray], np.ndarray]) -> None:
        """Keep those that are `mine`, a mask given bodies (n, 2), of all; collective."""
        if self.comm.size == 1:
            return
        if not self._whole:
            self._kept = self._together()
        self._whole = False
        self._kept = self._kept[mine(self._kept["bodies"])]

    def _together(self) -> np.ndarray:
        """Those of all ranks in the order of patches; collective."""
        own = np.ascontiguousarray(self._kept).view(np.float64).reshape(-1, WIDTH)
        every = np.concatenate(self.comm.allgather(own)).reshape(-1).view(self._kept.dtype)
        return every[np.lexsort((*every["bodies"].T[::-1], *every["vertex"].T[::-1]))]

    @property
    def stored(self) -> np.ndarray:
        """What a checkpoint has, on the first rank, (n, `WIDTH`) float64; collective."""
        before = self._kept
        if self.comm.size > 1:
            every = before if self._whole else self._together()
            self._kept = every if self.comm.rank == 0 else every[:0]
        self._root = 0
        found = super().stored
        self._kept = before
        return found

    def restore(self, stored: np.ndarray) -> None:
        """Continue with those of a checkpoint, on every rank."""
        super().restore(stored)
        self._whole = True
