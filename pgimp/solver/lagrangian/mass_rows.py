"""Rows of the averaged mass at a rank's vertices, found once; see `kernels.lagrangian`.

Sums go over particles by layer and number, and neighbours tell each other of those that reach the
planes of both. So rows have the same bits on any number of ranks, and in a resumed run.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.lagrangian.averaged_mass import NUMBERS, MassRows, find_weights
from pgimp.solver.rank_state import RankState

#: Tags of messages to the upper and to the lower neighbour.
_UP, _DOWN = 21, 22

#: Weights below this are rounding, at vertices without mass.
_LEAST = 1e-12

#: Distance from the lattice, in cells, up to which a particle lies on it.
_NEAR = 1e-6


class _Weighed(NamedTuple):
    """Particles with a part in the averaged mass, an entry each.

    Attributes
    ----------
    layer : (n,) int64
        The layer, counted from the rank's first one.
    id : (n,) int64
        The number.
    mass : (n,) float64
        alpha times the mass.
    first : (n,) int64
        Number of the first vertex of the support in its plane.
    weights : (n, D, vertices) float64
        Weights along each direction.
    """

    layer: np.ndarray
    id: np.ndarray
    mass: np.ndarray
    first: np.ndarray
    weights: np.ndarray

    def chosen(self, which: np.ndarray) -> _Weighed:
        """Some of them."""
        return _Weighed(*(each[which] for each in self))

    def moved(self, layers: int) -> _Weighed:
        """The same, in layers counted from another one."""
        return self._replace(layer=self.layer + layers)


def find_rows(rank: RankState, alpha: np.ndarray) -> MassRows:
    """Find the rows at the vertices of a rank's planes; collective.

    Parameters
    ----------
    rank : RankState
        The rank.
    alpha : (bodies,) float64
        Part of the consistent mass by body; 0 for those with lumped mass.
    """
    D, reach = rank.scene.dimension, rank.grid.vertices - 1
    p, order = rank.population.columns, rank.population.ordered
    layer = np.repeat(np.arange(rank.slab.layers), np.diff(order.start))
    mine = alpha[p.body[order.rows]] > 0.0
    rows, layer = order.rows[mine], layer[mine]
    mass = alpha[p.body[rows]] * p.m[rows]
    cells, cell = _whole_cells(rank, rows, layer, mass)
    whole = cells.reshape(-1)[cell] > 0.0
    loose = _weigh(rank, rows[~whole], layer[~whole], mass[~whole])
    uniform = _amid_whole_cells(rank, cells, reach)
    uniform[_touched(rank, loose, uniform.shape, reach)] = 0.0
    near = np.flatnonzero(whole)[_at_others(cell[whole], uniform, D)]
    edge = _weigh(rank, rows[near], layer[near], mass[near])
    particles = _Weighed(*(np.concatenate(pair) for pair in zip(loose, edge, strict=True)))
    particles = _with_neighbours(rank, particles, reach)
    places = ((np.arange(n) + 0.5) / n - 0.5 for n in rank.scene.case.method.particles_per_cell)
    scale = tuple(float(np.mean(0.25 - a * a)) for a in places)
    return MassRows(*_rows(particles, uniform, reach), scale, *_runs(uniform, D))


def _plane(rank: RankState) -> tuple[int, int, int]:
    """Velocity fields of a plane, and vertices along y and z."""
    window = rank.grid.window
    y, z = window.extent[1:]
    return window.stride[0] // (RECORD * y * z), y, z


def _whole_cells(
    rank: RankState, rows: np.ndarray, layer: np.ndarray, mass: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Find the whole cells: with a particle at each place of the lattice, of the same mass.

    Parameters
    ----------
    rank : RankState
        The rank.
    rows, layer, mass : (n,)
        Its particles with averaged mass, their layers, and alpha times their masses.

    Returns
    -------
    (layers, fields, y, z) float64
        alpha times the mass of the cell with this lowest vertex; 0 where it is not whole.
    (n,) int64
        Offset of each particle's cell therein.
    """
    scene, window, p = rank.scene, rank.grid.window, rank.population.columns
    D, frame, method = scene.dimension, scene.domain.frame, scene.case.method
    fields, y, z = _plane(rank)
    found, cell = np.zeros((rank.slab.layers, fields, y, z)), np.zeros(len(rows), np.int64)
    if D == 1 or not method.in_cell or scene.case.axisymmetric:
        return found, cell
    per_cell = np.array(method.particles_per_cell)
    xi = (p.origin[rows] - np.array(frame.origin)) * np.array(frame.inverse)
    number = np.floor(xi).astype(np.int64)
    within = (xi - number) * per_cell - 0.5
    place = np.rint(within).astype(np.int64)
    number += frame.ghost - np.array(window.lower[:D])
    fits = (np.abs(within - place) < _NEAR * per_cell).all(axis=1) & (number[:, 0] == layer)
    if len(window.bodies):
        cell += window.bodies[p.body[rows]] // (RECORD * y * z)
    cell = ((layer * fields + cell) * y + number[:, 1]) * z + (number[:, 2] if D == 3 else 0)
    slot = np.ravel_multi_index(tuple(np.clip(place, 0, per_cell - 1).T), tuple(per_cell))
    flat, n = found.reshape(-1), int(per_cell.prod())
    flat[cell] = mass
    count, slots, wrong = (
        np.bincount(cell, weights=each, minlength=len(flat))
        for each in (None, slot, (mass != flat[cell]) | ~fits)
    )
    whole = (count == n) & (slots == n * (n - 1) // 2) & (wrong == 0.0)
    flat[:] = np.where(whole, n * flat, 0.0)
    return found, cell


def _weigh(rank: RankState, rows: np.ndarray, layer: np.ndarray, mass: np.ndarray) -> _Weighed:
    """Weights of some of a rank's particles, given by layer."""
    scene, p = rank.scene, rank.population.columns
    setting = scene.setting_lagrangian if scene.settings.mixed else scene.setting
    start = np.searchsorted(layer, np.arange(rank.slab.layers + 1)).astype(np.int64)
    first, weights = np.zeros(len(rows), np.int64), np.zeros((len(rows), scene.dimension, 4))
    rank.call(
        find_weights, setting.without_materials(), rank.grid.window, p, Order(rows, start),
        first, weights,
    )  # fmt: skip
    weights = weights[:, :, : rank.grid.vertices]
    weights[weights < _LEAST] = 0.0
    return _Weighed(layer, p.id[rows].astype(np.int64), mass, first // RECORD, weights)


def _swap(rank: RankState, to_lower: Any, to_upper: Any) -> tuple[Any, Any]:
    """Tell both neighbours; return what they tell, None without one; collective."""
    comm, slab = rank.comm, rank.slab
    if slab.neighbours and slab.lower == slab.upper == comm.rank:
        return to_upper, to_lower
    sent = []
    if slab.lower is not None:
        sent.append(comm.isend(to_lower, slab.lower, _DOWN))
    if slab.upper is not None:
        sent.append(comm.isend(to_upper, slab.upper, _UP))
    from_lower = None if slab.lower is None else comm.recv(source=slab.lower, tag=_UP)
    from_upper = None if slab.upper is None else comm.recv(source=slab.upper, tag=_DOWN)
    for request in sent:
        request.wait()
    return from_lower, from_upper


def _amid_whole_cells(rank: RankState, cells: np.ndarray, reach: int) -> np.ndarray:
    """Mass of the cell below each vertex if all round it are whole and alike, else 0; collective.

    By plane, field, y, z.
    """
    below, above = _swap(rank, cells[:reach], cells[-1:])
    size = cells.shape[1:]
    below = np.zeros((1, *size)) if below is None else below
    above = np.zeros((reach, *size)) if above is None else above
    least = most = np.concatenate([below, cells, above])
    for axis in [0, *(d for d in (2, 3) if least.shape[d] > 1)]:
        upper, lower = (
            tuple(part if d == axis else slice(None) for d in range(4))
            for part in (slice(1, None), slice(None, -1))
        )
        least = np.minimum(least[lower], least[upper])
        most = np.maximum(most[lower], most[upper])
    found, alike = np.zeros((rank.grid.planes, *size)), np.where(least == most, least, 0.0)
    inner = found[:, :, size[1] - least.shape[2] :, size[2] - least.shape[3] :]
    inner[:] = alike[: len(found)]
    return found


def _touched(
    rank: RankState, loose: _Weighed, shape: tuple[int, ...], reach: int
) -> np.ndarray:
    """Whether particles that are in no whole cell have weight at vertices; collective."""
    found = np.zeros(shape, bool)
    flat, plane = found.reshape(-1), int(np.prod(shape[1:]))
    for corner in product(range(loose.weights.shape[2]), repeat=loose.weights.shape[1]):
        some = np.ones(len(loose.mass), bool)
        for d, i in enumerate(corner):
            some &= loose.weights[:, d, i] > 0.0
        offset = corner[0] * plane + _offset(corner[1:], shape[3])
        flat[(loose.layer * plane + loose.first + offset)[some]] = True
    below, above = _swap(rank, found[:reach], found[rank.slab.layers :])
    if below is not None:
        found[:reach] |= below
    if above is not None:
        found[rank.slab.layers :] |= above
    return found


def _offset(corner: tuple[int, ...], z: int) -> int:
    """Number of a vertex in its plane, counted from a support's first one."""
    y, k = (*corner, 0, 0)[:2]
    return y * z + k


def _at_others(cell: np.ndarray, uniform: np.ndarray, D: int) -> np.ndarray:
    """Whether cells, by their offset, have a corner that is not amid whole cells."""
    flat, plane = uniform.reshape(-1), int(np.prod(uniform.shape[1:]))
    found = np.zeros(len(cell), bool)
    for corner in product((0, 1), repeat=D):
        found |= flat[cell + corner[0] * plane + _offset(corner[1:], uniform.shape[3])] == 0.0
    return found


def _with_neighbours(rank: RankState, particles: _Weighed, reach: int) -> _Weighed:
    """Particles whose supports reach the rank's planes, by layer and number; collective."""
    layers = rank.slab.layers
    low, high = (particles.chosen(which) for which in (
        particles.layer < reach, particles.layer >= layers - reach
    ))  # fmt: skip
    below, above = _swap(rank, low, high.moved(-layers))
    every = [particles]
    every += [] if below is None else [below]
    every += [] if above is None else [above.moved(layers)]
    found = _Weighed(*(np.concatenate(parts) for parts in zip(*every, strict=True)))
    return found.chosen(np.lexsort((found.id, found.layer)))


def _rows(particles: _Weighed, uniform: np.ndarray, reach: int) -> tuple[np.ndarray, ...]:
    """The first five arrays of `MassRows`, of vertices that are not amid whole cells."""
    planes, _, _, z = uniform.shape
    size = uniform[0].size if planes else 0
    # Most supports are corners of a cell only.
    few = (particles.weights[:, :, 2:] == 0.0).all(axis=(1, 2))
    groups = [(2, particles.chosen(few)), (reach + 1, particles.chosen(~few))]
    wide = 2 * reach + 1
    rel = np.meshgrid(*[np.arange(wide) - reach] * particles.weights.shape[1], indexing="ij")
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
    none, no_value = [np.zeros(0, np.int64)], [np.zeros(0)]
    counts = np.concatenate(count or none)
    return (
        np.array(start, np.int64),
        np.concatenate(vertex or none).astype(np.int64),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate(column or none).astype(np.int64),
        np.concatenate(value or no_value),
    )


def _entries(
    particles: _Weighed, plane: int, vertices: int, reach: int, z: int, others: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield keys and values of a plane's rows that particles add, in the order of the sum.

    A key is the vertex's number in the plane times the number of distances, and that of its own.
    `others` are the vertices that are not amid whole cells.
    """
    D, wide = particles.weights.shape[1], 2 * reach + 1
    corners = list(product(range(vertices), repeat=D - 1))
    shift = np.array([_offset(c, z) for c in corners])
    code = [[_code(a, b, reach) for b in corners] for a in corners]
    across = np.array(code).reshape(len(corners), len(corners))
    for a in reversed(range(vertices)):
        low, high = np.searchsorted(particles.layer, [plane - a, plane - a + 1])
        mine = particles.chosen(np.arange(low, high))
        flat = np.ones((len(mine.mass), len(corners)))
        for n, corner in enumerate(corners):
            for d, i in enumerate(corner):
                flat[:, n] *= mine.weights[:, 1 + d, i]
        at = mine.first[:, None] + shift
        own = mine.weights[:, 0, a, None] * flat
        some = (own > 0.0) & others[np.where(own > 0.0, at, 0)]
        for b in range(vertices):
            # The product of weights comes first: rows are symmetric to the last bit.
            pair = own[:, :, None] * (mine.weights[:, 0, b, None] * flat)[:, None, :]
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


def _runs(uniform: np.ndarray, D: int) -> tuple[np.ndarray, ...]:
    """The last four arrays of `MassRows`."""
    planes, z = len(uniform), uniform.shape[3]
    row = z * NUMBERS if D == 3 else 0
    start, run, mass, span = [0], [np.zeros((0, 2), np.int64)], [np.zeros(0)], []
    for plane in range(planes):
        m = np.concatenate([[0.0], uniform[plane].reshape(-1), [0.0]])
        edge = np.flatnonzero(m[1:] != m[:-1])
        pairs = np.stack([edge[:-1], edge[1:]], axis=1)
        mine = m[pairs[:, 0] + 1] > 0.0
        run.append(NUMBERS * pairs[mine])
        mass.append(m[pairs[mine, 0] + 1])
        start.append(start[-1] + int(mine.sum()))
        low, high = (run[-1].min(), run[-1].max()) if mine.any() else (row + NUMBERS, -row - NUMBERS)
        span.append((low - row - NUMBERS, high + row + NUMBERS))
    return (
        np.array(start, np.int64), np.concatenate(run), np.concatenate(mass),
        np.array(span, np.int64).reshape(planes, 2),
    )  # fmt: skip
