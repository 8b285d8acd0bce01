"""Elements of a body's surface in the boxes of the lattice, and the particles that carry them.

By the divergence theorem the area vector of the surface in a box is what the areas inside on the
box's faces lack of a closed surface. Its first moments follow from the volume inside and from the
moments of these areas. So all elements together close exactly, whatever the region. Elements are of
parts of lattice boxes, so that a load may begin and end within a box.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.measure import MONOMIALS, measure, pieces
from pgimp.geometry.regions.base import Region
from pgimp.scene.bodies.elements import PRODUCTS, Elements, Indices, Reals
from pgimp.scene.bodies.lattice_body import LatticeBody

#: Faces of the lattice, by axis and side.
Closed = Sequence[tuple[int, int]]

#: Parts of a box along each direction, by the dimensions.
_PARTS = (1, 4, 2)

#: Thickness of the slabs by which areas are measured, and least area, over those of a part.
_THIN, _LEAST = 1e-4, 1e-9

#: Part of a piece's volume that is rounding.
_ROUNDING = 1e-9

#: Part of the squared area below which an area vector is that of no direction.
_NONE = 1e-20

#: Boxes from an element to the particle that carries it, at most.
AWAY = 2

#: Boxes whose distances are found at once.
_BLOCK = 200_000


def _edge(edges: Reals, i: Indices) -> Reals:
    """Coordinates of edges of boxes, also beyond the lattice."""
    last = len(edges) - 1
    inside = edges[np.clip(i, 0, last)]
    low, high = edges[1] - edges[0], edges[-1] - edges[-2]
    return inside + np.minimum(i, 0) * low + np.maximum(i - last, 0) * high


def find_elements(
    body: LatticeBody, within: Region | None, planes: tuple[int, int], closed: Closed = ()
) -> Elements:
    """Find the elements of a body's surface within a region, in a range of lattice planes.

    Parameters
    ----------
    body : LatticeBody
        The body; its boxes are whole where surfaces do not cut them.
    within : Region or None
        Elements with their centroid in here count; None: all.
    planes : (int, int)
        First plane and end; elements there, and up to a box beyond the lattice, are found.
    closed : sequence of (axis, side)
        Faces of the lattice, low (-1) or high (1), behind which bodies go on: none is on these.
    """
    ranges = []
    least, most = (body.region if within is None else within).bounds()
    for d, (e, (begin, end)) in enumerate(zip(body.edges, body.box, strict=True)):
        low = max(begin - 1, int(np.floor((max(least[d], -1e300) - e[0]) / body.size[d])) - 1, -1)
        high = (min(most[d], 1e300) - e[0]) / body.size[d]
        high = min(end + 1, int(np.ceil(min(high, 2.0**60))) + 1, len(e))
        if d == 0:
            low, high = max(low, planes[0]), min(high, planes[1])
        ranges.append(np.arange(low, max(low, high)))
        if (d, -1) in closed:
            ranges[d] = ranges[d][ranges[d] >= 0]
        if (d, 1) in closed:
            ranges[d] = ranges[d][ranges[d] < len(e) - 1]
    cuts = (body.region, *([within] if within else ())) if body.exact else ()
    facets = _facet_elements(body, ranges, closed, within) if body.exact else None
    if facets is not None:
        found = facets
    elif body.cut:
        found = _cut_elements(body, ranges, closed, cuts)
    else:
        found = _whole_elements(body, ranges, closed)
    if within is None or not len(found.box):
        return found
    return found.chosen(within.contains(found.centroid))


def _combinations(axes: Sequence[Indices]) -> Indices:
    """All combinations of numbers, in C order, (n, D)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _near(body: LatticeBody, low: Reals, high: Reals) -> NDArray[np.bool_]:
    """Mask of the boxes that the surface may meet."""
    found = np.empty(len(low), bool)
    for begin in range(0, len(low), _BLOCK):
        few = slice(begin, begin + _BLOCK)
        square = np.zeros(len(low[few]))
        for d in range(low.shape[1]):
            square += (high[few, d] - low[few, d]) ** 2
        away = np.abs(body.region.distance(0.5 * (low[few] + high[few])))
        found[few] = away <= 0.5 * np.sqrt(square) * (1.0 + 1e-6)
    return found


