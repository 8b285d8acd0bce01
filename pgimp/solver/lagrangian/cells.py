"""Cells of a rank's lattice particles, for the sums that need no data of particles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.lagrangian.cells import MOST, Cells
from pgimp.kernels.lagrangian.keep import beyond_bounds
from pgimp.kernels.update.checks import INVERTED, OUTSIDE
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState

#: Distance from the lattice, in cells, up to which a particle lies on it.
_NEAR = 1e-6

#: Particles at fault that are listed.
_LISTED = 1024


class LatticeCells(NamedTuple):
    """A rank's cells of lattice particles, and its other particles.

    Attributes
    ----------
    cells : Cells
        The cells.
    rows : (slots,) int64
        Row of the particle in each slot, or -1.
    others, inside : Order
        The particles that are in no cell, and the others.
    is_inside : (capacity,) bool
        Whether the particle in a row is in a cell.
    """

    cells: Cells
    rows: np.ndarray
    others: Order
    inside: Order
    is_inside: np.ndarray


def no_cells(scene: Scene, layers: int) -> Cells:
    """Cells of so many layers without particles, for the sums of all particles one by one."""
    none = np.zeros(0, np.int64)
    return _cells(scene, np.zeros(layers + 1, np.int64), none, none, 0)


def cleared(cells: Cells) -> Cells:
    """The cells, without the report of the step before."""
    cells.wrong[0], cells.rate[0] = 0, 0.0
    return cells


def find_cells(rank: RankState) -> LatticeCells:
    """Find the cells of a rank's particles on the lattice."""
    scene, population, window = rank.scene, rank.population, rank.grid.window
    p, order, D = population.stored, population.ordered, scene.dimension
    rows = order.rows.astype(np.int64)
    per_cell = np.array(scene.case.method.particles_per_cell)
    xi = (p.origin[rows] - np.array(scene.domain.frame.origin)) * np.array(
        scene.domain.frame.inverse
    )
    number = np.floor(xi).astype(np.int64)
    within = (xi - number) * per_cell - 0.5
    place = np.rint(within).astype(np.int64)
    number += scene.domain.frame.ghost
    fits = (np.abs(within - place) < _NEAR * per_cell).all(axis=1)
    fits &= (number[:, 0] == p.layer[rows]) & ((0 <= place) & (place < per_cell)).all(axis=1)
    mine = np.flatnonzero(fits)
    offset = np.zeros(len(mine), np.int64)
    for d in range(1, D):
        offset += (number[mine, d] - window.lower[d]) * window.stride[d]
    bodies = p.body[rows[mine]]
    if len(window.bodies):
        offset += window.bodies[bodies]
    layer = number[mine, 0] - window.lower[0]
    keys = np.stack([layer, offset, bodies])
    found, cell = np.unique(keys, axis=1, return_inverse=True)
    start = np.searchsorted(found[0], np.arange(rank.slab.layers + 1))
    slices = per_cell[0] if D == 3 else 1
    size = 4 * -(-int(per_cell[-2:].prod()) // 4)
    slot = place[mine, -2] * per_cell[-1] + place[mine, -1]
    if D == 3:
        slot += place[mine, 0] * size
    slot += cell.reshape(-1) * (size * slices)
    material = scene.setting.material_of[found[2]]
    cells = _cells(scene, start, found[1], material, len(found[1]) * size * slices)
    taken = np.full(len(cells.volumes), -1, np.int64)
    taken[slot] = rows[mine]
    cells.volumes[slot] = p.V0[rows[mine]]
    is_inside = np.zeros(p.capacity, bool)
    is_inside[rows[mine]] = True
    others, inside = (
        Order(order.rows[mask], np.concatenate([[0], np.cumsum(mask)])[order.start])
        for mask in (~fits, fits)
    )
    return LatticeCells(cells, taken, others, inside, is_inside)


def find_beyond(rank: RankState) -> bool:
    """Whether a vertex has moved past a wall that holds bodies."""
    bounds = np.array(rank.scene.domain.bounds)
    if not np.isfinite(bounds).any():
        return False
    return bool(rank.call(beyond_bounds, rank.scene.domain.frame, rank.grid.field, bounds))


def report_cells(rank: RankState, errors: np.ndarray, wrong: int, rate: float) -> tuple[int, float]:
    """Add the particles at fault in cells to those listed, and find the greatest rate.

    Particles in cells are looked at as the step begins, and by the walls that hold them as it ends.

    Parameters
    ----------
    rank : RankState
        The rank.
    errors : (capacity, 2) int64
        Rows and errors of the particles at fault.
    wrong, rate : int, float
        Their number, and the greatest rate so far.
    """
    lattice, scene = rank.lattice, rank.scene
    count = int(lattice.cells.wrong[0])
    rows = lattice.rows[lattice.cells.wrong[1 : 1 + min(count, _LISTED)]]
    kind = INVERTED
    if find_beyond(rank):
        bounds = np.array(scene.domain.bounds)
        x = rank.population.particles.x[lattice.inside.rows]
        gone = ~((bounds[:, 0] <= x) & (x <= bounds[:, 1])).all(axis=1)
        if gone.any() and not count:
            rows, kind, count = lattice.inside.rows[gone], OUTSIDE, int(gone.sum())
    if count:
        rows = rows[: len(errors) - min(wrong, len(errors))]
        errors[wrong : wrong + len(rows), 0] = rows
        errors[wrong : wrong + len(rows), 1] = kind
    return wrong + count, max(rate, float(lattice.cells.rate[0]))


def _cells(
    scene: Scene, start: np.ndarray, place: np.ndarray, material: np.ndarray, slots: int
) -> Cells:
    """Cells with the weights of the lattice; their volumes are zero."""
    per_cell, D = scene.case.method.particles_per_cell, scene.dimension
    weights, gradients = np.zeros((2, D, MOST, 2))
    for d, count in enumerate(per_cell):
        at = (np.arange(count) + 0.5) / count
        weights[d, :count] = np.stack([1.0 - at, at], axis=1)
        gradients[d, :count] = np.array([-1.0, 1.0]) * scene.domain.frame.inverse[d]
    return Cells(
        scene.setting, start.astype(np.int64), np.ascontiguousarray(place), material,
        aligned(slots), weights.reshape(-1), gradients.reshape(-1),
        tuple((0.0,) * count for count in per_cell), bool(scene.settings.controlled), np.zeros(1),
        np.zeros(_LISTED + 1, np.int64),
    )  # fmt: skip
