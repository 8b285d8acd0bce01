"""Common particles of two frames, read block by block."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pgimp.io.results.reader import Frame
from pgimp.physics.fields import components_of

Array = np.ndarray


class Pair:
    """Two frames, particle by particle.

    Parameters
    ----------
    first, second : Frame
        The frames.
    block : int
        Rows per block.

    Attributes
    ----------
    only : (ndarray, ndarray)
        Ids in only one of the frames; empty unless `comparable`.
    comparable : bool
        Whether particles can be identified: the frames have the same ids in the same order, or
        both have ascending ids.
    """

    def __init__(self, first: Frame, second: Frame, block: int) -> None:
        self._first, self._second, self._block = first, second, block
        self._length = len(first)
        self._rows: tuple[Array, Array] | None = None
        self.only = (np.empty(0, np.int64), np.empty(0, np.int64))
        same = len(first) == len(second)
        self.comparable = True
        if same and all(np.array_equal(one, two) for _, one, two in self.blocks("id")):
            return
        one, two = first["id"], second["id"]
        self.comparable = all(bool((np.diff(ids) > 0).all()) for ids in (one, two))
        if self.comparable:
            common, mine, others = np.intersect1d(one, two, True, True)
            self._length, self._rows = len(common), (mine, others)
            self.only = (np.setdiff1d(one, two, True), np.setdiff1d(two, one, True))

    def __len__(self) -> int:
        """Return the number of common particles."""
        return self._length

    def components(self, field: str) -> list[str]:
        """Names of the components of a field; none for a scalar."""
        values = self._first.rows(field, 0, 0)
        return components_of(field, values.shape[1]) if values.ndim == 2 else []

    def blocks(self, field: str) -> Iterator[tuple[int, Array, Array]]:
        """Iterate over a field of the common particles.

        Yields
        ------
        int, ndarray, ndarray
            Number of the block's first particle, values in the first and in the second frame.
        """
        for start in range(0, self._length, self._block):
            stop = min(start + self._block, self._length)
            if self._rows is None:
                yield (
                    start,
                    self._first.rows(field, start, stop),
                    self._second.rows(field, start, stop),
                )
            else:
                mine, others = self._rows
                yield (
                    start,
                    _taken(self._first, field, mine[start:stop]),
                    _taken(self._second, field, others[start:stop]),
                )

    def number(self, place: int) -> int:
        """Id of a common particle, given by its number."""
        row = place if self._rows is None else int(self._rows[0][place])
        return int(self._first.rows("id", row, row + 1)[0])


def _taken(frame: Frame, field: str, rows: Array) -> Array:
    """Values of a field in ascending, nearly contiguous rows."""
    return frame.rows(field, int(rows[0]), int(rows[-1]) + 1)[rows - rows[0]]
