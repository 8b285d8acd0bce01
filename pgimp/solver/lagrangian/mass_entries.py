"""Entries of the rows of the averaged mass, from particles and their weights."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from pgimp.kernels.data.record import RECORD
from pgimp.kernels.lagrangian.averaged_mass import NUMBERS


class Weighed(NamedTuple):
    """Particles with a part in the averaged mass, an entry each."""

    layer: np.ndarray  #: (n,) int64: The layer, counted from the rank's first one.
    id: np.ndarray  #: (n,) int64: The number.
    mass: np.ndarray  #: (n,) float64: alpha times the mass.
    first: np.ndarray  #: (n,) int64: Number of the first vertex of the support in its plane.
    #: (n, D, vertices) float64: Weights along each direction; of parts of cells (n, 2^D) float64,
    #: those of the cell's corners.
    weights: np.ndarray

    def chosen(self, which: np.ndarray) -> Weighed:
        """Some of them."""
        return Weighed(*(each[which] for each in self))

    def moved(self, layers: int) -> Weighed:
        """The same, in layers counted from another one."""
        return self._replace(layer=self.layer + layers)

    @property
    def support(self) -> tuple[int, int]:
        """Directions, and vertices along each."""
        size = self.weights.shape[1:]
        return (int(size[0]).bit_length() - 1, 2) if len(size) == 1 else (size[0], size[1])

    def touches(self, corner: tuple[int, ...]) -> np.ndarray:
        """Whether each has a weight at a vertex of its support, (n,)."""
        if self.weights.ndim == 2:
            return np.asarray(self.weights[:, int("".join(map(str, corner)), 2)] > 0.0)
        return np.asarray((self.weights[:, range(len(corner)), corner] > 0.0).all(axis=1))

    def by_plane(self, vertices: int) -> np.ndarray:
        """Weights of the first vertices along each direction, (n, vertices, vertices^(D - 1))."""
        weights, n, across = self.weights, len(self.mass), 1
        if weights.ndim == 2:
            return weights.reshape(n, 2, weights.shape[1] // 2)
        flat = np.ones((n, 1))
        for d in range(1, weights.shape[1]):
            across *= vertices
            flat = (flat[:, :, None] * weights[:, d, None, :vertices]).reshape(n, across)
        return weights[:, 0, :vertices, None] * flat[:, None, :]


def vertex_offset(corner: tuple[int, ...], z: int) -> int:
    """Number of a vertex in its plane, counted from a support's first one."""
    y, k = (*corner, 0, 0)[:2]
    return y * z + k


