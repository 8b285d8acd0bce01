"""State of an absorbing face as it begins to absorb: static forces, masses, and wave speeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from pgimp.kernels.data.record import FORCE, MASS
from pgimp.kernels.grid.absorbing import (
    NUMBERS,
    PRESSURE_WAVE,
    REACTION,
    REACTION_MASS,
    SHEAR_WAVE,
    AbsorbingFace,
)
from pgimp.kernels.once.waves import small_wave_speeds
from pgimp.scene.faces import Face
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import VertexUpdate

_SPEEDS = (PRESSURE_WAVE, SHEAR_WAVE)

#: Distance, in cells, of particles whose wave speeds a vertex takes; the second where the first
#: finds none.
_REACH = (1, 2)


def absorbing_face(
    scene: Scene, number: int, face: Face, lower: np.ndarray, extent: np.ndarray, values: np.ndarray
) -> AbsorbingFace:
    """Return the state of a face, see `AbsorbingFace`."""
    wall, layers = _wall(scene, face), scene.domain.ring_layers
    ring = scene.domain.frame.ghost + layers, layers
    return AbsorbingFace(face.axis, face.side, number, wall, lower, extent, values, ring)


def _wall(scene: Scene, face: Face | AbsorbingFace) -> int:
    """Number of the vertices on a face along its axis."""
    frame = scene.domain.frame
    return frame.ghost + (frame.cells[face.axis] if face.side > 0 else 0)


def find_face(
    rank: RankState,
    update: VertexUpdate,
    number: int,
    face: Face,
    others: tuple[list[AbsorbingFace], list[Face]],
) -> AbsorbingFace:
    """Find the state of a face: static forces, masses and wave speeds of its vertices; collective.

    A vertex is of one rank, and particles are in canonical order: bits do not depend on the ranks.
    At edges `others` have their part of the force: what those found before bear already, and the
    component across those that are found after it.
    """
    parts = rank.comm.allgather(_own(rank, update, face))
    numbers, forces, masses = (np.concatenate(each) for each in zip(*parts, strict=True))
    length = float(rank.scene.domain.frame.cell[face.axis])
    near = _near_particles(rank, face, lambda rows: _wave_speeds(rank, rows, length))
    elsewhere = np.zeros(NUMBERS)
    elsewhere[list(_SPEEDS)] = _mean_speeds(rank, near)
    if not len(numbers):
        none = np.zeros(3, np.int64)
        return absorbing_face(rank.scene, number, face, none, none, elsewhere[None])
    for other in others[0]:
        forces -= _static_forces(other, numbers)
    for later in others[1]:
        forces[numbers[:, later.axis] == _wall(rank.scene, later), later.axis] = 0.0
    lower, upper = numbers.min(axis=0), numbers.max(axis=0) + 1
    values = np.zeros((*(upper - lower), NUMBERS))
    values[...] = elsewhere
    at = tuple((numbers - lower).T)
    values[(*at, slice(REACTION, REACTION + 3))] = forces
    values[(*at, REACTION_MASS)] = masses
    speeds = _means_at(rank, face, near, lower, upper)
    known = np.isfinite(speeds[..., 0])
    for column, c in zip(_SPEEDS, np.moveaxis(speeds, -1, 0), strict=True):
        values[..., column] = np.where(known, c, values[..., column])
    rows = np.concatenate([values.reshape(-1, NUMBERS), elsewhere[None]])
    return absorbing_face(rank.scene, number, face, lower, upper - lower, rows)


def _static_forces(face: AbsorbingFace, numbers: np.ndarray) -> np.ndarray:
    """Static forces of a face on vertices that have mass, given by their numbers, (n, 3)."""
    at = numbers - face.lower
    inside = ((at >= 0) & (at < face.extent)).all(axis=1)
    found = np.zeros((len(numbers), 3))
    if inside.any():
        rows = face.values[np.ravel_multi_index(tuple(at[inside].T), tuple(face.extent))]
        found[inside] = rows[:, REACTION : REACTION + 3]
    return found


def without(rank: RankState, face: AbsorbingFace, bodies: Sequence[int]) -> AbsorbingFace:
    """Return a face as some bodies go: of forces and masses the part that stays; collective.

    It is that of the mass of the particles within a cell of the vertex.
    """
    places, masses, body = _near_particles(rank, face, lambda rows: rank.up_to_date().body[rows])
    stays = ~np.isin(body, bodies)[:, None]
    near = places, masses, stays.astype(float)
    upper = face.lower + face.extent
    part = _means_at(rank, face, near, face.lower, upper).reshape(-1)
    values = face.values.copy()
    values[:-1, REACTION : REACTION_MASS + 1] *= np.where(np.isfinite(part), part, 1.0)[:, None]
    return face._replace(values=values)


def _own(
    rank: RankState, update: VertexUpdate, face: Face
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers, static forces and masses of the face's vertices that the rank owns.

    The static force is minus that of stresses, loads and gravity, over all fields.
    """
    grid, gravity = rank.grid, np.array(update.forcing.gravity)
    lower, wall = np.array(grid.window.lower), _wall(rank.scene, face)
    extent = [grid.owned, *grid.window.extent[1:]]
    part = [slice(0, n) for n in extent]
    at = wall - int(lower[face.axis])
    low, high = (0, at + 1) if face.side < 0 else (at, extent[face.axis])
    low, high = max(low, 0), min(high, extent[face.axis])
    if not grid.planes or high <= low:
        return np.zeros((0, 3), np.int64), np.zeros((0, 3)), np.zeros(0)
    part[face.axis] = slice(low, high)
    records = grid.by_vertex(grid.G)[part[0], :, part[1], part[2]]
    there = records[..., MASS] > update.forcing.mass_cutoff
    there &= (grid.active[part[0]] != 0)[:, None, None, None]
    m = np.where(there, records[..., MASS], 0.0)
    f = np.where(there[..., None], records[..., FORCE : FORCE + 3], 0.0)
    mass, force = m.sum(axis=1), (f + m[..., None] * gravity).sum(axis=1)
    found = np.nonzero(mass > 0.0)
    first = np.array([part[0].start, part[1].start, part[2].start])
    return np.transpose(found) + (first + lower), -force[found], mass[found]


