"""Cells of a rank's lattice particles, for the sums that need no data of particles."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.lagrangian.cell_derivatives import MAX_PER_CELL
from pgimp.kernels.lagrangian.cells import Cells
from pgimp.kernels.lagrangian.keep import beyond_bounds
from pgimp.kernels.lagrangian.part_cells import PartCells
from pgimp.kernels.step.checks import INVERTED, NOT_FINITE, OUT_OF_RANGE, OUTSIDE
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.lagrangian.part_cells import (
    CutCells,
    decoded,
    find_parts,
    has_parts,
    join_parts,
    no_parts,
)
from pgimp.solver.lagrangian.pieces import runs
from pgimp.solver.rank_state import RankState

#: Distance from the lattice, in cells, up to which a particle lies on it.
_NEAR = 1e-6

#: Particles at fault that are listed.
_LISTED = 1024


class LatticeCells(NamedTuple):
    """A rank's cells of lattice particles, and its other particles."""

    cells: Cells
    #: (slots,) int32: Row of the particle in each slot, or -1; those of parts are the last ones.
    rows: np.ndarray
    off_lattice: Order  #: The particles that are in no cell: off the lattice, or with a traction.
    inside: Order  #: Those in cells.
    is_inside: np.ndarray  #: (capacity,) bool: Whether the particle in a row is in a cell.


def no_cells(scene: Scene, layers: int) -> Cells:
    """Cells of so many layers without particles, for the sums of all particles one by one."""
    none = np.zeros(0, np.int64)
    start = np.zeros(layers + 1, np.int64)
    return _cells(scene, start, none, none, 0, no_parts(scene, start))


def cleared(cells: Cells) -> Cells:
    """The cells, without the report of the step before."""
    cells.wrong[0], cells.rate[0] = 0, 0.0
    return cells


def find_cells(rank: RankState) -> LatticeCells:
    """Find the cells of a rank's particles on the lattice, some layers after the other."""
    scene, population = rank.scene, rank.population
    p, order = population.columns, population.ordered
    if not scene.by_cells:
        none, every = Order(order.rows[:0], np.zeros_like(order.start)), order
        outside = np.zeros(p.capacity, bool)
        return LatticeCells(no_cells(scene, rank.slab.layers), none.rows, every, none, outside)
    fits = np.zeros(len(order.rows), bool)
    # At the end none, for a rank without particles.
    parts = [_find(rank, run, fits[run]) for run in (*runs(order.start), slice(0))]
    layer, place, bodies = np.concatenate([found for found, _, _, _ in parts], axis=1)
    start = np.searchsorted(layer, np.arange(rank.slab.layers + 1))
    rows = np.concatenate([part for _, part, _, _ in parts])
    cut, of_cut = join_parts(rank, [each for *_, cut in parts for each in cut])
    cells = _cells(scene, start, place, scene.setting.material_of[bodies], len(rows), cut)
    np.concatenate([part for _, _, part, _ in parts], out=cells.volumes)
    if scene.cell_loads:
        cells.rows[:] = repeated(rows)
    off_lattice, inside = (
        Order(order.rows[mask], np.concatenate([[0], np.cumsum(mask)])[order.start])
        for mask in (~fits, fits)
    )
    is_inside = np.zeros(p.capacity, bool)
    is_inside[inside.rows] = True
    if len(of_cut):
        rows = np.concatenate([rows, of_cut])
    return LatticeCells(cells, rows, off_lattice, inside, is_inside)


