"""Cells with parts of particles, of bodies that are exact to their surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.decomposition.grid import aligned
from pgimp.kernels.lagrangian.part_cells import PartCells
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState


class CutCells(NamedTuple):
    """Cells with parts of particles, of some layers."""

    members: np.ndarray  #: (n,) int64: Offsets of their particles among those looked at.
    #: (3, cells) int64: Layer in the rank, offset in the plane, and body of each cell, ascending.
    cells: np.ndarray
    groups: np.ndarray  #: (cells,) int64: Groups of four particles of each.
    rows: np.ndarray  #: (4 groups,) int32: Rows of the particles, or -1.
    volumes: np.ndarray  #: (4 groups,) float64: Initial volumes, 0 without a particle.
    places: np.ndarray  #: (groups, numbers, 4) float64: See `PartCells`.


def has_parts(scene: Scene) -> bool:
    """Whether the cells of a scene have parts of particles: of elastic materials only."""
    return bool(scene.stateless and scene.settings.exact_surfaces.any())


def decoded(rank: RankState, keys: np.ndarray) -> np.ndarray:
    """Layer in the rank, offset in the plane, and body of cells by their keys, (3, cells) int64."""
    window, D = rank.grid.window, rank.scene.dimension
    keys, bodies = np.divmod(keys, len(rank.scene.body_names))
    offset = np.zeros(len(keys), np.int64)
    for d in reversed(range(1, D)):
        keys, number = np.divmod(keys, window.extent[d])
        offset += number * window.stride[d]
    if len(window.bodies):
        offset += window.bodies[bodies]
    return np.stack([keys, offset, bodies])


def find_parts(
    rank: RankState, rows: np.ndarray, which: np.ndarray, key: np.ndarray, place: np.ndarray,
    most: int,
) -> CutCells:  # fmt: skip
    """Find the cells with parts of particles.

    Parameters
    ----------
    rows : (n,) int32
        Particles of whole layers, in canonical order.
    which : (m,) int64
        Offsets of those in such cells, ascending.
    key : (n,) int64
        Numbers of their cells.
    place : (n, D) float64
        Their places in these, from 0 to 1.
    most : int
        Most particles of a cell; one with more has none.
    """
    p, inverse = rank.population.columns, rank.scene.domain.frame.inverse
    _, cell, count = np.unique(key[which], return_inverse=True, return_counts=True)
    which = which[count[cell.reshape(-1)] <= most]
    found, cell, count = np.unique(key[which], return_inverse=True, return_counts=True)
    by_cell = np.argsort(cell.reshape(-1), kind="stable")
    which, cell = which[by_cell], cell.reshape(-1)[by_cell]
    groups = -(-count // 4)
    first = np.cumsum(groups) - groups
    slot = 4 * first[cell] + np.arange(len(which)) - (np.cumsum(count) - count)[cell]
    mine = rows[which]
    taken, volumes = np.full(4 * int(groups.sum()), -1, np.int32), np.zeros(4 * int(groups.sum()))
    taken[slot], volumes[slot] = mine, p.V0[mine]
    t, D = place[which].T, place.shape[1]
    numbers = [*t]
    if D == 3:
        for n, (i, j) in enumerate(((1, 2), (0, 2), (0, 1))):
            numbers.append(t[i] * t[j] + p.products[mine, n] * (inverse[i] * inverse[j]))
    places = np.zeros((int(groups.sum()), len(numbers), 4))
    for n, values in enumerate(numbers):
        places[slot // 4, n, slot % 4] = values
    return CutCells(which, decoded(rank, found), groups, taken, volumes, places)


def join_parts(
    rank: RankState, found: Sequence[CutCells]
) -> tuple[PartCells | tuple[()], np.ndarray]:
    """Cells with parts of all layers for kernels, () in scenes without; rows of the particles."""
    scene = rank.scene
    if not found:
        return (), np.zeros(0, np.int32)
    rows = np.concatenate([each.rows for each in found])
    layer, place, bodies = np.concatenate([each.cells for each in found], axis=1)
    first = np.concatenate([[0], *(each.groups for each in found)]).cumsum()
    start = np.searchsorted(layer, np.arange(rank.slab.layers + 1))
    parts = _parts(scene, start, place, scene.setting.material_of[bodies], first)
    parts.volumes[:] = np.concatenate([each.volumes for each in found])
    parts.places[:] = np.concatenate([each.places.reshape(-1) for each in found])
    return parts, rows


def no_parts(scene: Scene, start: np.ndarray) -> PartCells | tuple[()]:
    """No cells, in layers that begin and end there; () in scenes without parts of particles."""
    none = np.zeros(0, np.int64)
    return _parts(scene, start, none, none, np.zeros(1, np.int64)) if has_parts(scene) else ()


def _parts(
    scene: Scene, start: np.ndarray, place: np.ndarray, material: np.ndarray, first: np.ndarray
) -> PartCells:
    """Cells with as many groups; their volumes are zero."""
    slots = 4 * int(first[-1])
    numbers = 6 if scene.dimension == 3 else 2
    return PartCells(
        start.astype(np.int64), np.ascontiguousarray(place), material, first.astype(np.int64),
        aligned(slots), aligned(slots * numbers),
    )  # fmt: skip