def rows_of(particles: Weighed, uniform: np.ndarray, reach: int) -> tuple[np.ndarray, ...]:
    """The first six arrays of `MassRows`, of vertices that are not amid whole cells."""
    planes, _, _, z = uniform.shape
    size = uniform[0].size if planes else 0
    # Most supports are corners of a cell only.
    few = np.ones(len(particles.mass), bool)
    if particles.weights.ndim == 3:
        few = (particles.weights[:, :, 2:] == 0.0).all(axis=(1, 2))
    groups = [(2, particles.chosen(few)), (reach + 1, particles.chosen(~few))]
    wide = 2 * reach + 1
    rel = np.meshgrid(*[np.arange(wide) - reach] * particles.support[0], indexing="ij")
    y, k = ([each.reshape(-1) for each in rel[1:]] + [np.zeros(1, np.int64)] * 2)[:2]
    distance = NUMBERS * (rel[0].reshape(-1) * size + y * z + k)
    start, vertex, count, column, value = [0], [], [], [], []
    for plane in range(planes):
        keys, values, others = [], [], uniform[plane].reshape(-1) == 0.0
        for vertices, group in groups:
            for key, entries in _entries(group, plane, vertices, reach, z, others):
                keys.append(key)
                values.append(entries)
        key, entries = np.concatenate(keys), np.concatenate(values)
        at, inverse = np.unique(key // len(distance), return_inverse=True)
        table = np.bincount(
            inverse * len(distance) + key % len(distance), entries, len(at) * len(distance)
        ).reshape(len(at), len(distance))
        row, code = np.nonzero(table)
        start.append(start[-1] + len(at))
        vertex.append(RECORD * at)
        count.append(np.bincount(row, minlength=len(at)))
        column.append(distance[code])
        value.append(table[row, code])
    joined = [
        np.concatenate([np.zeros(0, np.int64), *each]).astype(np.int64)
        for each in (vertex, count, column)
    ]
    found = _patterns(joined[1], joined[2], np.concatenate([np.zeros(0), *value]))
    return np.array(start, np.int64), joined[0], *found


def _entries(
    particles: Weighed, plane: int, vertices: int, reach: int, z: int, others: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield keys and values of a plane's rows that particles add, in the order of the sum.

    A key is the vertex's number in the plane times the number of distances, and that of its own.
    `others` are the vertices that are not amid whole cells.
    """
    D, wide = particles.support[0], 2 * reach + 1
    corners = list(product(range(vertices), repeat=D - 1))
    shift = np.array([vertex_offset(c, z) for c in corners])
    code = [[_code(a, b, reach) for b in corners] for a in corners]
    across = np.array(code).reshape(len(corners), len(corners))
    for a in reversed(range(vertices)):
        low, high = np.searchsorted(particles.layer, [plane - a, plane - a + 1])
        mine = particles.chosen(np.arange(low, high))
        weights = mine.by_plane(vertices)
        at, own = mine.first[:, None] + shift, weights[:, a]
        some = (own > 0.0) & others[np.where(own > 0.0, at, 0)]
        for b in range(vertices):
            # The product of weights comes first: rows are symmetric to the last bit.
            pair = own[:, :, None] * weights[:, b, None, :]
            there = some[:, :, None] & (pair > 0.0)
            if a == b:
                there &= ~np.eye(len(corners), dtype=bool)
            along = (b - a + reach) * wide ** (D - 1)
            key = at[:, :, None] * wide**D + (along + across)
            yield key[there], (mine.mass[:, None, None] * pair)[there]


def _code(a: tuple[int, ...], b: tuple[int, ...], reach: int) -> int:
    """Number of the distance in a plane from corner `a` to corner `b`."""
    code = 0
    for i, j in zip(a, b, strict=True):
        code = code * (2 * reach + 1) + j - i + reach
    return code


def runs_of(uniform: np.ndarray, D: int) -> tuple[np.ndarray, ...]:
    """The last four arrays of `MassRows`."""
    planes, z = len(uniform), uniform.shape[3]
    row = NUMBERS * (z if D == 3 else max(uniform[:1].size, 1))
    start, span, run, mass = [0], [], [np.zeros((0, 2), np.int64)], [np.zeros(0)]
    for plane in range(planes):
        m = np.concatenate([[0.0], uniform[plane].reshape(-1), [0.0]])
        edge = np.flatnonzero(m[1:] != m[:-1])
        pairs = np.stack([edge[:-1], edge[1:]], axis=1)
        pairs = pairs[m[pairs[:, 0] + 1] > 0.0]
        run.append(NUMBERS * pairs)
        mass.append(m[pairs[:, 0] + 1])
        start.append(start[-1] + len(pairs))
        begin = run[-1][:, 0] % row
        end = run[-1][:, 1] - run[-1][:, 0] + begin
        span.append((begin.min() - NUMBERS, end.max() + NUMBERS) if len(pairs) else (0, 0))
    return (
        np.array(start, np.int64), np.array(span, np.int64).reshape(planes, 2),
        np.concatenate(run), np.concatenate(mass),
    )  # fmt: skip


def _patterns(count: np.ndarray, column: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, ...]:
    """Entries that differ, of rows with so many entries each.

    Returns
    -------
    pattern, first, column, value
        See `MassRows`.
    """
    known: dict[bytes, int] = {}
    pattern, kept = np.zeros(len(count), np.int64), list[np.ndarray]()
    ends = np.cumsum(count)
    for n, (begin, end) in enumerate(zip((ends - count).tolist(), ends.tolist(), strict=True)):
        key = column[begin:end].tobytes() + value[begin:end].tobytes()
        pattern[n] = known.setdefault(key, len(known))
        if pattern[n] == len(kept):
            kept.append(np.arange(begin, end))
    where = np.concatenate([np.zeros(0, np.int64), *kept])
    first = np.concatenate([[0], np.cumsum([len(each) for each in kept])]).astype(np.int64)
    return pattern, first, column[where], value[where]
