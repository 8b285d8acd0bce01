"""The cell whose vertices move a slave, see `pgimp.solver.lagrangian.slaves`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from pgimp.geometry.rows import each_once
from pgimp.solver.rank_state import RankState

#: Vertices from a slave to its masters, at most, along each direction.
REACH = 2

#: Greater than all other differences of cells: a cell off the face that a slave is on.
_OFF_FACE = 1e6

#: What decides between cells that are as good; above rounding.
_TIE = 1e-7

#: Slaves that are looked at together.
_BLOCK = 4096


class Vertices(NamedTuple):
    """What a rank's vertices hold of the cells around them."""

    rank: RankState  #: Rank.
    #: (planes, fields, y, z) int64: Numbers of the vertices and fields in the whole grid.
    keys: np.ndarray
    #: (planes, fields, y, z) float64: Volumes of particles times weights, over that of a cell.
    held: np.ndarray
    exact: np.ndarray  #: (planes, fields, y, z) bool: Where a body is that is exact to its surface.
    #: sequence of (int, int, bool): Axis and number of the planes of vertices with a condition, and
    #: whether this holds all components.
    faces: Sequence[tuple[int, int, bool]]

    @staticmethod
    def sizes(rank: RankState) -> tuple[int, int, int]:
        """Vertices of the whole grid along y and z, and fields."""
        ny, nz = (*rank.grid.frame.vertices, 1, 1)[1:3]
        return ny, nz, 1 + max(rank.grid.fields, default=0)

    @staticmethod
    def numbers(rank: RankState, keys: np.ndarray) -> tuple[np.ndarray, ...]:
        """Numbers of vertices along x, y, z, and fields."""
        ny, nz, fields = Vertices.sizes(rank)
        rest, field = np.divmod(keys, fields)
        rest, z = np.divmod(rest, nz)
        x, y = np.divmod(rest, ny)
        return x, y, z, field

    @staticmethod
    def joined(rank: RankState, place: Sequence[np.ndarray], field: np.ndarray) -> np.ndarray:
        """Keys of vertices by their numbers along x, y, z, and fields; -1 beyond the grid.

        Vertices beyond a seam are those inside that they stand for.
        """
        frame, periodic = rank.grid.frame, (*rank.scene.domain.periodic, False, False)
        found, inside = np.zeros(1, np.int64), np.ones(1, bool)
        sizes, most = Vertices.sizes(rank), (*frame.vertices, 1, 1)
        for d, size in enumerate((1, *sizes[:2])):
            at = place[d]
            if periodic[d]:
                at = frame.ghost + (at - frame.ghost) % frame.cells[d]
            inside = inside & (at >= 0) & (at < most[d])
            found = found * size + at
        return np.where(inside, found * sizes[2] + field, -1)

    @staticmethod
    def key(rank: RankState, number: np.ndarray, bodies: np.ndarray) -> np.ndarray:
        """Keys of vertices in the fields of bodies, given the vertices' numbers, (n, D)."""
        field = np.array(rank.grid.fields or [0] * (int(bodies.max(initial=0)) + 1))[bodies]
        none = np.zeros(len(number), np.int64)
        return Vertices.joined(rank, (*number.T, none, none), field)

    @staticmethod
    def cells_under(rank: RankState, rows: np.ndarray) -> np.ndarray:
        """Keys of the first vertices of the cells in which particles were at the start."""
        frame, p = rank.grid.frame, rank.population.columns
        x = (p.origin[rows] - np.array(frame.origin)) * np.array(frame.inverse)
        number = np.floor(x).astype(np.int64) + frame.ghost
        number[:, 0] = p.layer[rows]
        return Vertices.key(rank, number, p.body[rows])

    @staticmethod
    def cells_round(rank: RankState, keys: np.ndarray) -> np.ndarray:
        """Keys of the first vertices of the cells round each vertex, (2^D, n); -1 for none."""
        *place, field = Vertices.numbers(rank, keys)
        corners = [(*each, 0, 0) for each in product((0, 1), repeat=len(rank.grid.frame.cell))]
        found = [
            Vertices.joined(rank, [place[d] - corner[d] for d in range(3)], field)
            for corner in corners
        ]
        return np.stack(found)

    @staticmethod
    def cells_of(rank: RankState, keys: np.ndarray) -> np.ndarray:
        """Keys of the first vertices of the cells round some vertices."""
        return each_once(Vertices.cells_round(rank, keys).reshape(-1))

    def field_of(self, keys: np.ndarray) -> np.ndarray:
        """Fields of vertices, by their keys."""
        return self.numbers(self.rank, keys)[3]

    def at_rest(self, keys: np.ndarray) -> np.ndarray:
        """Whether vertices are on a face that holds all components, (n,) bool."""
        place, found = self.numbers(self.rank, keys), np.zeros(len(keys), bool)
        for axis, number, holds in self.faces:
            if holds:
                found |= place[axis] == number
        return found

    def around(self, keys: np.ndarray) -> np.ndarray:
        """Keys of all vertices of the grid within `REACH`, ascending."""
        found = [np.zeros(0, np.int64)]
        for begin in range(0, len(keys), _BLOCK):
            near = self.shifted(keys[begin : begin + _BLOCK])
            found.append(each_once(near[near >= 0]))
        return each_once(np.concatenate(found))

    def shifted(self, keys: np.ndarray) -> np.ndarray:
        """Keys of the vertices within `REACH` of each, -1 beyond the grid, (n, (2 REACH + 1)^D)."""
        D = len(self.rank.grid.frame.cell)
        *place, field = (each[:, None] for each in self.numbers(self.rank, keys))
        steps = np.array([*product(range(-REACH, REACH + 1), repeat=D)])
        moved = [at + (steps[None, :, d] if d < D else 0) for d, at in enumerate(place)]
        return self.joined(self.rank, moved, field)

    def find(self, keys: np.ndarray, owned: int) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
        """Places (plane, field, y, z) of vertices that the rank owns, and which these are."""
        window, ring = self.rank.grid.window, self.rank.scene.domain.ring_layers
        x, y, z, field = self.numbers(self.rank, keys)
        i, j, k = (each - low for each, low in zip((x, y, z), window.lower, strict=True))
        i = i % ring if ring else i
        there = (i >= 0) & (i < owned) & (j >= 0) & (j < window.extent[1])
        there &= (k >= 0) & (k < window.extent[2])
        return (i[there], field[there], j[there], k[there]), np.flatnonzero(there)


