"""Volume fractions of a body in the lattice boxes, and the particles made from them.

A lattice box is the box of a particle's full size round a lattice point. One that the surface
cuts takes the share of volume, mass and momentum of its part inside (3-5), so that the sums over a
body are those of the body (7, 8); it keeps its full size and its place at the lattice point. A part
below `LEAST_FRACTION` of a box merges inwards: it goes to the fullest of the neighbours.

The sums are exact to rounding for boxes, their unions and differences. The mass of a ball
converges with fourth order: its error is 2e-4, 2e-5, 9e-7, 7e-8 where the radius is 2, 4, 8, 16
boxes; that of whole particles, 6e-2, 1e-2, 3e-3, 1e-3, with an order between one and two. A rim
that no plane along the grid contains, as of a tilted cylinder, leaves 1e-3, 1e-4, 6e-5, 8e-6.

Not covered by the sums: a cut particle stands at its lattice point, not at the centroid
of its part, so that the centre of mass of a body is off by at most half a box's size times the part
of the mass that is in cut particles: by second order.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.measure import measure
from pgimp.geometry.regions.base import Region
from pgimp.scene.bodies.volume_fractions import Places, Ranges, Reals, VolumeFractions

#: Points examined at a time one by one, and boxes at a time in slabs of planes.
_BLOCK = 200_000
_SLAB = 4_000_000

#: Part of a box below which a cut box merges into a neighbour, if one has more.
LEAST_FRACTION = 1e-3

#: Up to this number, all parts of a region are tested on all boxes. Of more parts only those that
#: reach a block of boxes, which has this number of boxes along each direction.
_FEW, _NEAR = 8, 16

#: Of a cell: step of the differences for curvatures; curvature from which on it is an edge.
_STEP, _SHARP = 0.25, 0.5

#: Points of a brick, for which one test may decide.
_BRICK = 512


def _points(axes: list[Reals], ranges: Ranges, places: Places) -> NDArray[np.float64]:
    """Points of a lattice by their numbers in a part of it, (n, D)."""
    index = np.unravel_index(places, tuple(end - begin for begin, end in ranges))
    parts = [x[i + r[0]] for x, i, r in zip(axes, index, ranges, strict=True)]
    return np.stack(parts, axis=1)


class LatticeBody:
    """The boxes of the lattice that a body fills.

    Parameters
    ----------
    region : Region
        The body's.
    edges, centres : list of (n + 1,) and of (n,) float64
        Coordinates of the lattice's boxes by direction.
    cut : bool
        Whether surfaces cut boxes; otherwise those whose centres lie inside are whole.
    """

    def __init__(self, region: Region, edges: list[Reals], centres: list[Reals], cut: bool) -> None:
        self.region, self.edges, self.centres, self.cut = region, edges, centres, cut
        low, high = region.bounds()
        self.box: Ranges = []
        for e, a, b in zip(edges, low, high, strict=True):
            begin = int(np.searchsorted(e, a, "right")) - 1
            end = int(np.searchsorted(e, b, "left"))
            self.box.append((max(0, begin), min(len(e) - 1, end)))
        self.size = np.array([(e[-1] - e[0]) / (len(e) - 1) for e in edges])
        self.radius = 0.5 * float(np.sqrt((self.size * self.size).sum())) * (1.0 + 1e-9)
        # Fractions and moments by the part of the lattice: a rank counts first, then creates.
        self._measured: dict[tuple[tuple[int, int], ...], tuple[Reals, Reals]] = {}
        self._filled: dict[
            tuple[tuple[int, int], ...], tuple[NDArray[np.uint8], VolumeFractions]
        ] = {}
        # Part of a box that rounding of coordinates may add or remove.
        reach = max(
            float(np.abs(e[[0, -1]]).max() / h) for e, h in zip(edges, self.size, strict=True)
        )
        self.rounding = 1e-12 + 16.0 * float(np.finfo(float).eps) * reach

    def slabs(self, planes: tuple[int, int]) -> Iterator[VolumeFractions]:
        """Volume fractions in a range of planes, small cut boxes merged, in ascending order."""
        first, last = max(planes[0], self.box[0][0]), min(planes[1], self.box[0][1])
        if first >= last or any(begin >= end for begin, end in self.box):
            return
        row = int(np.prod([end - begin for begin, end in self.box[1:]], initial=1))
        deep = max(1, _SLAB // row)
        halo = 2 if self.cut else 0  # a small box's neighbour, and the small ones around that
        for begin in range(first, last, deep):
            end = min(begin + deep, last)
            wide = (max(begin - halo, self.box[0][0]), min(end + halo, self.box[0][1]))
            volumes = self._merge(self.volume_fractions([wide, *self.box[1:]]))
            part = slice((begin - wide[0]) * row, (end - wide[0]) * row)
            at = slice(*np.searchsorted(volumes.places, (part.start, part.stop)))
            yield VolumeFractions(
                [(begin, end), *self.box[1:]], volumes.whole[part], volumes.places[at] - part.start,
                volumes.fractions[at], volumes.moments[at],
            )  # fmt: skip

    def volume_fractions(self, ranges: Ranges) -> VolumeFractions:
        """Volume fractions in a part of the lattice, small cut boxes not merged."""
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
        places = np.concatenate(cut) if cut else np.zeros(0, np.int64)
        key = tuple(ranges)
        if key not in self._measured:
            fractions, moments = np.zeros(len(places)), np.zeros((len(places), len(ranges)))
            for begin in range(0, len(places), _BLOCK):
                few = slice(begin, begin + _BLOCK)
                fractions[few], moments[few] = self._measure(ranges, shape, places[few])
            self._measured[key] = fractions, moments
        fractions, moments = self._measured[key]
        whole[places] = fractions == 1.0
        keep = (fractions > 0.0) & (fractions != 1.0)
        return VolumeFractions(ranges, whole, places[keep], fractions[keep], moments[keep])

    def _fill(self, ranges: Ranges) -> VolumeFractions | None:
        """Volume fractions of a region that measures all boxes itself; None of another."""
        key = tuple(ranges)
        if key not in self._filled:
            found = self.region.fill(self.edges, ranges)
            if found is None:
                return None
            whole, places, fractions, moments = found
            fractions, moments = self._rounded(fractions, moments)
            whole[places] = fractions == 1.0
            keep = (fractions > 0.0) & (fractions != 1.0)
            # The boxes inside are many: kept as bits.
            none = np.zeros(0, bool)
            volumes = VolumeFractions(ranges, none, places[keep], fractions[keep], moments[keep])
            self._filled[key] = np.packbits(whole), volumes
        bits, volumes = self._filled[key]
        number = int(np.prod([end - begin for begin, end in ranges]))
        return volumes._replace(whole=np.unpackbits(bits, count=number).view(bool))

    def excess(self, x: Reals, cell: Reals) -> Reals:
        """Curvature's share of the mean gap from a plane, a length, at boxes that it cuts, (n,).

        A surface of the curvature k along a direction is k s^2/2 farther from a plane at the
        distance s from where it touches it. The mean of that over the tent of a vertex is k/12, in
        cells; vertices lie up to half a cell from there, which adds up to k/8, half of it here.
        Curvatures are second differences of the distance, over a quarter of a cell; more than
        `_SHARP` is an edge, and counts as none.

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
        self, ranges: Ranges, shape: tuple[int, ...], places: Places
    ) -> tuple[Reals, Reals]:
        """Fractions and moments of boxes."""
        index = [i + r[0] for i, r in zip(np.unravel_index(places, shape), ranges, strict=True)]
        low = np.stack([e[i] for e, i in zip(self.edges, index, strict=True)], axis=1)
        high = np.stack([e[i + 1] for e, i in zip(self.edges, index, strict=True)], axis=1)
        volume, moment = np.zeros(len(low)), np.zeros_like(low)
        for rows, region in self._neighbourhoods(index):
            volume[rows], moment[rows] = measure(region, low[rows], high[rows])
        return self._rounded(volume, moment)

    def _rounded(self, volume: Reals, moment: Reals) -> tuple[Reals, Reals]:
        """Over the volume of a box, exactly 0 or 1 where it differs by rounding only."""
        full = float(np.prod(self.size))
        volume /= full
        moment /= full
        volume[volume <= self.rounding] = 0.0
        volume[np.abs(volume - 1.0) <= self.rounding] = 1.0
        return volume, moment

    def _neighbourhoods(self, index: list[Places]) -> Iterator[tuple[Places, Region]]:
        """Boxes by block of the lattice, with the parts of a region that reach there.

        The blocks are those of the whole lattice, so that the bits depend neither on the ranks nor
        on other boxes.
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

    def points(self, ranges: Ranges, places: Places) -> NDArray[np.float64]:
        """Centres of the boxes with these numbers in a part of the lattice, (n, D)."""
        return _points(self.centres, ranges, places)

    def _bricks(self, ranges: Ranges) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Boxes in bricks that lie inside entirely, and in bricks that may meet the surface."""
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
            places = np.arange(begin, min(begin + _BLOCK, len(distance)))
            points = _points(middles, [(0, n) for n in shape], places)
            distance[places] = self.region.distance(points)
        masks = []
        for mask in (distance < -radius, np.abs(distance) <= radius):
            boxes = mask.reshape(shape)
            for d, (begin, end) in enumerate(ranges):
                boxes = np.repeat(boxes, side, axis=d)
                boxes = boxes[(slice(None),) * d + (slice(0, end - begin),)]
            masks.append(np.ascontiguousarray(boxes))
        return masks[0], masks[1]

    def _merge(self, volumes: VolumeFractions) -> VolumeFractions:
        """Merge small cut boxes into the fullest neighbour, of equals the nearest, then the first.

        Near means that few coordinates differ.
        """
        small = np.flatnonzero(volumes.fractions < LEAST_FRACTION)
        if len(small) == 0:
            return volumes
        origins = volumes.places[small]
        shape = tuple(end - begin for begin, end in volumes.ranges)
        index = np.unravel_index(origins, shape)
        target = np.full(len(origins), -1)
        fullest = np.full(len(origins), np.nextafter(LEAST_FRACTION, 0.0))
        away = np.zeros((len(origins), len(shape)))
        steps = np.array(list(np.ndindex(*(3,) * len(shape)))) - 1
        for step in steps[np.argsort(np.abs(steps).sum(axis=1), kind="stable")]:
            there = [i + s for i, s in zip(index, step, strict=True)]
            valid = np.ones(len(origins), bool)
            for i, n in zip(there, shape, strict=True):
                valid &= (0 <= i) & (i < n)
            rows = np.flatnonzero(valid)
            places = np.ravel_multi_index([i[rows] for i in there], shape)
            fraction = volumes.fraction(places)
            better = fraction > fullest[rows]
            rows = rows[better]
            target[rows], fullest[rows] = places[better], fraction[better]
            away[rows] = -step * self.size
        goes = target >= 0
        small, target, away = small[goes], target[goes], away[goes]
        kept = np.ones(len(volumes.places), bool)
        kept[small] = False
        places = np.union1d(volumes.places[kept], target)
        fractions, moments = volumes.fraction(places), volumes.moment(places)
        whole = volumes.whole.copy()
        whole[places] = False
        at = np.searchsorted(places, target)
        given = volumes.fractions[small]
        np.add.at(fractions, at, given)  # one after the other, in the order of the boxes
        np.add.at(moments, at, volumes.moments[small] + given[:, None] * away)
        return volumes._replace(whole=whole, places=places, fractions=fractions, moments=moments)