def _find(
    rank: RankState, run: slice, fits: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[CutCells]]:
    """Cells of the particles of whole layers.

    Parameters
    ----------
    run : slice
        Their offsets in the order.
    fits : (n,) bool
        Set: whether they are in a cell.

    Returns
    -------
    (3, cells) int64
        Layer in the rank, offset in the plane, and body of each cell, ascending.
    (slots,) int32
        Row of the particle in each slot, or -1.
    (slots,) float64
        Initial volumes by slot.
    list of CutCells
        Cells with parts of particles, at most one entry.
    """
    scene, population, window = rank.scene, rank.population, rank.grid.window
    p, D, rows = population.columns, scene.dimension, population.order[run]
    frame, per_cell = scene.domain.frame, np.array(scene.case.method.particles_per_cell)
    xi = (p.origin[rows] - np.array(frame.origin)) * np.array(frame.inverse)
    number = np.floor(xi).astype(np.int64)
    xi -= number
    within = xi * per_cell - 0.5
    place = np.rint(within).astype(np.int64)
    number += frame.ghost
    near = (np.abs(within - place) < _NEAR * per_cell).all(axis=1)
    near &= ((0 <= place) & (place < per_cell)).all(axis=1)
    near &= ~p.products[rows].any(axis=1)  # parts have weights of their own
    fits[:] = number[:, 0] == p.layer[rows]
    fits &= ~p.patch[rows].any(axis=1)  # tractions are forces on particles
    fits &= ~p.surface[rows].any(axis=1)
    if rank.mean_dilatation:
        near &= _in_whole_cells(rank, rows, fits & near)
    key = number[:, 0] - window.lower[0]
    for d in range(1, D):
        key = key * window.extent[d] + (number[:, d] - window.lower[d])
    key = key * len(scene.body_names) + p.body[rows]
    slices = per_cell[0] if D == 3 else 1
    size = 4 * -(-int(per_cell[-2:].prod()) // 4)
    parts = []
    if has_parts(scene):
        cut = fits & np.isin(key, key[fits & ~near])
        parts = [find_parts(rank, rows, np.flatnonzero(cut), key, xi, size * slices)]
        near &= ~cut
    fits &= near
    mine = np.flatnonzero(fits)
    for each in parts:
        fits[each.members] = True
    found, cell = np.unique(key[mine], return_inverse=True)
    slot = place[mine, -2] * per_cell[-1] + place[mine, -1]
    if D == 3:
        slot += place[mine, 0] * size
    slot += cell.reshape(-1) * (size * slices)
    taken = np.full(len(found) * size * slices, -1, np.int32)
    volumes = np.zeros(len(taken))
    taken[slot], volumes[slot] = rows[mine], p.V0[rows[mine]]
    return decoded(rank, found), taken, volumes, parts


def _in_whole_cells(rank: RankState, rows: np.ndarray, fits: np.ndarray) -> np.ndarray:
    """Whether all particles of a particle's cell are whole and fit, and share no dilatation."""
    scene, population = rank.scene, rank.population
    bodies, V0 = len(scene.body_names), population.columns.V0[rows]
    most = int(np.prod(scene.case.method.particles_per_cell))
    full = np.prod(scene.domain.frame.cell) / most
    keys = Vertices.cells_under(rank, rows)
    cells = keys * bodies + population.columns.body[rows]
    _, of = np.unique(cells, return_inverse=True)
    count = np.bincount(of, fits & (np.abs(V0 - full) < 1e-9 * full))
    return (count[of] == most) & ~rank.mean_dilatation.shares(keys)


def mark_corners(rank: RankState) -> np.ndarray:
    """Whether vertices are corners of a rank's cells, (planes, fields, y, z) bool."""
    cells, window, D = rank.lattice_cells().cells, rank.grid.window, rank.scene.dimension
    values = np.zeros_like(rank.grid.kept.values)
    for each in (cells, cells.parts) if cells.parts else (cells,):
        layer = np.repeat(np.arange(len(each.start) - 1), np.diff(each.start))
        first = layer * window.stride[0] + each.place
        for corner in product((0, 1), repeat=D):
            values[first + np.dot(corner, window.stride[:D])] = 1.0
    return rank.grid.by_vertex(values)[..., 0] > 0.0


def repeated(rows: np.ndarray) -> np.ndarray:
    """Rows of slots with the first one of four in place of missing ones; -1 if all are missing."""
    four = rows.reshape(-1, 4)
    first = np.argmax(four >= 0, axis=1)[:, None]
    return np.where(four >= 0, four, np.take_along_axis(four, first, axis=1)).reshape(-1)


def find_beyond(rank: RankState) -> bool:
    """Whether a vertex has moved past a wall that holds bodies."""
    bounds = np.array(rank.scene.domain.bounds)
    if not np.isfinite(bounds).any():
        return False
    return bool(rank.call(beyond_bounds, rank.scene.domain.frame, rank.grid.field, bounds))


def report_cells(rank: RankState, errors: np.ndarray, wrong: int, rate: float) -> tuple[int, float]:
    """Add the particles at fault in cells to those listed, and find the greatest rate.

    Elastic particles in cells are looked at as the step begins, others and what walls hold as it
    ends.

    Parameters
    ----------
    errors : (capacity, 2) int64
        Rows and errors of the particles at fault.
    wrong, rate : int, float
        Their number, and the greatest rate so far.
    """
    lattice, scene, population = rank.lattice_cells(), rank.scene, rank.population
    count = int(lattice.cells.wrong[0])
    rows = lattice.rows[lattice.cells.wrong[1 : 1 + min(count, _LISTED)]]
    kind: int | np.ndarray = INVERTED
    if scene.cell_loads and count:
        kind = _faults(population.columns.F[rows].reshape(-1, scene.dimension, scene.dimension))
    if find_beyond(rank):
        bounds = np.array(scene.domain.bounds)
        x = population.up_to_date().x[lattice.inside.rows]
        gone = ~((bounds[:, 0] <= x) & (x <= bounds[:, 1])).all(axis=1)
        if gone.any() and not count:
            rows, kind, count = lattice.inside.rows[gone], OUTSIDE, int(gone.sum())
    if count:
        rows = rows[: len(errors) - min(wrong, len(errors))]
        kind = kind[: len(rows)] if isinstance(kind, np.ndarray) else kind
        errors[wrong : wrong + len(rows), 0] = rows
        errors[wrong : wrong + len(rows), 1] = np.broadcast_to(kind, len(rows))
    return wrong + count, max(rate, float(lattice.cells.rate[0]))


def _faults(F: np.ndarray) -> np.ndarray:
    """Errors of particles at fault with deformation gradients F."""
    J = np.linalg.det(F)
    valid = np.where(J > 0.0, OUT_OF_RANGE, INVERTED)
    return np.where(np.isfinite(J), valid, NOT_FINITE)


def _cells(
    scene: Scene, start: np.ndarray, place: np.ndarray, material: np.ndarray, slots: int,
    parts: PartCells | tuple[()],
) -> Cells:  # fmt: skip
    """Cells with the places of the lattice; their volumes are zero."""
    per_cell, D = scene.case.method.particles_per_cell, scene.dimension
    fractions = np.zeros((D, MAX_PER_CELL))
    for d, count in enumerate(per_cell):
        fractions[d, :count] = ((np.arange(count) + 0.5) / count)[:MAX_PER_CELL]
    distances = fractions / np.array(scene.domain.frame.inverse)[:, None]
    rows = np.full(slots if scene.cell_loads else 0, -1, np.int64)
    return Cells(
        scene.setting, scene.cell_loads, start.astype(np.int64), np.ascontiguousarray(place),
        material, aligned(slots), rows, fractions.reshape(-1), distances.reshape(-1),
        tuple((0.0,) * count for count in per_cell), parts, bool(scene.settings.controlled),
        np.zeros(1), np.zeros(_LISTED + 1, np.int64),
    )  # fmt: skip
