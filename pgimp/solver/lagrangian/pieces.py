"""Particles in pieces, where their columns have no memory: each up to date while it is looked at.

So sums over the particles, and files of them, never need all columns at once. Where the columns
stand, all particles are one piece.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import prod

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.lagrangian.displace import Displaced
from pgimp.kernels.sums.energies import strain_energies
from pgimp.physics.source import Source
from pgimp.solver.rank_state import RankState
from pgimp.storage.framefile import blocks

#: Particles of several layers that are summed as one piece: their columns fit into the cache.
_FEW = 1 << 13

#: Most particles of a piece, 46 MB in 3D: larger layers are divided.
_MAX_PARTICLES = 1 << 18


def by_layers(rank: RankState, order: Order, *sums: Callable[[Particles, Order], object]) -> None:
    """Call functions that sum particles by layer, one after the other in each layer.

    A sum takes the same particles in the same order as if each function were called for all.

    Parameters
    ----------
    order : Order
        The particles, by layer.
    *sums : callable
        Each takes particles that are up to date, and their order.
    """
    if not rank.population.released:
        for add in sums:
            add(rank.up_to_date(), order)
        return
    for run in runs(order.start):
        ends = blocks(run.stop - run.start, _MAX_PARTICLES)
        parts = [(run.start + begin, run.start + end) for begin, end in ends]
        pieces = [_of_order(rank, order, *parts[0])] if len(parts) == 1 else []
        for add in sums:
            for piece in pieces or (_of_order(rank, order, *part) for part in parts):
                add(*piece)


def runs(start: np.ndarray) -> Iterator[slice]:
    """Offsets of whole layers, given their beginnings: of one, or of several with few particles."""
    first = last = 0
    for end in start[1:].tolist():
        if end - first > _FEW and last > first:
            yield slice(first, last)
            first = last
        last = end
    if last > first:
        yield slice(first, last)


def _of_order(rank: RankState, order: Order, begin: int, end: int) -> tuple[Particles, Order]:
    """A piece of an order, from one offset to another, until the next piece."""
    rows, n = order.rows[begin:end], end - begin
    start = np.clip(order.start, begin, end) - begin
    piece, stored = Order(np.arange(n, dtype=np.int32), start), rank.population.columns
    displaced = _displaced(rank, Order(rows, start), piece.rows)._asdict()
    runs = bool((rows == rows[0] + piece.rows).all())  # then no column has to be copied
    columns = (
        displaced[name] if name in displaced else array[rows[0] :][:n] if runs else array[rows]
        for name, array in stored._asdict().items()
    )
    return Particles(*columns), piece


def source_at(rank: RankState, rows: np.ndarray) -> Source:
    """Data for the fields of a rank's particles in some rows, up to date, until the next piece."""
    scene, population = rank.scene, rank.population
    particles = population.columns if population.released else population.up_to_date()
    displaced = _AtRows(rank, rows) if population.released else dict[str, np.ndarray]()
    return Source(
        particles, rows, scene.dimension, tuple(scene.materials.body_material), rank.comm.rank,
        scene.domain.ends, scene.carried.plate, partial(strain_energies, scene.setting), displaced,
        scene.materials.fills,
    )  # fmt: skip


class _AtRows(Mapping[str, np.ndarray]):
    """Columns of particles in some rows, up to date: found when the first one is asked for."""

    def __init__(self, rank: RankState, rows: np.ndarray) -> None:
        self._rank, self._rows = rank, rows
        self._found: dict[str, np.ndarray] = {}

    def __contains__(self, name: object) -> bool:
        """Whether a column is one of these."""
        return name in Displaced._fields

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column, (n, ...)."""
        if not self._found:
            population = self._rank.population
            layer = population.columns.layer[self._rows] - population.first
            to = np.argsort(layer, kind="stable").astype(np.int32)
            start = np.searchsorted(layer[to], np.arange(population.layers + 1))
            order = Order(self._rows[to].astype(np.int32), start)
            self._found = _displaced(self._rank, order, to)._asdict()
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        """Go through the names of the columns."""
        return iter(Displaced._fields)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(Displaced._fields)


def _displaced(rank: RankState, order: Order, to: np.ndarray) -> Displaced:
    """Columns of particles up to date, in rows `to` of memory that is used again."""
    n, stored, used = len(to), rank.population.columns, 0
    shapes = [getattr(stored, name).shape[1:] for name in Displaced._fields]
    scratch, columns = rank.population.scratch(n * sum(map(prod, shapes))), []
    for shape in shapes:
        columns.append(scratch[used : used + n * prod(shape)].reshape(n, *shape))
        used += columns[-1].size
    rank.displacement.place(order, displaced := Displaced(*columns), to)
    return displaced
