"""The decomposition: each rank owns a run of layers along x, or none."""

from typing import NamedTuple

import numpy as np


class Slab(NamedTuple):
    """The layers of one rank, and its neighbours' ranks (None where there is none)."""

    first: int
    layers: int
    below: int | None
    above: int | None

    @property
    def neighbours(self) -> bool:
        """Whether there are any."""
        return self.below is not None or self.above is not None


def cut(counts: np.ndarray, ranks: int, width: int, ends: int = 0) -> list[int]:
    """Cut the layers into runs of about equally many particles.

    Parameters
    ----------
    counts : (layers,) int64
        Particles of each layer.
    ranks : int
        Ranks to share them; those for which there are too few layers get none.
    width : int
        Least number of layers of a rank: with thinner slabs nearest neighbours would not suffice.
    ends : int
        Least number of layers of the first and of the last rank, if more.

    Returns
    -------
    list of int
        First layers of the ranks that own some, and the number of layers.
    """
    layers = len(counts)
    ends = max(width, ends)
    active = max(1, min(ranks, (layers - 2 * ends) // width + 2 if layers >= 2 * ends else 1))
    total = np.concatenate(([0], np.cumsum(counts)))
    cuts = [0]
    for k in range(1, active):
        ideal = int(np.abs(total * active - k * total[-1]).argmin())
        least = cuts[-1] + (ends if k == 1 else width)
        cuts.append(min(max(ideal, least), layers - ends - (active - 1 - k) * width))
    return [*cuts, layers]


def slab_of(cuts: list[int], rank: int) -> Slab:
    """Slab of a rank, from the result of `cut`."""
    active = len(cuts) - 1
    if rank >= active:
        return Slab(cuts[-1], 0, None, None)
    return Slab(
        cuts[rank],
        cuts[rank + 1] - cuts[rank],
        rank - 1 if rank > 0 else None,
        rank + 1 if rank + 1 < active else None,
    )