def _cut_elements(
    body: LatticeBody, ranges: Sequence[Indices], closed: Closed, cuts: Sequence[Region]
) -> Elements:
    """Elements of a surface that cuts boxes; none of them crosses a plane of the regions `cuts`.

    On such planes each side of a box has an element of its own, so that edges have none.
    """
    D, boxes = len(ranges), []
    for plane in ranges[0]:
        some = _combinations([np.array([plane]), *ranges[1:]])
        ends = (
            np.stack([_edge(e, some[:, d] + k) for d, e in enumerate(body.edges)], axis=1)
            for k in (0, 1)
        )
        boxes.append(some[_near(body, *ends)] if len(some) else some)
    box = np.concatenate(boxes) if boxes else np.zeros((0, D), np.int64)
    parts = _PARTS[D - 1]
    each = _combinations([np.arange(parts)] * D)
    part = np.tile(each, (len(box), 1))
    box = np.repeat(box, len(each), axis=0)
    low, high = np.empty(box.shape), np.empty(box.shape)
    for d, e in enumerate(body.edges):
        a, b = _edge(e, box[:, d]), _edge(e, box[:, d] + 1)
        low[:, d] = a + part[:, d] / parts * (b - a)
        high[:, d] = a + (part[:, d] + 1) / parts * (b - a)
    near = _near(body, low, high) if len(low) else np.zeros(0, bool)
    box, low, high = box[near], low[near], high[near]
    thin = 0.5 * _THIN * (high - low)  # the same for pieces side by side
    for region in cuts:
        row, low, high = pieces(region, low, high)
        box, thin = box[row], thin[row]
    n, size, count = len(box), high - low, PRODUCTS[D - 1] if body.exact else 0
    area, moment = np.zeros((n, D)), np.zeros((n, D, D))
    second = np.zeros((n, PRODUCTS[D - 1], D))
    volume, inner = measure(body.region, low, high, count)
    full = size.prod(axis=1)
    whole = volume > (1.0 - _ROUNDING) * full
    # Pieces without a surface inside, but for their faces, have an element for each of these.
    plain = whole | (volume < _ROUNDING * full) if cuts else np.zeros(n, bool)
    sides = []
    for d in range(D):
        moment[:, d, d] += volume
        for side, at in ((-1.0, low), (1.0, high)):
            a, b = low.copy(), high.copy()
            a[:, d], b[:, d] = at[:, d] - thin[:, d], at[:, d] + thin[:, d]
            if (d, int(side)) in closed:
                end = body.edges[d][0 if side < 0.0 else -1]
                if side < 0.0:
                    a[:, d] = np.maximum(a[:, d], end)
                else:
                    b[:, d] = np.minimum(b[:, d], end)
            inside, first = measure(body.region, a, b, count)
            thickness = b[:, d] - a[:, d]
            half_size = 0.5 * side * size[:, d]
            face = inside / thickness
            area[:, d] -= side * face
            arms = np.zeros((n, D))
            for j in range(D):
                arms[:, j] = half_size * face if j == d else first[:, j] / thickness
                moment[:, j, d] -= side * arms[:, j]
            more = np.zeros((n, PRODUCTS[D - 1]))
            for k, axes in enumerate(MONOMIALS[D - 1][1 + D : 1 + D + count]):
                if d not in axes:
                    more[:, k] = first[:, D + k] / thickness
                else:
                    rest = _column(axes, d)
                    more[:, k] = half_size * first[:, rest] / thickness
                    second[:, k, d] += 0.5 * inner[:, rest]  # once for each side
                second[:, k, d] -= side * more[:, k]
            if plain.any():
                missing = np.where(whole, full / size[:, d], 0.0) - face
                arms[:, d] -= side * 0.5 * np.where(whole, full, 0.0)
                sides.append(_side(d, side, missing, -side * arms, -side * more))
    there = np.zeros(n, bool)
    for d in range(D):
        there |= np.abs(area[:, d]) > _LEAST * (full / size[:, d])
    found = Elements(box, 0.5 * (low + high), area, moment, 0.5 * size, second)
    if not plain.any():
        return found.chosen(there)
    every = [found.chosen(there & ~plain)]
    for of_side, moments, seconds, d in sides:
        some = plain & (np.abs(of_side[:, d]) > _LEAST * (full / size[:, d]))
        own = found._replace(area=of_side, moment=moments, second=seconds)
        every.append(own.chosen(some))
    return Elements(*map(np.concatenate, zip(*every, strict=True)))


