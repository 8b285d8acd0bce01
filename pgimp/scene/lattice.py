"""The initial particles: a lattice of `particles_per_cell` points a cell, cut out by the regions.

Particles are made slab by slab: first every rank counts the points of its share of the lattice's
planes, then, with the counts known to all, it makes the particles of its own layers only. No rank
ever holds more. Ids number the particles by body, then by position (x first).
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.scene.regions.base import Region

#: Lattice points that are tested at a time.
_BLOCK = 200_000


class Lattice:
    """The points at which particles may start, and the bodies that contain them.

    Parameters
    ----------
    case : Case
        The case.
    """

    def __init__(self, case: Case) -> None:
        grid, per_cell = case.grid, case.method.particles_per_cell
        self.names = list(case.bodies)
        self.regions: list[Region] = [body.region for body in case.bodies.values()]
        self.per_cell = per_cell
        self.coordinates = []
        for d in range(case.dimensions):
            cells = round(grid.size[d] / grid.cell[d])
            points = np.arange(cells * per_cell[d])
            self.coordinates.append(grid.origin[d] + (points + 0.5) / per_cell[d] * grid.cell[d])

    @property
    def planes(self) -> int:
        """Number of planes of points along x."""
        return len(self.coordinates[0])

    def _box(self, low: Any, high: Any) -> list[tuple[int, int]]:
        """Ranges of point numbers by direction that hold all points between two corners."""
        box = []
        for d, x in enumerate(self.coordinates):
            begin, end = np.searchsorted(x, low[d], "left"), np.searchsorted(x, high[d], "right")
            box.append((int(begin), int(end)))
        return box

    def _blocks(
        self, box: list[tuple[int, int]], planes: tuple[int, int], cells: bool = False
    ) -> Iterator[tuple[int, tuple[int, ...], np.ndarray]]:
        """Points of a box, not too many at a time, in the order of their ids.

        Yields the first plane, the numbers of points by direction, and the points, (n, D). Planes
        that hold many are cut along y; with `cells`, only between cells.
        """
        step = self.per_cell if cells else (1,) * len(box)
        ranges = [(max(box[0][0], planes[0]), min(box[0][1], planes[1])), *box[1:]]
        counts = [end - begin for begin, end in ranges]
        if min(counts) <= 0:
            return
        row = int(np.prod(counts[2:], initial=1))
        width = counts[1] if len(box) > 1 else 1
        deep = max(1, _BLOCK // (row * width) // step[0]) * step[0]
        if len(box) > 1 and row * width * deep > _BLOCK:
            width = max(1, _BLOCK // (row * deep) // step[1]) * step[1]
        for x in range(*ranges[0], deep):
            sides = [self.coordinates[0][x : min(ranges[0][1], x + deep)]]
            for axis, (begin, end) in zip(self.coordinates[1:], ranges[1:], strict=True):
                sides.append(axis[begin:end])
            for y in range(0, len(sides[1]) if len(sides) > 1 else 1, width):
                part = [sides[0], *(side[y : y + width] for side in sides[1:2]), *sides[2:]]
                points = np.stack(np.meshgrid(*part, indexing="ij"), axis=-1)
                yield x, tuple(map(len, part)), points.reshape(-1, len(box))

    def count(self, planes: tuple[int, int]) -> np.ndarray:
        """Points of each body in each plane of a range, (bodies, planes) int64."""
        counts = np.zeros((len(self.regions), planes[1] - planes[0]), np.int64)
        for body, region in enumerate(self.regions):
            for first, sizes, points in self._blocks(self._box(*region.bounds()), planes):
                inside = region.contains(points).reshape(sizes[0], -1).sum(axis=1)
                counts[body, first - planes[0] : first - planes[0] + sizes[0]] += inside
        return counts

    def close_pairs(self) -> Iterator[tuple[int, int, list[tuple[int, int]]]]:
        """Pairs of bodies that may share a cell, with the box of points where they may."""
        for a, first in enumerate(self.regions):
            for b in range(a + 1, len(self.regions)):
                ends = list(zip(first.bounds(), self.regions[b].bounds(), strict=True))
                low = np.maximum(*ends[0])
                high = np.minimum(*ends[1])
                cell = np.array([x[1] - x[0] if len(x) > 1 else 0.0 for x in self.coordinates])
                if (low <= high + 2 * cell * np.array(self.per_cell)).all():
                    box = self._box(np.minimum(low, high), np.maximum(low, high))
                    yield a, b, self._whole_cells(box)

    def _whole_cells(self, box: list[tuple[int, int]]) -> list[tuple[int, int]]:
        """A box of points widened to whole cells, and by a cell to each side."""
        return [
            (max((a // n - 1) * n, 0), min((-(-b // n) + 1) * n, len(x)))
            for (a, b), n, x in zip(box, self.per_cell, self.coordinates, strict=True)
        ]

    def meetings(self, planes: tuple[int, int]) -> tuple[list[str], set[tuple[str, str]]]:
        """Where bodies come together, among the points of a range of planes.

        Returns
        -------
        errors : list of str
            One message for each pair of bodies that contain the same point.
        shared : set of pairs of names
            Bodies with points in the same cell.
        """
        errors, shared = [], set()
        step = self.per_cell[0]
        for a, b, box in self.close_pairs():
            names = (self.names[a], self.names[b])
            begin = -(-max(planes[0], box[0][0]) // step) * step
            for plane in range(begin, min(planes[1], box[0][1]), step):
                for _, sizes, points in self._blocks(box, (plane, plane + step), cells=True):
                    in_a = self.regions[a].contains(points)
                    in_b = self.regions[b].contains(points)
                    if (in_a & in_b).any():
                        place = ", ".join(f"{x:g}" for x in points[(in_a & in_b).argmax()])
                        errors.append(
                            f"bodies.{names[1]}.region: the point ({place}) lies in both "
                            f"'{names[0]}' and '{names[1]}'; a particle belongs to one body: "
                            "move or cut one of them (region: {difference: [...]})"
                        )
                        break
                    if self._cells(in_a, sizes) & self._cells(in_b, sizes):
                        shared.add(names)
                else:
                    continue
                break
        return errors, shared

    def _cells(self, inside: np.ndarray, sizes: tuple[int, ...]) -> set[int]:
        """Numbers of the cells, within a block of whole cells, that hold points inside."""
        index = np.unravel_index(np.flatnonzero(inside), sizes)
        cell = np.zeros(len(index[0]), np.int64)
        for i, size, n in zip(index, sizes, self.per_cell, strict=True):
            cell = cell * (size // n + 1) + i // n
        return set(np.unique(cell).tolist())

    def make(
        self, planes: tuple[int, int], counts: np.ndarray
    ) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
        """Particles of a range of planes.

        Parameters
        ----------
        planes : (int, int)
            First plane and end.
        counts : (bodies, planes of the lattice) int64
            Points of each body in each plane.

        Yields
        ------
        body : int
        positions : (n, D) float64
        ids : (n,) int64
        """
        ends = np.cumsum(counts.ravel()).reshape(counts.shape)
        for body, region in enumerate(self.regions):
            plane, taken = -1, 0
            for first, _, points in self._blocks(self._box(*region.bounds()), planes):
                if first != plane:
                    plane, taken = first, 0
                inside = points[region.contains(points)]
                if len(inside):
                    begin = ends[body, first] - counts[body, first] + taken
                    taken += len(inside)
                    yield body, inside, np.arange(begin, begin + len(inside))


class Census(NamedTuple):
    """What all ranks know about the particles before any exists.

    `counts` holds the points of each body in each plane, (bodies, planes); `notes` says which
    bodies share cells.
    """

    counts: np.ndarray
    notes: list[str]


def census(lattice: Lattice, comm: Any) -> Census:
    """Count all particles, each rank a share of the planes, and check what bodies contain.

    Raises
    ------
    CaseError
        The same on every rank: a point in two bodies, a body without a particle.
    """
    step = lattice.per_cell[0]
    columns = lattice.planes // step
    share = (
        comm.rank * columns // comm.size * step,
        (comm.rank + 1) * columns // comm.size * step,
    )
    own = lattice.count(share)
    errors, shared = lattice.meetings(share)
    results = comm.allgather((own, errors, shared))
    counts = np.concatenate([result[0] for result in results], axis=1)
    problems = list(dict.fromkeys(e for result in results for e in result[1]))[:1]
    for body, name in enumerate(lattice.names):
        if counts[body].sum() == 0:
            problems.append(
                f"bodies.{name}.region: holds no particle: no point of the lattice of "
                f"{' x '.join(str(n) for n in lattice.per_cell)} particles a cell lies inside; "
                "use a larger region, smaller cells (grid.cell) or more particles per cell"
            )
    if problems:
        raise CaseError("\n".join(problems))
    pairs = sorted(set().union(*(result[2] for result in results)))
    notes = [
        f"bodies '{a}' and '{b}' have particles in the same cell: they start in contact, as one"
        for a, b in pairs
    ]
    return Census(counts, notes)
