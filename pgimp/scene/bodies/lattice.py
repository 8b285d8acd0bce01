"""The initial particles: on a lattice of `particles-per-cell` points a cell, where bodies are.

Particles are made slab by slab. First every rank counts the particles of its share of the
lattice's planes. After the counts are shared, each rank makes the particles of its own layers only
and never holds more. Ids number the particles by body, then by position (x first). Volume
fractions of particles at a surface are computed in `pgimp.scene.bodies.lattice_body`.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.checks.exact_surfaces import exact_surfaces
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.measure import TangledError
from pgimp.geometry.points.block import Block, Saved
from pgimp.geometry.regions import Points
from pgimp.geometry.sweep import close_pairs
from pgimp.physics.contact.pairs import sharing
from pgimp.scene.bodies.clouds.overlap import overlaps
from pgimp.scene.bodies.clouds.point_cloud import Cloud
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.merge import LEAST_FRACTION
from pgimp.scene.bodies.volume_fractions import Ranges, VolumeFractions

#: Particles that are created at a time.
_BLOCK = 200_000

#: Part of a box by which a centroid stays within it: kernels find the cell from it.
_WITHIN = 1e-8


class ParticleBlock(NamedTuple):
    """Some particles of one body."""

    body: int
    positions: NDArray[np.float64]  #: (n, D) float64: Points of the lattice.
    ids: NDArray[np.int64]  #: (n,) int64.
    fractions: NDArray[np.float64]  #: (n,) float64: Volumes, over the volume of an uncut particle.
    #: (n, D) float64: Centres of mass of the particles' parts of the body.
    centroids: NDArray[np.float64]
    velocities: NDArray[np.float64] | None = None  #: (n, D) float64 or None.
    stresses: NDArray[np.float64] | None = None  #: (n, 3, 4 or 6) float64 or None.
    gradients: NDArray[np.float64] | None = None  #: (n, D * D) float64 or None: Of the velocity.
    #: dict of str to (n, k) float64: State variables of the material, and columns that serve as its
    #: parameters, by name. These and the three entries above come from a particle file.
    states: Mapping[str, NDArray[np.float64]] = MappingProxyType({})
    rows: NDArray[np.int64] | None = None  #: (n,) int64 or None: Rows of the file.
    #: columns, saved: mapping, Saved or None: Whole state by column, and what it is of, if the file
    #: is a run's own.
    columns: Mapping[str, NDArray] = MappingProxyType({})
    saved: Saved | None = None
    #: (n, 1, 3 or 4) float64 or None: Products of inertia of the parts, of bodies that are exact to
    #: their surface.
    products: NDArray[np.float64] | None = None

    def places(self, box: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions of the particles, (n, D): of parts with `products` their centroids.

        Those stay within their boxes, of sides `box`, by more than rounding.
        """
        if self.products is None:
            return self.positions
        most = (0.5 - _WITHIN) * box
        return self.positions + np.clip(self.centroids - self.positions, -most, most)