def choose_masters(
    vertices: Vertices, keys: np.ndarray, known: np.ndarray, held: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """Choose the cell of each slave: the least sum of weights' sizes, then along the inward normal.

    A slave on a face with a condition has masters there, so that the face holds it as them. Only a
    body that ends within the cell beside a face, and hardly reaches into it, has none there.

    Parameters
    ----------
    keys : (n,) int64
        The slaves.
    known, held : (k,) int64, (k,) float64
        Vertices around them, ascending, and what these hold of a cell.
    least : float
        What a vertex has to hold.

    Returns
    -------
    masters : (n, 2^D) int64
        Numbers among `known` of each slave's masters; -1 where no cell is near.
    weights : (n, 2^D) float64
        Their weights.
    """
    D = len(vertices.rank.grid.frame.cell)
    corners = np.array([*product((0, 1), repeat=D)])
    firsts = np.array([*product(range(-REACH, REACH), repeat=D)])
    digits = (2 * REACH + 1) ** np.arange(D)[::-1]
    members = ((firsts[:, None] + corners + REACH) * digits).sum(axis=2)
    # Weights of a cell's vertices at a slave, which is -first cells from its lower corner.
    each = np.where(corners[None] == 1, -firsts[:, None], 1 + firsts[:, None]).prod(axis=2)
    middle = firsts + 0.5
    # Of cells that are as good the same one on both sides of a plane of symmetry.
    cost = np.abs(each).sum(axis=1) + _TIE * np.abs(middle) @ np.arange(1.0, 1.0 + D)
    middle /= np.sqrt((middle * middle).sum(axis=1))[:, None]
    steps = np.array([*product(range(-REACH, REACH + 1), repeat=D)])
    near = (np.abs(steps) <= 1).all(axis=1)

    masters = np.full((len(keys), len(corners)), -1, np.int64)
    weights = np.zeros((len(keys), len(corners)))
    place = vertices.numbers(vertices.rank, keys)
    for begin in range(0, len(keys), _BLOCK):
        some = slice(begin, begin + _BLOCK)
        around = vertices.shifted(keys[some])
        row = np.minimum(np.searchsorted(known, around), max(len(known) - 1, 0))
        there = known[row] == around
        volume = np.where(there, held[row], 0.0)
        good = (volume >= least)[:, members].all(axis=2)
        score = np.where(good, cost, np.inf)
        for axis, number, _ in vertices.faces:
            on = place[axis][some] == number
            score += _OFF_FACE * (on[:, None] & (np.abs(firsts[:, axis] + 0.5) > 1.0))
        for axis, number, _ in vertices.faces:  # beyond it are images
            on = place[axis][some] == number
            volume[on] *= 1.0 + (steps[:, axis] != 0)
        inward = np.zeros((len(around), D))
        for d in range(D):
            for column in np.flatnonzero(near):
                inward[:, d] += volume[:, column] * steps[column, d]
        for axis, number, _ in vertices.faces:
            inward[place[axis][some] == number, axis] = 0.0
        size = np.sqrt((inward * inward).sum(axis=1))
        inward /= np.where(size > 0.0, size, 1.0)[:, None]
        along = np.zeros(good.shape)
        for d in range(D):
            along += inward[:, d, None] * middle[None, :, d]
        score -= 0.25 * np.round(along, 9)
        best = np.argmin(score, axis=1)
        found = np.isfinite(score[np.arange(len(best)), best])
        masters[some][found] = np.take_along_axis(row, members[best], axis=1)[found]
        weights[some][found] = each[best][found]
    return masters, weights
