"""Elements of the faces of whole boxes, and of bodies that are boxes themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.geometry.rows import ascending
from pgimp.scene.bodies.elements import Elements, Indices
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.boxes import Closed, combinations, edge, exists


def whole_elements(body: LatticeBody, ranges: Sequence[Indices], closed: Closed) -> Elements:
    """Faces between boxes with a particle and without one."""
    D = len(ranges)
    wide = [np.arange(r[0] - 1, r[-1] + 2) if len(r) else r for r in ranges]
    there = exists(body, wide)
    for d, side in closed:
        beyond = -1 if side < 0 else len(body.edges[d]) - 1
        along = np.moveaxis(there, d, 0)
        if len(wide[d]) and beyond in wide[d] and beyond - side in wide[d]:
            along[beyond - wide[d][0]] = along[beyond - side - wide[d][0]]
    every, offsets = [], [np.zeros((0, D), np.int64)]
    for d in range(D):
        for side in (-1, 1):
            inner = tuple(slice(1, -1) for _ in range(D))
            other = tuple(
                slice(1 + side * (j == d), there.shape[j] - 1 + side * (j == d)) for j in range(D)
            )
            box = np.argwhere(there[inner] & ~there[other])
            offsets.append(box + [r[0] if len(r) else 0 for r in ranges])
            every.append((d, side))
    parts = []
    for (d, side), box in zip(every, offsets[1:], strict=True):
        low, high = (
            np.stack([edge(e, box[:, j] + k) for j, e in enumerate(body.edges)], axis=1)
            for k in (0, 1)
        )
        area, size = np.zeros(low.shape), high - low
        area[:, d] = side
        for j in range(D):
            area[:, d] *= size[:, j] if j != d else 1.0
        centre = 0.5 * (low + high)
        centre[:, d] = (low, high)[side > 0][:, d]
        half = 0.5 * np.where(np.arange(D) == d, 0.0, size)
        parts.append(Elements.flat(box, centre, area, half))
    found = Elements(*map(np.concatenate, zip(*parts, strict=True)))
    return found.chosen(ascending(found.box))


def face_elements(body: LatticeBody, axis: int, side: int, planes: tuple[int, int]) -> Elements:
    """Elements of a face of a body that is a box, one in each box of the lattice.

    Parameters
    ----------
    axis, side : int
        The face's normal is `side` times the unit vector `axis`.
    planes : (int, int)
        First plane and end.
    """
    low, high = (np.array(end) for end in body.region.bounds())
    D, ranges, ends = len(body.edges), [], []
    for d, e in enumerate(body.edges):
        a, b = np.maximum(e[:-1], low[d]), np.minimum(e[1:], high[d])
        some = np.flatnonzero(a < b)
        if d == axis:
            some = some[-1:] if side > 0 else some[:1]
            a[some] = b[some] = (low, high)[side > 0][d]
        if d == 0:
            some = some[(planes[0] <= some) & (some < planes[1])]
        ranges.append(some)
        ends.append((a, b))
    box = combinations(ranges)
    a, b = (np.stack([ends[d][k][box[:, d]] for d in range(D)], axis=1) for k in (0, 1))
    area = np.zeros(box.shape)
    area[:, axis] = side * np.where(np.arange(D) == axis, 1.0, b - a).prod(axis=1)
    return Elements.flat(box, 0.5 * (a + b), area, 0.5 * (b - a))
