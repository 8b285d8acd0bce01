"""Boxes of a lattice, also beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pgimp.scene.bodies.elements import Indices, Reals
from pgimp.scene.bodies.lattice_body import LatticeBody

#: Faces of the lattice, by axis and side.
Closed = Sequence[tuple[int, int]]


def edge(edges: Reals, i: Indices) -> Reals:
    """Coordinates of edges of boxes, also beyond the lattice."""
    last = len(edges) - 1
    inside = edges[np.clip(i, 0, last)]
    low, high = edges[1] - edges[0], edges[-1] - edges[-2]
    return inside + np.minimum(i, 0) * low + np.maximum(i - last, 0) * high


def combinations(axes: Sequence[Indices]) -> Indices:
    """All combinations of numbers, in C order, (n, D)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def exists(body: LatticeBody, ranges: Sequence[Indices]) -> NDArray[np.bool_]:
    """Mask of the boxes with a particle; none is beyond the lattice."""
    there = np.zeros([len(r) for r in ranges], bool)
    if not there.size:
        return there
    first = [int(r[0]) for r in ranges]
    for volumes in body.slabs((max(first[0], 0), max(int(ranges[0][-1]) + 1, 0))):
        shape = tuple(end - begin for begin, end in volumes.ranges)
        cut, place = [], []
        for (begin, end), a, r in zip(volumes.ranges, first, ranges, strict=True):
            low, high = max(begin, a), min(end, a + len(r))
            cut.append(slice(low - begin, max(low, high) - begin))
            place.append(slice(low - a, max(low, high) - a))
        there[tuple(place)] = volumes.exists.reshape(shape)[tuple(cut)]
    return there