class Lattice:
    """Initial particle positions, and the bodies that fill the boxes around them.

    Parameters
    ----------
    only : set of str, optional
        The bodies that matter; the others count as empty.
    """

    def __init__(self, case: Case, only: Collection[str] | None = None) -> None:
        grid, per_cell = case.grid, case.method.particles_per_cell
        self.names = list(case.bodies)
        #: Which bodies matter, and the stage in which each comes: others may be in its place.
        self.counted = [only is None or name in only for name in self.names]
        self.stages = [
            case.staged.awaited.get(name, 0) if counts else -1
            for name, counts in zip(self.names, self.counted, strict=True)
        ]
        self.shared = sharing(case)
        self.rings = case.axisymmetric
        self.per_cell = per_cell
        self.coordinates = []
        self.edges: list[NDArray[np.float64]] = []
        for d in range(case.dimensions):
            cells = round(grid.size[d] / grid.cell[d])
            points = np.arange(cells * per_cell[d] + 1)
            self.edges.append(grid.origin[d] + points / per_cell[d] * grid.cell[d])
            centres = (points[:-1] + 0.5) / per_cell[d] * grid.cell[d]
            self.coordinates.append(grid.origin[d] + centres)
        self.volume = float(np.prod(grid.cell)) / float(np.prod(per_cell))
        self.bodies: list[LatticeBody | Cloud] = [
            Cloud(body.region, self.edges)
            if isinstance(body.region, Points)
            else LatticeBody(
                body.region,
                self.edges,
                self.coordinates,
                body.surface != "whole-particles",
                exact,
                case.axisymmetric,
            )
            for body, exact in zip(case.bodies.values(), exact_surfaces(case), strict=True)
        ]
        # The last counts by body and plane, and their sums: bodies may be made one by one.
        self._counts: NDArray[np.int64] = np.zeros((0, 0), np.int64)
        self._ends = self._counts

    def excess(self, block: ParticleBlock) -> NDArray[np.float64]:
        """Part of the mean gap from a plane that is due to curvature, (n,), for cut particles.

        See `LatticeBody.excess`. It is 0 for whole particles, and for particles from a file, whose
        surface is unknown.
        """
        found, body = np.zeros(len(block.ids)), self.bodies[block.body]
        cut = np.flatnonzero((block.centroids != block.positions).any(axis=1))
        if isinstance(body, LatticeBody) and len(cut):
            found[cut] = body.excess(block.positions[cut], np.array(self.box) * self.per_cell)
        return found

    @property
    def planes(self) -> int:
        """Number of planes of points along x."""
        return len(self.coordinates[0])

    @property
    def box(self) -> list[float]:
        """Size of a box by direction."""
        return [float(edges[1] - edges[0]) for edges in self.edges]

    def count(self, planes: tuple[int, int]) -> np.ndarray:
        """Particle counts of each body in each plane of a range, (bodies, planes) int64."""
        counts = np.zeros((len(self.bodies), planes[1] - planes[0]), np.int64)
        for number, body in enumerate(self.bodies):
            if not self.counted[number]:
                continue
            if isinstance(body, Cloud):
                counts[number] = body.count(planes)
                continue
            with self._named(number):
                for volumes in body.slabs(planes):
                    begin, end = volumes.ranges[0]
                    here = volumes.exists.reshape(end - begin, -1).sum(axis=1)
                    counts[number, begin - planes[0] : end - planes[0]] = here
        return counts

    @contextmanager
    def _named(self, body: int) -> Iterator[None]:
        """Prefix errors about a body with the key of its region."""
        try:
            yield
        except (TangledError, CaseError) as error:
            raise CaseError(f"bodies.{self.names[body]}.region: {error}") from None

    def close_pairs(self) -> Iterator[tuple[int, int, Ranges]]:
        """Pairs of bodies whose boxes reach into the same cells, with that part of the lattice.

        `pgimp.scene.bodies.clouds.overlap` checks particles from files.
        """
        on_lattice = [n for n, body in enumerate(self.bodies) if isinstance(body, LatticeBody)]
        every = np.array([self.bodies[n].box for n in on_lattice]).reshape(-1, len(self.edges), 2)
        low, high, n = every[..., 0], every[..., 1], np.array(self.per_cell)
        pairs = close_pairs(low, high, n)
        first, second = pairs.T
        begin = np.maximum(low[first], low[second]) // n * n
        end = -(-np.minimum(high[first], high[second]) // n) * n
        stages = np.array(self.stages)[on_lattice]
        met = (begin < end).all(axis=1) & (stages[first] == stages[second]) & (stages[first] >= 0)
        for (i, j), here, there in zip(
            pairs[met].tolist(), begin[met].tolist(), end[met].tolist(), strict=True
        ):
            yield on_lattice[i], on_lattice[j], list(zip(here, there, strict=True))

    def find_overlaps(
        self, planes: tuple[int, int]
    ) -> tuple[list[tuple[tuple[int, int], str]], set[tuple[str, str]]]:
        """Find overlaps of bodies among the points of a range of planes.

        Returns
        -------
        errors : list of ((int, int), str)
            The bodies' numbers and a message for pairs of bodies that overlap. The first pair of
            all is among them; those after the first one on the lattice are not looked at.
        shared : set of pairs of names
            Bodies with particles in the same cell.
        """
        every = overlaps(self.names, self.bodies, self.box, planes, self.stages)
        errors, shared = list(every), set[tuple[str, str]]()
        step = self.per_cell[0]
        for a, b, box in self.close_pairs():
            names = (self.names[a], self.names[b])
            row = int(np.prod([end - begin for begin, end in box[1:]], initial=1))
            deep = max(1, 5 * _BLOCK // (row * step)) * step
            begin = -(-max(planes[0], box[0][0]) // step) * step
            last = min(planes[1], box[0][1])
            for plane in range(begin, last, deep):
                part = [(plane, min(plane + deep, last)), *box[1:]]
                first, second = self.bodies[a], self.bodies[b]
                assert isinstance(first, LatticeBody)
                assert isinstance(second, LatticeBody)
                with self._named(a):
                    both = [first.volume_fractions(part)]
                with self._named(b):
                    both.append(second.volume_fractions(part))
                found = self._overlap(both, (first, second))
                if found is not None:
                    position, filled = found
                    message = (
                        f"bodies.{names[1]}.region: '{names[0]}' and '{names[1]}' overlap in the "
                        f"box of the particle at ({position}), of which they fill {filled:.0%}: "
                        "move or cut one of them (region: {difference: [...]})"
                    )
                    errors.append(((a, b), message))
                    return errors, shared
                if not self._cells(both[0]).isdisjoint(self._cells(both[1])):
                    shared.add(names)
        return errors, shared

    @staticmethod
    def _overlap(
        both: list[VolumeFractions], bodies: tuple[LatticeBody, LatticeBody]
    ) -> tuple[str, float] | None:
        """Describe the first point at which two bodies overlap, and the part of its box they fill.

        Bodies may share a cut box if their parts fit into it. An excess beyond the uncertainty
        from their surfaces' curvature is an overlap.
        """
        first, second = both
        indices = np.flatnonzero(first.exists & second.exists)
        if len(indices) == 0:
            return None
        points = bodies[0].points(first.ranges, indices)
        filled = first.fraction(indices) + second.fraction(indices)
        over = filled > 1.0 + LEAST_FRACTION
        over |= bodies[0].region.contains(points) & bodies[1].region.contains(points)
        if not over.any():
            return None
        return ", ".join(f"{x:g}" for x in points[over.argmax()]), float(filled[over.argmax()])

    def _cells(self, volumes: VolumeFractions) -> set[int]:
        """Numbers of the cells in which more than a small part of a body lies."""
        indices = np.flatnonzero(volumes.exists)
        indices = indices[volumes.fraction(indices) >= LEAST_FRACTION]
        sizes = tuple(end - begin for begin, end in volumes.ranges)
        cell = np.zeros(len(indices), np.int64)
        for i, size, n in zip(np.unravel_index(indices, sizes), sizes, self.per_cell, strict=True):
            cell = cell * (size // n + 1) + i // n
        return set(np.unique(cell).tolist())

    def make(
        self,
        planes: tuple[int, int],
        counts: np.ndarray,
        only: int | None = None,
        own: Callable[[int, Block], np.ndarray] | None = None,
    ) -> Iterator[ParticleBlock]:
        """Particles of a range of planes, of all bodies or of one, in ascending id.

        Parameters
        ----------
        planes : (int, int)
            First plane and end.
        counts : (bodies, planes of the lattice) int64
            Particles of each body in each plane.
        only : int, optional
            The one body.
        own : callable, optional
            Selects particles that are not on the lattice, given the body's number and a block; by
            default the particles within the planes.
        """
        if counts is not self._counts:
            self._counts = counts
            self._ends = np.cumsum(counts, dtype=np.int64).reshape(np.shape(counts))
        ends = self._ends
        for number in range(len(self.bodies)) if only is None else (only,):
            body = self.bodies[number]
            if not counts[number].any():
                continue
            if isinstance(body, Cloud):
                first = int(ends[number, -1] - counts[number].sum())
                for rows, block in body.make(planes, own and partial(own, number)):
                    x, fractions = block.position, block.volume / self.volume
                    given = block.velocity, block.stress, block.gradient, block.states
                    lowest, ids = body.region.summary.lowest, first + rows
                    if lowest >= 0:  # of a run, where they have no gap
                        ids = first + (block.columns["id"] - lowest)
                    yield ParticleBlock(
                        number, x, ids, fractions, x, *given, rows, block.columns, block.saved
                    )
                continue
            for volumes in body.slabs(planes):
                plane = volumes.ranges[0][0]
                first = int(ends[number, plane] - counts[number, plane])
                indices = np.flatnonzero(volumes.exists)
                for begin in range(0, len(indices), _BLOCK):
                    part = indices[begin : begin + _BLOCK]
                    x = body.points(volumes.ranges, part)
                    fractions = volumes.fraction(part)
                    centroids = x + volumes.moment(part) / fractions[:, None]
                    ids = np.arange(first + begin, first + begin + len(part))
                    found = ParticleBlock(number, x, ids, fractions, centroids)
                    if body.exact and self.rings:
                        products = volumes.ring_products(part, x[:, 0], self.box[0])
                        found = found._replace(products=products)
                    elif body.exact:
                        found = found._replace(products=volumes.products(part))
                    yield found