def _facet_elements(
    body: LatticeBody, ranges: Sequence[Indices], closed: Closed, within: Region | None
) -> Elements | None:
    """Elements of a surface of triangles, cut along planes of the region; None for others."""
    edges, lattice, D = [], [], len(ranges)
    planes = within.planes() if within else []
    for d, r in enumerate(ranges):
        lattice.append(_edge(body.edges[d], np.append(r, r[-1] + 1 if len(r) else 0)))
        cuts = [plane.at for plane in planes if plane.axis == d]
        own = [at for at in cuts if lattice[d][0] < at < lattice[d][-1]] if len(r) else []
        edges.append(np.unique(np.append(lattice[d], own)))
    pieces = body.region.facets(edges)
    if pieces is None:
        return None
    number, centre, area, second = pieces
    box, kept = np.empty_like(number), np.ones(len(number), bool)
    for d, r in enumerate(ranges):
        box[:, d] = np.searchsorted(lattice[d], edges[d][number[:, d]], "right") - 1 + r[:1].sum()
        for side in (-1, 1):
            if (d, side) in closed:
                end = body.edges[d][0 if side < 0 else -1]
                kept &= np.abs(centre[:, d] - end) > _ROUNDING * body.size[d]
    size = np.sqrt((area * area).sum(axis=1))
    normal = area / np.where(size > 0.0, size, 1.0)[:, None]
    found = Elements(
        box, centre, area, np.zeros((len(box), D, D)), np.full((len(box), D), 0.5) * body.size,
        (second * size[:, None])[:, :, None] * normal[:, None],
    )  # fmt: skip
    return found.chosen(np.flatnonzero(kept)[np.lexsort(box[kept].T[::-1])])


def _column(axes: tuple[int, ...], d: int) -> int:
    """Column of moments with the product of the axes without `d`."""
    rest = tuple(axis for axis in axes if axis != d)
    return rest[0] if len(rest) == 1 else 3 + MONOMIALS[2][4:].index(rest)


def _side(
    d: int, side: float, missing: Reals, arms: Reals, more: Reals
) -> tuple[Reals, Reals, Reals, int]:
    """Area vectors and moments of the elements on a side of boxes, and the side's axis."""
    n, D = arms.shape
    area, moment, second = np.zeros((n, D)), np.zeros((n, D, D)), np.zeros((*more.shape, D))
    area[:, d], moment[:, :, d], second[:, :, d] = side * missing, arms, more
    return area, moment, second, d


def _whole_elements(body: LatticeBody, ranges: Sequence[Indices], closed: Closed) -> Elements:
    """Faces between boxes with a particle and without one."""
    D = len(ranges)
    wide = [np.arange(r[0] - 1, r[-1] + 2) if len(r) else r for r in ranges]
    exists = _exists(body, wide)
    for d, side in closed:
        beyond = -1 if side < 0 else len(body.edges[d]) - 1
        along = np.moveaxis(exists, d, 0)
        if len(wide[d]) and beyond in wide[d] and beyond - side in wide[d]:
            along[beyond - wide[d][0]] = along[beyond - side - wide[d][0]]
    every, offsets = [], [np.zeros((0, D), np.int64)]
    for d in range(D):
        for side in (-1, 1):
            inner = tuple(slice(1, -1) for _ in range(D))
            other = tuple(
                slice(1 + side * (j == d), exists.shape[j] - 1 + side * (j == d)) for j in range(D)
            )
            box = np.argwhere(exists[inner] & ~exists[other])
            offsets.append(box + [r[0] if len(r) else 0 for r in ranges])
            every.append((d, side))
    parts = []
    for (d, side), box in zip(every, offsets[1:], strict=True):
        low, high = (
            np.stack([_edge(e, box[:, j] + k) for j, e in enumerate(body.edges)], axis=1)
            for k in (0, 1)
        )
        area, size = np.zeros(low.shape), high - low
        area[:, d] = side
        for j in range(D):
            area[:, d] *= size[:, j] if j != d else 1.0
        centre = 0.5 * (low + high)
        centre[:, d] = (low, high)[side > 0][:, d]
        half = 0.5 * np.where(np.arange(D) == d, 0.0, size)
        parts.append(Elements.flat(box, centre, area, half))
    found = Elements(*map(np.concatenate, zip(*parts, strict=True)))
    return found.chosen(np.lexsort(found.box.T[::-1]))


