"""The surface of a rigid body, for pictures: lines in 2D, quadrilaterals in 3D (surface nets).

A cell of the body's lattice has a vertex if the distance changes its sign along any of its edges.
The vertex is the mean of the zeros on these edges. Around each such edge the cells' vertices are
joined.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.distancefield import DistanceField

Points = NDArray[np.float64]
Cells = NDArray[np.int64]


def outline(field: DistanceField, D: int) -> tuple[Points, Cells]:
    """Return vertices, (n, 3), in the initial pose, and cells, (m, 2^(D - 1)).

    In 1D a cell has one vertex.
    """
    shape = tuple(int(n) for n in field.shape[:D])
    phi = field.values[:, 0].reshape(shape)
    inside = phi < 0.0
    cells = tuple(n - 1 for n in shape)
    total, number = np.zeros((*cells, D)), np.zeros(cells)
    for d in range(D):
        a = np.take(phi, range(shape[d] - 1), axis=d)
        b = np.take(phi, range(1, shape[d]), axis=d)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where((a < 0.0) != (b < 0.0), a / (a - b), np.nan)
        others = [e for e in range(D) if e != d]
        for corner in product((0, 1), repeat=D - 1):
            cut = [slice(None)] * D
            for e, offset in zip(others, corner, strict=True):
                cut[e] = slice(offset, offset + cells[e])
            there = part[tuple(cut)]
            crossed = np.isfinite(there)
            number += crossed
            total[..., d] += np.where(crossed, there, 0.0)
            for e, offset in zip(others, corner, strict=True):
                total[..., e] += offset * crossed
    found = number > 0.0
    numbers = np.full(cells, -1, np.int64)
    numbers[found] = np.arange(int(found.sum()))
    vertices = np.zeros((int(found.sum()), 3))
    offsets = total[found] / number[found][:, None]
    vertices[:, :D] = field.low[:D] + field.spacing * (np.argwhere(found) + offsets)
    return vertices, np.concatenate([_joined(inside, numbers, d, D) for d in range(D)])


def _joined(inside: NDArray[np.bool_], numbers: Cells, d: int, D: int) -> Cells:
    """Cells across the edges along direction `d`, each joining the vertices around an edge."""
    others = [e for e in range(D) if e != d]
    ahead = [slice(1, -1)] * D
    ahead[d] = slice(0, -1)
    behind = list(ahead)
    behind[d] = slice(1, None)
    crossed = inside[tuple(ahead)] != inside[tuple(behind)]
    rounds = {1: ((),), 2: ((0,), (1,)), 3: ((0, 0), (1, 0), (1, 1), (0, 1))}[D]
    columns = []
    for corner in rounds:
        cut = [slice(None)] * D
        for e, offset in zip(others, corner, strict=True):
            cut[e] = slice(offset, numbers.shape[e] - 1 + offset)
        columns.append(numbers[tuple(cut)][crossed])
    return np.stack(columns, axis=1)
