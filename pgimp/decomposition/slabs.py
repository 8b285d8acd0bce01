"""The decomposition: each rank owns a run of layers along x, or none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

#: Layers round the equal-share position among which the best position of a boundary is sought.
_NEARBY = 16


class Slab(NamedTuple):
    """The layers of one rank, and its neighbours' ranks (None without one)."""

    first: int
    layers: int
    lower: int | None
    upper: int | None

    @property
    def neighbours(self) -> bool:
        """Whether there are any."""
        return self.lower is not None or self.upper is not None


def most_slabs(layers: int, width: int, ends: int = 0) -> int:
    """Greatest number of ranks with layers, see `cut`."""
    ends = max(width, ends)
    return (layers - 2 * ends) // width + 2 if layers >= 2 * ends else 1


def cut(costs: ArrayLike, ranks: int, width: int, ends: int = 0) -> list[int]:
    """Cut the layers into runs with the least greatest cost of a run.

    Of several solutions, the one with the least sum of squares. A boundary is at most `_NEARBY`
    layers from the position of right shares on both sides. In a group of boundaries at their least
    distance, it is near the group's middle.

    Parameters
    ----------
    costs : (layers,) int or float
        Cost of each layer, not negative: its number of particles, or seconds.
    ranks : int
        Ranks to share them; where there are too few layers, the last ranks get none.
    width : int
        Least number of layers of a rank: with thinner slabs nearest neighbours would not suffice.
    ends : int
        Least number of layers of the first and of the last rank, if more.

    Returns
    -------
    list of int
        First layers of the ranks that own some, and the number of layers.
    """
    costs = np.asarray(costs, float)
    layers = len(costs)
    ends = max(width, ends)
    active = max(1, min(ranks, most_slabs(layers, width, ends)))
    if active == 1:
        return [0, layers]
    total = np.concatenate([[0.0], np.cumsum(costs if costs.any() else np.ones(layers))])

    # Boundaries less the least number of layers of the ranks before: then they only have to
    # ascend.
    least = ends + width * np.arange(active - 1)
    slack = layers - ends - int(least[-1])
    shares = total[-1] * np.arange(1, active) / active
    ideal = np.searchsorted(total, shares)
    ideal -= shares - total[ideal - 1] < total[ideal] - shares
    ideal -= least
    highest, lowest = np.maximum.accumulate(ideal), np.minimum.accumulate(ideal[::-1])[::-1]
    middle = np.clip((highest + lowest) // 2, 0, slack)

    low, high = np.maximum(middle - _NEARBY, 0), np.minimum(middle + _NEARBY, slack)
    inner = [np.arange(a, b + 1) for a, b in zip(low + least, high + least, strict=True)]
    candidates = [np.array([0]), *inner, np.array([layers])]
    widths = [ends, *[width] * (active - 2), ends]
    most = _best_cuts(total, candidates, widths, np.inf)[1]
    return [0, *_best_cuts(total, candidates, widths, most)[0], layers]


def _best_cuts(
    total: np.ndarray, candidates: list[np.ndarray], widths: Sequence[int], bound: float
) -> tuple[list[int], float]:
    """Boundaries with the least greatest cost of a run or, for a bound on it, of least squares.

    Parameters
    ----------
    total : (layers + 1,) float64
        Cost of all layers below.
    candidates : sequence of arrays of int
        Possible positions of each boundary, including the first and the last one.
    widths : sequence of int
        Least number of layers between a boundary and the next.

    Returns
    -------
    boundaries : list of int
        Without the first and the last.
    value : float
        Cost of the most expensive run, or the sum of squares.
    """
    value, choices = np.zeros(1), []
    for lower, upper, width in zip(candidates, candidates[1:], widths, strict=False):
        run = total[upper][:, None] - total[lower]
        run[upper[:, None] - lower < width] = np.inf
        if bound < np.inf:
            run[run > bound] = np.inf
            every = value + run * run
        else:
            every = np.maximum(value, run)
        choices.append(every.argmin(axis=1))
        value = every.min(axis=1)
    boundaries: list[int] = []
    index = 0
    for k in range(len(choices) - 1, 0, -1):
        index = choices[k][index]
        boundaries.append(int(candidates[k][index]))
    return boundaries[::-1], float(value[0])


def imbalance_of(costs: np.ndarray, cuts: list[int]) -> float:
    """Cost of the most expensive rank over the mean, less one."""
    parts = np.add.reduceat(costs, cuts[:-1])
    return float(parts.max() / parts.mean()) - 1.0 if parts.any() else 0.0


def slab_of(cuts: list[int], rank: int, ring: int | None = None) -> Slab:
    """Slab of a rank, from the result of `cut`.

    Parameters
    ----------
    cuts, rank
        The cuts, and the rank.
    ring : int, optional
        Number of the first layer of a ring, where faces across x are periodic. The first and the
        last rank are then neighbours, and a single one is its own.
    """
    active, first = len(cuts) - 1, ring or 0
    if rank >= active:
        return Slab(first + cuts[-1], 0, None, None)
    below, above = rank - 1 if rank > 0 else None, rank + 1 if rank + 1 < active else None
    if ring is not None:
        below, above = (rank - 1) % active, (rank + 1) % active
    return Slab(first + cuts[rank], cuts[rank + 1] - cuts[rank], below, above)


def common(a: Slab, b: Slab) -> tuple[int, int]:
    """First layer that two slabs have in common, and the end of the common layers."""
    first = max(a.first, b.first)
    return first, max(first, min(a.first + a.layers, b.first + b.layers))