def _exists(body: LatticeBody, ranges: Sequence[Indices]) -> NDArray[np.bool_]:
    """Mask of the boxes with a particle; none is beyond the lattice."""
    found = np.zeros([len(r) for r in ranges], bool)
    if not found.size:
        return found
    first = [int(r[0]) for r in ranges]
    for volumes in body.slabs((max(first[0], 0), max(int(ranges[0][-1]) + 1, 0))):
        shape = tuple(end - begin for begin, end in volumes.ranges)
        cut, place = [], []
        for (begin, end), a, r in zip(volumes.ranges, first, ranges, strict=True):
            low, high = max(begin, a), min(end, a + len(r))
            cut.append(slice(low - begin, max(low, high) - begin))
            place.append(slice(low - a, max(low, high) - a))
        found[tuple(place)] = volumes.exists.reshape(shape)[tuple(cut)]
    return found


def carriers(body: LatticeBody, elements: Elements) -> Indices:
    """Boxes of the particles that carry elements: their own, or the nearest with a particle.

    Those without any within `AWAY` boxes get -2.
    """
    D = len(body.edges)
    box = elements.box.copy()
    if not len(box):
        return box
    ranges = [np.arange(box[:, d].min() - AWAY, box[:, d].max() + AWAY + 1) for d in range(D)]
    first = np.array([r[0] for r in ranges])
    exists = _exists(body, ranges)
    lacking = np.flatnonzero(~exists[tuple((box - first).T)])
    steps = _combinations([np.arange(-AWAY, AWAY + 1)] * D)
    centroid = elements.centroid
    for row in lacking:
        near = box[row] + steps
        near = near[exists[tuple((near - first).T)]]
        away = np.zeros(len(near))
        for d, e in enumerate(body.edges):
            middle = 0.5 * (_edge(e, near[:, d]) + _edge(e, near[:, d] + 1))
            away += ((middle - centroid[row, d]) / body.size[d]) ** 2
        box[row] = near[np.argmin(np.round(away, 9))] if len(near) else -2
    return box


def parts_of(body: LatticeBody, elements: Elements, x: Reals, ring: bool) -> tuple[Reals, Reals]:
    """Parts of a surface that particles carry.

    Parameters
    ----------
    elements : Elements
        The elements of the surface within `AWAY` boxes from the particles.
    x : (n, D) float64
        Positions of the body's particles in some planes, in the order of the lattice.
    ring : bool
        Whether boxes stand for rings about the axis x = 0.

    Returns
    -------
    parts : (n, width) float64
        Area, area vector, first moments.
    products : (n, (1 + D) (0, 1 or 4)) float64
        Products of inertia, see `pgimp.kernels.data.particles.Particles.bearing`.
    """
    n, D = x.shape
    found = np.zeros((n, 1 + D + D * D))
    if not n or not len(elements.box):
        return found, np.zeros((n, (1 + D) * PRODUCTS[D - 1]))
    goes = carriers(body, elements)
    whole = _together(body, elements) if ring else elements.area
    shape = tuple(len(e) + 2 for e in body.edges)
    own = np.stack([np.searchsorted(e, x[:, d]) - 1 for d, e in enumerate(body.edges)], axis=1)
    numbers = np.ravel_multi_index(tuple((own + 2).T), shape)
    target = np.ravel_multi_index(tuple((goes + 2).T), shape) if len(goes) else np.zeros(0, int)
    row = np.minimum(np.searchsorted(numbers, target), n - 1)
    mine = numbers[row] == target
    elements, whole, row = elements.chosen(mine), whole[mine], row[mine]
    factor, bend = np.ones(len(row)), np.zeros((len(row), D))
    if ring:
        factor = 2.0 * np.pi * np.maximum(elements.centroid[:, 0], 0.0)
    if ring and body.exact:  # of elements that are not straight
        off = (elements.centroid[:, 0] - elements.centre[:, 0])[:, None]
        bend = 2.0 * np.pi * (elements.moment[:, 0] - off * elements.area)
    square = sum(elements.area[:, d] ** 2 for d in range(D))
    np.add.at(found[:, 0], row, factor * np.sqrt(square))
    for d in range(D):
        np.add.at(found[:, 1 + d], row, factor * elements.area[:, d] + bend[:, d])
        for j in range(D):
            arm = elements.centre[:, j] - x[row, j]
            moment = factor * (elements.moment[:, j, d] + arm * elements.area[:, d])
            if ring:
                moment += 2.0 * np.pi * _spread(whole, j) * elements.area[:, d]
                moment += (elements.centroid[:, j] - x[row, j]) * bend[:, d]
            np.add.at(found[:, 1 + D + D * j + d], row, moment)
    return found, _products(elements, x, row, found, whole if ring else None)


