"""Volume fractions of a body in the lattice boxes, and the particles made from them.

A lattice box is the box of a particle's full size around a lattice point. A cut box takes the
volume, mass and momentum of its part inside (3-5), so the sums over a body are exact (7, 8). It
keeps its full size and its position at the lattice point. A part below `LEAST_FRACTION` of a box
merges inwards, into the fullest neighbour.

The sums are exact to rounding for boxes, their unions and differences. For a ball of radius 2, 4,
8, 16 boxes the error of the mass is 2e-4, 2e-5, 9e-7, 7e-8: fourth order. With whole particles the
error is 6e-2, 1e-2, 3e-3, 1e-3: an order between one and two. A rim in no grid-aligned plane, as
of a tilted cylinder, leaves 1e-3, 1e-4, 6e-5, 8e-6.

One error remains: a cut particle stays at its lattice point, not at the centroid of its part. The
centre of mass of a body is off by at most half a box times the mass fraction of cut particles:
second order.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.measure import measure
from pgimp.geometry.regions.base import Region
from pgimp.physics.shapes.parts import PartParameters
from pgimp.scene.bodies.elements import PRODUCTS
from pgimp.scene.bodies.merge import merge_small
from pgimp.scene.bodies.volume_fractions import Indices, Ranges, Reals, VolumeFractions

#: A part of the lattice.
Key = tuple[tuple[int, int], ...]

#: Points per block that are tested one by one; also boxes per block in slabs of planes.
_BLOCK = 200_000
_SLAB = 4_000_000

#: Up to `_FEW` parts of a region are all tested on all boxes. Of more parts, only the parts that
#: reach a block of boxes are tested; a block has `_NEAR` boxes along each direction.
_FEW, _NEAR = 8, 16

#: In cells: step of the differences for curvatures; curvature that counts as an edge.
_STEP, _SHARP = 0.25, 0.5

#: Boxes of a body that is measured once as a whole, whichever parts are asked for.
_SMALL = 4096

#: Points of a brick, which one test may classify together.
_BRICK = 512


def _points(axes: list[Reals], ranges: Ranges, indices: Indices) -> NDArray[np.float64]:
    """Lattice points, given by their numbers in a part of the lattice, (n, D)."""
    index = np.unravel_index(indices, tuple(end - begin for begin, end in ranges))
    return np.stack([x[i + r[0]] for x, i, r in zip(axes, index, ranges, strict=True)], axis=1)


class LatticeBody:
    """Lattice boxes that a body fills.

    Parameters
    ----------
    region : Region
        The body's.
    edges, centres : list of (n + 1,) and of (n,) float64
        Coordinates of the lattice's boxes by direction.
    cut : bool
        Whether surfaces cut boxes; otherwise boxes with their centres inside are whole.
    exact : bool
        Whether parts have their products of inertia, and none merges into a neighbour.
    rings : bool
        Whether boxes are sections of rings.
    """

    def __init__(
        self,
        region: Region,
        edges: list[Reals],
        centres: list[Reals],
        cut: bool,
        exact: bool = False,
        rings: bool = False,
    ) -> None:
        self.region, self.edges, self.centres, self.cut = region, edges, centres, cut
        self.exact = exact
        self._products = PartParameters.products(len(edges), rings) if exact else 0
        low, high = region.bounds()
        self.box: Ranges = []
        for e, a, b in zip(edges, low, high, strict=True):
            begin = int(np.searchsorted(e, a, "right")) - 1
            end = int(np.searchsorted(e, b, "left"))
            self.box.append((max(0, begin), min(len(e) - 1, end)))
        self.size = np.array([(e[-1] - e[0]) / (len(e) - 1) for e in edges])
        self.radius = 0.5 * float(np.sqrt((self.size * self.size).sum())) * (1.0 + 1e-9)
        # Fractions and moments by part of the lattice: needed for the count, then for creation.
        self._measured: dict[Key, tuple[Reals, Reals]] = {}
        self._filled: dict[Key, tuple[NDArray[np.uint8], VolumeFractions]] = {}
        self._small: VolumeFractions | None = None
        # Fraction of a box that rounding of coordinates may add or remove.
        ends = zip(edges, self.size, strict=True)
        reach = max(float(np.abs(e[[0, -1]]).max() / h) for e, h in ends)
        self.rounding = 1e-12 + 16.0 * float(np.finfo(float).eps) * reach

    @property
    def _width(self) -> int:
        """Moments of a box, with its products of inertia if it is exact."""
        return len(self.edges) + self._products

    def slabs(self, planes: tuple[int, int]) -> Iterator[VolumeFractions]:
        """Volume fractions in a range of planes, small cut boxes merged, in ascending order."""
        first, last = max(planes[0], self.box[0][0]), min(planes[1], self.box[0][1])
        if first >= last or any(begin >= end for begin, end in self.box):
            return
        row = int(np.prod([end - begin for begin, end in self.box[1:]], initial=1))
        deep = max(1, _SLAB // row)
        # A small box's neighbour, and the small boxes around it.
        halo = 2 if self.cut and not self.exact else 0
        for begin in range(first, last, deep):
            end = min(begin + deep, last)
            wide = (max(begin - halo, self.box[0][0]), min(end + halo, self.box[0][1]))
            volumes = self.volume_fractions([wide, *self.box[1:]])
            if not self.exact:
                volumes = merge_small(volumes, self.size)
            part = slice((begin - wide[0]) * row, (end - wide[0]) * row)
            at = slice(*np.searchsorted(volumes.indices, (part.start, part.stop)))
            yield VolumeFractions(
                [(begin, end), *self.box[1:]],
                volumes.whole[part],
                volumes.indices[at] - part.start,
                volumes.fractions[at],
                volumes.moments[at],
            )

    def volume_fractions(self, ranges: Ranges) -> VolumeFractions:
        """Volume fractions in a part of the lattice, small cut boxes not merged."""
        if 0 < np.prod([end - begin for begin, end in self.box]) <= _SMALL:
            if self._small is None:
                self._small = self._find_fractions(self.box)
            return self._small if ranges == self.box else self._small.part(ranges)
        return self._find_fractions(ranges)

    def _find_fractions(self, ranges: Ranges) -> VolumeFractions:
        """Volume fractions by the region's distances, and by integrals over cut boxes."""
        if self.cut and (found := self._fill(ranges)) is not None:
            return found
        shape = tuple(end - begin for begin, end in ranges)
        inside, mixed = self._bricks(ranges)
        whole = inside.reshape(-1)
        cut, rows = [], np.flatnonzero(mixed)
        for begin in range(0, len(rows), _BLOCK):
            part = rows[begin : begin + _BLOCK]
            points = self.points(ranges, part)
            if self.cut:
                distance = self.region.distance(points)
                whole[part] = distance < -self.radius
                cut.append(part[np.abs(distance) <= self.radius])
            else:
                whole[part] = self.region.contains(points)
        indices = np.concatenate(cut) if cut else np.zeros(0, np.int64)
        if (key := tuple(ranges)) not in self._measured:
            fractions, moments = np.zeros(len(indices)), np.zeros((len(indices), self._width))
            for begin in range(0, len(indices), _BLOCK):
                few = slice(begin, begin + _BLOCK)
                fractions[few], moments[few] = self._measure(ranges, shape, indices[few])
            self._measured[key] = fractions, moments
        fractions, moments = self._measured[key]
        whole[indices] = fractions == 1.0
        keep = (fractions > 0.0) & (fractions != 1.0)
        return VolumeFractions(ranges, whole, indices[keep], fractions[keep], moments[keep])

    def _fill(self, ranges: Ranges) -> VolumeFractions | None:
        """Volume fractions from a region that measures all boxes itself, else None."""
        if self._products > PRODUCTS[len(self.edges) - 1]:  # those of rings
            return None
        if (key := tuple(ranges)) not in self._filled:
            found = self.region.fill(self.edges, ranges, self.exact)
            if found is None:
                return None
            whole, indices, fractions, moments = found
            fractions, moments = self._rounded(fractions, moments)
            whole[indices] = fractions == 1.0
            keep = (fractions > 0.0) & (fractions != 1.0)
            # Inside boxes are many: kept as bits.
            none = np.zeros(0, bool)
            volumes = VolumeFractions(ranges, none, indices[keep], fractions[keep], moments[keep])
            self._filled[key] = np.packbits(whole), volumes
        bits, volumes = self._filled[key]
        number = int(np.prod([end - begin for begin, end in ranges]))
        return volumes._replace(whole=np.unpackbits(bits, count=number).view(bool))

    def excess(self, x: Reals, cell: Reals) -> Reals:
        """Part of the mean gap from a plane that is due to curvature, a length, at cut boxes, (n,).

        A surface of curvature k along a direction departs from its tangent plane by k s^2/2 at
        distance s. The mean over the tent of a vertex is k/12, in cells. Vertices lie up to half a
        cell from the contact point, which adds up to k/8; half of it is added here. Curvatures are
        second differences of the distance, over a quarter of a cell; a curvature above `_SHARP`
        is an edge and counts as zero.

        Parameters
        ----------
        x : (n, D) float64
            The boxes' centres.
        cell : (D,) float64
            Sides of a cell.
        """
        found = np.zeros(len(x))
        index = [np.searchsorted(e, column) - 1 for e, column in zip(self.edges, x.T, strict=True)]
        for rows, region in self._neighbourhoods(index):
            at, every = region.signed_distance(x[rows]), np.zeros(len(rows))
            sharp = np.zeros(len(rows), bool)
            for d, side in enumerate(cell):
                step = np.zeros(len(cell))
                step[d] = _STEP * side
                ends = region.signed_distance(x[rows] + step)
                ends += region.signed_distance(x[rows] - step)
                bend = (ends - 2.0 * at) / _STEP**2
                sharp |= np.abs(bend) > _SHARP * side
                every += (1.0 / 12.0 + 1.0 / 16.0) * bend
            found[rows] = np.where(sharp, 0.0, every)
        return found

    def _measure(
        self, ranges: Ranges, shape: tuple[int, ...], indices: Indices
    ) -> tuple[Reals, Reals]:
        """Volume fractions and moments of boxes."""
        index = [i + r[0] for i, r in zip(np.unravel_index(indices, shape), ranges, strict=True)]
        low = np.stack([e[i] for e, i in zip(self.edges, index, strict=True)], axis=1)
        high = np.stack([e[i + 1] for e, i in zip(self.edges, index, strict=True)], axis=1)
        volume, moment = np.zeros(len(low)), np.zeros((len(low), self._width))
        for rows, region in self._neighbourhoods(index):
            volume[rows], moment[rows] = measure(region, low[rows], high[rows], self._products)
        return self._rounded(volume, moment)

    def _rounded(self, volume: Reals, moment: Reals) -> tuple[Reals, Reals]:
        """Volumes and moments over a box's volume, set to exactly 0 or 1 within rounding."""
        full = float(np.prod(self.size))
        volume /= full
        moment /= full
        volume[volume <= self.rounding] = 0.0
        volume[np.abs(volume - 1.0) <= self.rounding] = 1.0
        return volume, moment

    def _neighbourhoods(self, index: list[Indices]) -> Iterator[tuple[Indices, Region]]:
        """Boxes by block of the lattice, with the parts of a region that reach the block.

        Blocks are defined on the whole lattice, so the bits depend neither on the ranks nor on
        other boxes.
        """
        if self.region.parts <= _FEW:
            yield np.arange(len(index[0])), self.region
            return
        block = np.stack([i // _NEAR for i in index])
        order = np.lexsort(block[::-1])
        new = (np.diff(block[:, order], axis=1) != 0).any(axis=0)
        for rows in np.split(order, np.flatnonzero(new) + 1) if len(order) else ():
            low, high = [], []
            for e, b in zip(self.edges, block[:, rows[0]], strict=True):
                low.append(float(e[b * _NEAR]) - 4.0 * self.radius)
                high.append(float(e[min((b + 1) * _NEAR, len(e) - 1)]) + 4.0 * self.radius)
            if (region := self.region.near(low, high)) is not None:
                yield rows, region

    def points(self, ranges: Ranges, indices: Indices) -> NDArray[np.float64]:
        """Box centres, given by box numbers in a part of the lattice, (n, D)."""
        return _points(self.centres, ranges, indices)

    def _bricks(self, ranges: Ranges) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Masks of the boxes in bricks entirely inside, and in bricks that may meet the surface."""
        side = round(_BRICK ** (1.0 / len(ranges)))
        middles, square = [], 0.0
        for e, (begin, end) in zip(self.edges, ranges, strict=True):
            low = np.arange(begin, end, side)
            high = np.minimum(low + side, end)
            middles.append(0.5 * (e[low] + e[high]))
            square += float((e[high] - e[low]).max()) ** 2
        radius = 0.5 * np.sqrt(square) * (1.0 + 1e-9)
        shape = tuple(map(len, middles))
        distance = np.empty(int(np.prod(shape)))
        for begin in range(0, len(distance), _BLOCK):
            indices = np.arange(begin, min(begin + _BLOCK, len(distance)))
            points = _points(middles, [(0, n) for n in shape], indices)
            distance[indices] = self.region.distance(points)
        masks = []
        for mask in (distance < -radius, np.abs(distance) <= radius):
            boxes = mask.reshape(shape)
            for d, (begin, end) in enumerate(ranges):
                boxes = np.repeat(boxes, side, axis=d)
                boxes = boxes[(slice(None),) * d + (slice(0, end - begin),)]
            masks.append(np.ascontiguousarray(boxes))
        return masks[0], masks[1]
