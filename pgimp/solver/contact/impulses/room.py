"""Arrays for the pairs of a step and their solution, which are kept for the next one, and grow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pgimp.kernels.contact.data import PAIR_STATE
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ENDS, ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import Changes
from pgimp.kernels.contact.impulses.rows import Solved
from pgimp.kernels.contact.surfaces.groups import PREPARED
from pgimp.kernels.contact.surfaces.patches.levels import GATHERED, NUMBERED

#: Cells whose sums a row has at once.
_CELLS = 16


class Room:
    """Arrays for pairs, their rows, and their solution. Nothing in them lasts.

    Slices are kept as long as sizes hold: in small scenes they cost as much as kernels. Arrays of
    rows, entries and pairs of a solution have room for more.

    Attributes
    ----------
    entries : int
        How many entries rows may have.
    """

    def __init__(self) -> None:
        self._kept: dict[str, np.ndarray] = {}
        self._made: dict[str, tuple[tuple[int, ...], Any]] = {}  # with their sizes
        self.entries = 0
        self._most = [0, 0, 0]  # rows, entries and pairs of solutions

    def _have(self, name: str, count: int, *shape: int, of: Any = np.float64) -> np.ndarray:
        """An array of a kind, with any numbers in it."""
        kept = self._kept.get(name)
        if kept is None or len(kept) < count:
            kept = self._kept[name] = np.empty((count + count // 4, *shape), of)
            self._made.clear()
        return kept[:count]

    def _once(self, name: str, make: Callable[..., Any], *sizes: int) -> Any:
        """What is made of the arrays for some sizes: the same as long as these are."""
        made = self._made.get(name)
        if made is None or made[0] != sizes:
            made = sizes, make(*sizes)
            self._made[name] = made
        return made[1]

    def found(self, pairs: int, entries: int) -> tuple[ContactPairs, Coupling]:
        """Room for so many pairs, and for at least so many entries of their rows."""
        self.entries = max(self.entries, entries, 8 * pairs)
        return self._once("found", self._filled, pairs, 2 * pairs, self.entries)

    def filled(self, pairs: int, rows: int, entries: int) -> tuple[ContactPairs, Coupling]:
        """What is filled of these, without a copy."""
        return self._once("filled", self._filled, pairs, rows, entries)

    def _filled(self, pairs: int, rows: int, entries: int) -> tuple[ContactPairs, Coupling]:
        have = self._have
        return ContactPairs(
            have("ends", pairs, of=ENDS), have("states", pairs, of=PAIR_STATE),
            have("rigid", pairs, 3, 3),
        ), Coupling(
            have("start", rows + 1, of=np.int64), have("column", entries, of=np.int64),
            have("entry", entries, 1), have("answer", rows, 3),
        )  # fmt: skip

    def gathering(self, vertices: int, facets: int, D: int) -> tuple[Any, ...]:
        """Scratch for so many vertices, and for as many facets of a patch, see `find_patch_pairs`.

        It is what comes between the vertices' values and pieces of facets.
        """
        return self._once("gathering", self._gathering, vertices, facets, D)

    def _gathering(self, vertices: int, facets: int, D: int) -> tuple[Any, ...]:
        known = self._kept.get("own")
        if known is None or known.shape[1] < facets + 3:
            most = facets + facets // 4 + 3
            self._kept["own"] = np.empty((GATHERED, most))
            self._kept["numbers"] = np.empty((NUMBERED, most), np.int64)
        cells = self._have("sums", _CELLS, 2**D), self._have("cells", _CELLS, of=np.int64)
        seen = self._have("seen", vertices, 2, of=np.int64)
        return seen, (*cells, self._kept["own"], self._kept["numbers"])

    def solved(self, vertices: int, coupling: Coupling) -> Solved:
        """Vertices for `begin_solution`."""
        self._grow(len(coupling.answer), len(coupling.column))
        return self._once("solved", self._without_soft, vertices)

    def _grow(self, *sizes: int) -> None:
        """Have room for so many rows, entries and pairs."""
        for n, size in enumerate(sizes):
            if size > self._most[n]:
                self._most[n] = size + size // 4
                self._made.clear()

    def _without_soft(self, vertices: int) -> Solved:
        return self._solved("", vertices)._replace(soft=self._have("none", 0, 3))

    def _solved(self, which: str, vertices: int) -> Solved:
        have, (rows, entries, _) = self._have, self._most
        return Solved(
            have("v" + which, vertices, 4), have("w" + which, vertices, 4),
            have("held" + which, vertices, 4), have("moved" + which, entries),
            have("free" + which, rows, of=np.bool_), have("soft" + which, rows, 3),
        )  # fmt: skip

    def changes(self, vertices: int) -> Changes:
        """Room for what impulses change at so many vertices."""
        return self._once("changes", self._changes, vertices)

    def changed(self, vertices: int) -> Changes:
        """What is filled of it, without a copy."""
        return self._once("changed", self._changes, vertices)

    def _changes(self, vertices: int) -> Changes:
        have = self._have
        return Changes(
            have("changed", vertices, of=np.int64), have("velocities", vertices, 3),
            have("bears", vertices, 3),
        )  # fmt: skip

    def prepared(self, pairs: int) -> np.ndarray:
        """Scratch of `solve_groups`."""
        return self._have("prepared", pairs, PREPARED)

    def soft(self, vertices: int, pairs: int, coupling: Coupling) -> tuple[Any, ...]:
        """Scratch of `solve_softly`."""
        self._grow(len(coupling.answer), len(coupling.column), pairs)
        return self._once("soft", self._soft, vertices)

    def _soft(self, vertices: int) -> tuple[Any, ...]:
        have, (rows, _, pairs) = self._have, self._most
        scratch = have("at", vertices, 4), have("before", pairs, 3), have("areas", pairs)
        answer = have("softened", rows, 3)
        softened = self._solved("soft", vertices)
        return softened, answer, scratch, self.prepared(pairs)