def _products(
    elements: Elements, x: Reals, row: Indices, parts: Reals, rings: Reals | None
) -> Reals:
    """Products of inertia of the parts of a surface in some rows, see `parts_of`.

    For `rings` with the area vectors from `_together`.
    """
    n, D = x.shape
    count = PRODUCTS[D - 1]
    found = np.zeros((n, 1 + D, count))
    vector, loaded = parts[:, 1 : 1 + D], np.flatnonzero(parts[:, 0])
    moment = parts[:, 1 + D :].reshape(n, D, D)
    square = (vector * vector).sum(axis=1)
    some = square > _NONE * parts[:, 0] ** 2
    arm = np.zeros((n, D))
    arm[some] = (moment * vector[:, None]).sum(axis=2)[some] / square[some, None]
    area, centroid = elements.area, (x + arm)[row]
    size = np.sqrt((area * area).sum(axis=1))
    if rings is not None:  # straight strips, which weigh with their radius
        r, (p, q) = np.maximum(elements.centroid[:, 0], 0.0), rings.T
        a, b = (elements.centroid - centroid).T
        product = 2.0 * np.pi * (r * a * b + (q * q * b - p * q * (r + a)) / 12.0)
        second = (area * product[:, None])[:, None]
    else:
        second = elements.about(centroid)
    along = (second * area[:, None]).sum(axis=2) / np.maximum(size, 1e-300)[:, None]
    for k in range(count):
        np.add.at(found[:, 0, k], row, along[:, k])
        for d in range(D):
            np.add.at(found[:, 1 + d, k], row, second[:, k, d])
    found[loaded, 0] /= parts[loaded, 0, None]
    found[:, 1:] -= found[:, :1] * vector[:, :, None]
    if D == 3:  # gradients of weights have the products, too
        about = moment - arm[:, :, None] * vector[:, None]
        found[:, 1:, 3] -= (found[:, 0, :3, None] * about).sum(axis=1)
    return found.reshape(n, -1)


def face_elements(body: LatticeBody, axis: int, side: int, planes: tuple[int, int]) -> Elements:
    """Elements of a face of a body that is a box, one in each box of the lattice.

    Parameters
    ----------
    axis, side : int
        The face's normal is `side` times the unit vector `axis`.
    planes : (int, int)
        First plane and end.
    """
    low, high = (np.array(end) for end in body.region.bounds())
    D, ranges, ends = len(body.edges), [], []
    for d, e in enumerate(body.edges):
        a, b = np.maximum(e[:-1], low[d]), np.minimum(e[1:], high[d])
        some = np.flatnonzero(a < b)
        if d == axis:
            some = some[-1:] if side > 0 else some[:1]
            a[some] = b[some] = (low, high)[side > 0][d]
        if d == 0:
            some = some[(planes[0] <= some) & (some < planes[1])]
        ranges.append(some)
        ends.append((a, b))
    box = _combinations(ranges)
    a, b = (np.stack([ends[d][k][box[:, d]] for d in range(D)], axis=1) for k in (0, 1))
    area = np.zeros(box.shape)
    area[:, axis] = side * np.where(np.arange(D) == axis, 1.0, b - a).prod(axis=1)
    return Elements.flat(box, 0.5 * (a + b), area, 0.5 * (b - a))


#: Places in a box along each direction that tell elements apart.
_PLACES = 32


def _together(body: LatticeBody, elements: Elements) -> Reals:
    """Area vectors of elements in 2D, (n, 2), with those of all at the same place.

    A surface between two boxes has an element in each, of half of its area.
    """
    ends = [e[0] for e in body.edges]
    place = np.rint((elements.centroid - ends) / np.array(body.size) * _PLACES).astype(np.int64)
    number = np.unique(place, axis=0, return_inverse=True)[1].reshape(-1)
    sums = np.zeros((len(place), 2))
    np.add.at(sums, number, elements.area)
    return np.asarray(sums[number])


def _spread(area: Reals, j: int) -> Reals:
    """Mean of (x - x_c) (x_j - x_jc) over straight elements in 2D, (n,), by their area vectors."""
    return np.asarray((area[:, 1] ** 2 if j == 0 else -area[:, 0] * area[:, 1]) / 12.0)