def _near_particles(
    rank: RankState, face: Face | AbsorbingFace, what: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places in cells, masses and `what` of the particles near a face, of all ranks.

    Collective; in canonical order.
    """
    scene, particles, D = rank.scene, rank.up_to_date(), rank.scene.dimension
    frame, rows = scene.domain.frame, rank.population.order.astype(np.int64)
    x = (scene.weighed(particles, rows) - frame.origin) * frame.inverse + frame.ghost
    near = np.abs(x[:, face.axis] - _wall(scene, face)) < _REACH[-1]
    rows = rows[near]
    parts = rank.comm.allgather((x[near].reshape(-1, D), particles.m[rows], what(rows)))
    places, masses, found = (np.concatenate(each) for each in zip(*parts, strict=True))
    return places, masses, found


def _wave_speeds(rank: RankState, rows: np.ndarray, length: float) -> np.ndarray:
    """Wave speeds of particles, of compression and shear, (n, 2)."""
    found, setting = np.zeros((len(rows), 2)), rank.scene.setting.without_shape()
    rank.call(small_wave_speeds, setting, rank.up_to_date(), rows, length, found)
    return found


def _mean_speeds(rank: RankState, near: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Mean wave speeds by mass, of the particles near a face; collective without any.

    Without any the greatest of all particles.
    """
    _, masses, speeds = near
    if len(masses):
        return np.asarray((masses[:, None] * speeds).sum(axis=0) / masses.sum())
    rows = rank.population.order.astype(np.int64)
    every = _wave_speeds(rank, rows, min(rank.scene.domain.frame.cell))
    return np.max(rank.comm.allgather(every.max(axis=0, initial=0.0)), axis=0)


def _means_at(
    rank: RankState,
    face: Face | AbsorbingFace,
    near: tuple[np.ndarray, np.ndarray, np.ndarray],
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Means by mass of values at the vertices of a box, (x, y, z, n); nan without particles near.

    `near` are places, masses and values, (particles, n). Vertices beyond the face have those of
    the face.
    """
    (places, masses, values), D = near, rank.scene.dimension
    low, high = lower.copy(), upper.copy()
    low[face.axis], high[face.axis] = _wall(rank.scene, face), _wall(rank.scene, face) + 1
    number = values.shape[1]
    found = np.full((*(high - low), number), np.nan)
    for reach in reversed(_REACH):
        sums = np.zeros((*(high - low), number + 1))
        first = np.floor(places).astype(np.int64)
        for corner in product(range(1 - reach, 1 + reach), repeat=D):
            vertex = np.zeros((len(places), 3), np.int64)
            vertex[:, :D] = first + corner
            weight = masses * np.maximum(1.0 - np.abs(places - vertex[:, :D]) / reach, 0.0).prod(
                axis=1
            )
            inside = ((vertex >= low) & (vertex < high)).all(axis=1) & (weight > 0.0)
            at = tuple((vertex[inside] - low).T)
            add = weight[inside, None] * np.column_stack([values, np.ones(len(places))])[inside]
            np.add.at(sums, at, add)
        has = sums[..., number] > 0.0
        found[has] = sums[has][:, :number] / sums[has][:, number:]
    return np.broadcast_to(found, (*(upper - lower), number))
