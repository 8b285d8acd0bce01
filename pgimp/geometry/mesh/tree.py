"""A closed surface of triangles with a tree over them, and its queries."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Planes of boxes whose triangles are searched together.
_TOGETHER = 32

#: Rounding tolerance, as a part of a box: of boxes without a surface, and beyond empty and full.
_SLACK = 1e-6


class Surface(NamedTuple):
    """A closed surface, facing outwards, at holes inwards."""

    #: (n, 3, 3) float64: In the order of the tree; the directions are x, y, z, and in 2D x, an
    #: added one, y.
    triangles: Reals
    component: Ints  #: (n,) int64: Connected part of each triangle.
    #: low, high: (2 * leaves, 3) float64: Boxes of the tree's nodes, see
    #: `pgimp.geometry.mesh.treekernels`.
    low: Reals
    high: Reals
    dimensions: int  #: Dimensions of the case.
    facets: int = 0  #: Number of triangles, in 2D of segments.
    notes: tuple[str, ...] = ()  #: Repairs.

    @property
    def leaves(self) -> int:
        """Number of leaves of the tree."""
        return len(self.low) // 2

    @property
    def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners of its bounding box."""
        axes = [0, 2] if self.dimensions == 2 else [0, 1, 2]
        low, high = self.low[1, axes], self.high[1, axes]
        return tuple(low.tolist()), tuple(high.tolist())

    @property
    def volume(self) -> float:
        """Enclosed volume, exact to rounding."""
        if len(self.triangles) == 0:
            return 0.0
        p = self.triangles - 0.5 * (self.low[1] + self.high[1])
        a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        shadow = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        return float((shadow * p[:, :, 2].mean(axis=1)).sum())

    def _lift(self, points: Reals) -> Reals:
        """Points in the surface's directions."""
        if self.dimensions == 3:
            return np.ascontiguousarray(points, dtype=float)
        return np.stack([points[:, 0], np.full(len(points), 0.5), points[:, 1]], axis=1)

    def count_above(self, points: Reals, own: Ints) -> Ints:
        """Signed number of surfaces above points in the surface's directions, (n,) int64.

        Each point's component `own` is left out; none if it is negative.
        """
        from pgimp.geometry.mesh.treekernels import inside

        out = np.empty(len(points), np.int64)
        surface = self.triangles, self.low, self.high, self.leaves, self.component
        inside(*surface, own, np.ascontiguousarray(points), out)
        return out

    def contains(self, points: Reals) -> NDArray[np.bool_]:
        """Whether points lie inside."""
        return self.count_above(self._lift(points), np.full(len(points), -1)) > 0

    def distance(self, points: Reals) -> Reals:
        """Distance to the surface, exact; negative inside."""
        found = self.reach(points)
        return np.where(self.contains(points), -found, found)

    def reach(self, points: Reals, step: float | None = None) -> Reals:
        """Distance to the surface, exact; zero or more.

        With a `step` (n, 1 + 2 D): of the points, and of those a step ahead along each direction,
        and behind.
        """
        from pgimp.geometry.mesh.treekernels import LISTED, distances

        beside = np.zeros((0, 3))
        if step is not None:
            ahead = step * np.eye(3)[[0, 2] if self.dimensions == 2 else [0, 1, 2]]
            beside = np.concatenate([ahead, -ahead])
        out = np.empty((len(points), 1 + len(beside)))
        tree = self.triangles, self.low, self.high, self.leaves
        lifted, done, size = self._lift(points), 0, LISTED
        while done < len(lifted):
            space = np.empty(size, np.int64), np.empty(size)
            done, size = distances(tree, lifted, beside, done, space, out), 2 * size
        return out[:, 0] if step is None else out

    def crossings(self, points: Reals, axis: int) -> Reals:
        """Intersections of lines through points with the surface, (n, k), NaN where fewer."""
        if self.dimensions == 2 and axis == 1:
            axis = 2
        return self.meet(self._lift(points), axis)[0]

    def meet(self, points: Reals, axis: int) -> tuple[Reals, Ints]:
        """As `crossings` in the surface's directions, with signs: 1 where the line leaves."""
        from pgimp.geometry.mesh.treekernels import lines

        capacity = 8
        while True:
            heights = np.full((len(points), capacity), np.nan)
            signs = np.zeros((len(points), capacity), np.int64)
            most = lines(
                self.triangles, self.low, self.high, self.leaves, axis, points, heights, signs
            )
            if most <= capacity:
                return heights[:, :most], signs[:, :most]
            capacity = most

    def fill(
        self, edges: list[Reals], ranges: list[tuple[int, int]], products: bool = False
    ) -> tuple[NDArray[np.bool_], Ints, Reals, Reals]:
        """Return the exact parts of the body in the boxes of a part of a lattice.

        Parameters
        ----------
        edges : list of (n + 1,) float64
            Edges of the lattice's boxes by direction.
        ranges : list of (int, int)
            First box and end by direction.
        products : bool
            Whether to measure products of inertia, too.

        Returns
        -------
        whole : (boxes,) bool
            Boxes that lie inside and that no surface reaches.
        places : (n,) int64
            Boxes that the surface reaches, ascending.
        volume, moment : (n,) and (n, D or 2^D - 1) float64
            Volumes of their parts inside, and moments about the boxes' centres.

        Raises
        ------
        CaseError
            If the surface overlaps itself, with the position.
        """
        from pgimp.geometry.mesh.clip import PRODUCTS, SUMS, clip_plane, settle_plane

        cut = [e[begin : end + 1] for e, (begin, end) in zip(edges, ranges, strict=True)]
        ex, ey, ez = (cut[0], np.array([0.0, 1.0]), cut[1]) if self.dimensions == 2 else cut
        shape = (len(ex) - 1, len(ey) - 1, len(ez) - 1)
        beyond = np.append(ez, np.inf)
        whole = np.zeros(shape, bool)
        width = 8 if products else 4
        places, found = [np.zeros(0, np.int64)], [np.zeros((0, width))]
        sums = np.empty((shape[1], shape[2] + 1, SUMS + PRODUCTS * products))
        touched = np.empty(sums.shape[:2], bool)
        parts = np.empty((shape[1], shape[2], width))
        for i, chosen in self._reaching(ex):
            sums[:], touched[:] = 0.0, False
            if len(chosen):
                clip_plane(self.triangles, chosen, ex[i], ex[i + 1], ey, beyond, sums, touched)
                dx = ex[i + 1] - ex[i]
                wrong = settle_plane(sums, touched, dx, ey, ez, _SLACK, whole[i], parts)
                if wrong >= 0:
                    j, k = divmod(wrong, shape[2])
                    at = [0.5 * (e[n] + e[n + 1]) for e, n in ((ex, i), (ey, j), (ez, k))]
                    at = at if self.dimensions == 3 else [at[0], at[2]]
                    raise CaseError(
                        f"overlaps or cuts itself in the box of a particle at "
                        f"({', '.join(f'{x:.6g}' for x in at)}): inside and outside cannot be "
                        "told apart; repair the mesh (a union of its parts)"
                    )
            here = np.flatnonzero(touched[:, : shape[2]])
            places.append(here + i * shape[1] * shape[2])
            found.append(parts.reshape(-1, width)[here])
        values = np.concatenate(found)
        moment = values[:, 1:] if self.dimensions == 3 else values[:, [1, 3, 5][: width // 4 + 1]]
        return whole.reshape(-1), np.concatenate(places), values[:, 0].copy(), moment

    def _reaching(self, ex: Reals) -> Iterator[tuple[int, Ints]]:
        """Yield each plane of boxes along x with the triangles that may reach it, in order."""
        least, most = self.triangles[:, :, 0].min(axis=1), self.triangles[:, :, 0].max(axis=1)
        for begin in range(0, len(ex) - 1, _TOGETHER):
            end = min(begin + _TOGETHER, len(ex) - 1)
            near = np.flatnonzero((least <= ex[end]) & (most >= ex[begin]))
            a, b = least[near], most[near]
            for i in range(begin, end):
                yield i, near[(a <= ex[i + 1]) & (b >= ex[i])]


def build_tree(triangles: Reals, component: Ints, dimensions: int) -> Surface:
    """Order triangles along a space-filling curve, and build a tree of boxes over them."""
    component = np.resize(component, len(triangles))
    middle = triangles.mean(axis=1)
    low, size = middle.min(axis=0), np.ptp(middle, axis=0)
    grid = ((middle - low) / np.where(size > 0.0, size, 1.0) * 0x1FFFFF).astype(np.uint64)
    order = np.argsort(interleave(grid), kind="stable")
    triangles = np.ascontiguousarray(triangles[order])
    return Surface(triangles, component[order], *boxes_of(triangles), dimensions)


def boxes_of(triangles: Reals) -> tuple[Reals, Reals]:
    """Low and high corners of the boxes of a tree over triangles in this order."""
    from pgimp.geometry.mesh.treekernels import LEAF

    leaves = 1 << max(0, (-(-len(triangles) // LEAF) - 1).bit_length())
    boxes = []
    for reduce, nothing in ((np.minimum, np.inf), (np.maximum, -np.inf)):
        tree = np.full((2 * leaves, 3), nothing)
        whole = len(triangles) // LEAF
        own = tree[leaves : leaves + whole]
        for k in range(LEAF if whole else 0):
            for corner in range(3):
                reduce(own, triangles[k : LEAF * whole : LEAF, corner], out=own)
        if whole < leaves:
            rest = triangles[LEAF * whole :].reshape(-1, 3)
            tree[leaves + whole] = reduce.reduce(rest, axis=0, initial=nothing)
        level = leaves // 2
        while level:
            tree[level : 2 * level] = reduce(
                tree[2 * level : 4 * level : 2], tree[2 * level + 1 : 4 * level : 2]
            )
            level //= 2
        boxes.append(tree)
    return boxes[0], boxes[1]


def nothing(dimensions: int) -> Surface:
    """The surface of an empty body."""
    tree = np.full((2, 3), np.inf)
    return Surface(np.zeros((0, 3, 3)), np.zeros(0, np.int64), tree, -tree, dimensions)


def interleave(grid: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Morton numbers of points, (n, 3), on a grid of 21 bits a direction."""
    total = np.zeros(len(grid), np.uint64)
    for d in range(3):
        x = grid[:, d].copy()
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):
            x = (x | (x << np.uint64(shift))) & np.uint64(mask)
        total |= x << np.uint64(d)
    return total
