"""Rows of the averaged mass at a rank's vertices, found once; see `kernels.lagrangian`.

Sums go over particles by layer and number, and neighbours tell each other of those that reach the
planes of both. So rows have the same bits on any number of ranks, and in a resumed run.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.lagrangian.averaged_mass import NUMBERS, MassRows, find_weights
from pgimp.solver.lagrangian.mass_entries import Weighed, rows_of, runs_of, vertex_offset
from pgimp.solver.rank_state import RankState

#: Tags of messages to the upper and to the lower neighbour.
_UP, _DOWN = 21, 22

#: Weights below this are rounding, at vertices without mass.
_LEAST = 1e-12

#: Distance from the lattice, in cells, up to which a particle lies on it.
_NEAR = 1e-6


def find_rows(rank: RankState, alpha: np.ndarray) -> MassRows:
    """Find the rows at the vertices of a rank's planes; collective.

    Parameters
    ----------
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
    particles = Weighed(*(np.concatenate(pair) for pair in zip(loose, edge, strict=True)))
    particles = _with_neighbours(rank, particles, reach)
    places = ((np.arange(n) + 0.5) / n - 0.5 for n in rank.scene.case.method.particles_per_cell)
    scale = tuple(float(np.mean(0.25 - a * a)) for a in places)
    start, vertex, *entries = rows_of(particles, uniform, reach)
    run_start, span, run, mass = runs_of(uniform, D)
    pattern, begin, column, value = entries
    plane = NUMBERS * max(uniform[:1].size, 1)
    far = int(np.abs(np.rint(column / plane)).max(initial=1))
    return MassRows(
        start, vertex, pattern, begin, column, value, scale, run_start, span, run, mass, far
    )


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
    wide = not (method.in_cell or scene.settings.mixed)
    if D == 1 or wide or scene.case.axisymmetric:
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


def _weigh(rank: RankState, rows: np.ndarray, layer: np.ndarray, mass: np.ndarray) -> Weighed:
    """Weights of some of a rank's particles, given by layer."""
    scene, p = rank.scene, rank.population.columns
    setting = scene.setting_lagrangian if scene.settings.mixed else scene.setting
    start = np.searchsorted(layer, np.arange(rank.slab.layers + 1)).astype(np.int64)
    by_corners = scene.settings.exact_surfaces.any()
    size = (2**scene.dimension,) if by_corners else (scene.dimension, 4)
    first, weights = np.zeros(len(rows), np.int64), np.zeros((len(rows), *size))
    rank.call(
        find_weights, setting.without_materials(), rank.grid.window, p, Order(rows, start),
        first, weights,
    )  # fmt: skip
    if not by_corners:
        weights = weights[:, :, : rank.grid.vertices]
    weights[weights < _LEAST] = 0.0
    return Weighed(layer, p.id[rows].astype(np.int64), mass, first // RECORD, weights)


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


def _touched(rank: RankState, loose: Weighed, shape: tuple[int, ...], reach: int) -> np.ndarray:
    """Whether particles that are in no whole cell have weight at vertices; collective."""
    found = np.zeros(shape, bool)
    flat, plane = found.reshape(-1), int(np.prod(shape[1:]))
    D, vertices = loose.support
    for corner in product(range(vertices), repeat=D):
        offset = corner[0] * plane + vertex_offset(corner[1:], shape[3])
        flat[(loose.layer * plane + loose.first + offset)[loose.touches(corner)]] = True
    below, above = _swap(rank, found[:reach], found[rank.slab.layers :])
    if below is not None:
        found[:reach] |= below
    if above is not None:
        found[rank.slab.layers :] |= above
    return found


def _at_others(cell: np.ndarray, uniform: np.ndarray, D: int) -> np.ndarray:
    """Whether cells, by their offset, have a corner that is not amid whole cells."""
    flat, plane = uniform.reshape(-1), int(np.prod(uniform.shape[1:]))
    found = np.zeros(len(cell), bool)
    for corner in product((0, 1), repeat=D):
        found |= flat[cell + corner[0] * plane + vertex_offset(corner[1:], uniform.shape[3])] == 0.0
    return found


def _with_neighbours(rank: RankState, particles: Weighed, reach: int) -> Weighed:
    """Particles whose supports reach the rank's planes, by layer and number; collective."""
    layers = rank.slab.layers
    low, high = (particles.chosen(which) for which in (
        particles.layer < reach, particles.layer >= layers - reach
    ))  # fmt: skip
    below, above = _swap(rank, low, high.moved(-layers))
    every = [particles]
    every += [] if below is None else [below]
    every += [] if above is None else [above.moved(layers)]
    found = Weighed(*(np.concatenate(parts) for parts in zip(*every, strict=True)))
    return found.chosen(np.lexsort((found.id, found.layer)))
