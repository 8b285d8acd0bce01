"""Elements of surfaces that cut boxes of the lattice: volume and areas inside, measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.measure import MONOMIALS, measure, pieces
from pgimp.geometry.regions.base import Region
from pgimp.geometry.rows import ascending
from pgimp.scene.bodies.elements import PRODUCTS, Elements, Indices, Reals
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.boxes import Closed, combinations, edge

#: Parts of a box along each direction, by the dimensions.
_PARTS = (1, 4, 2)

#: Thickness of the slabs by which areas are measured, and least area, over those of a part. Exact
#: areas are those in the middle between planes; near a pole they are off by its root.
_THIN, _THINNER, _LEAST = 1e-4, 1e-6, 1e-9

#: Part of a piece's volume that is rounding.
_ROUNDING = 1e-9

#: Boxes along each direction whose distance from the surface is found first, as of one.
_BRICK = 8

#: Boxes whose distances are found at once.
_BLOCK = 200_000


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


def _near_boxes(body: LatticeBody, ranges: Sequence[Indices]) -> Indices:
    """Boxes of some ranges that the surface may meet, ascending."""
    found = [np.zeros((0, len(ranges)), np.int64)]
    if any(not len(r) for r in ranges):
        return found[0]
    last = np.array([r[-1] for r in ranges]) + 1

    def near(first: Indices, end: Indices) -> NDArray[np.bool_]:
        ends = (
            np.stack([edge(e, some[:, d]) for d, e in enumerate(body.edges)], axis=1)
            for some in (first, end)
        )
        return _near(body, *ends)

    bricks = combinations([r[::_BRICK] for r in ranges])
    bricks = bricks[near(bricks, np.minimum(bricks + _BRICK, last))]
    inside = combinations([np.arange(_BRICK)] * len(ranges))
    few = max(1, _BLOCK // len(inside))
    for begin in range(0, len(bricks), few):
        boxes = (bricks[begin : begin + few, None] + inside).reshape(-1, len(ranges))
        boxes = boxes[(boxes < last).all(axis=1)]
        found.append(boxes[near(boxes, boxes + 1)])
    boxes = np.concatenate(found)
    return boxes[ascending(boxes)]


def _before(number: Indices) -> Indices:
    """For each piece that before it by direction, which has the same face, or -1; (D, n).

    `number`, (n, D), are those of the parts of boxes. Those in several pieces have none.
    """
    found = np.full(number.T.shape, -1)
    if not len(number):
        return found
    number = number - number.min(axis=0) + 1
    extent = tuple((number.max(axis=0) + 1).tolist())
    key = np.ravel_multi_index(tuple(number.T), extent)
    order = np.argsort(key, kind="stable")
    keys = key[order]
    alone = np.ones(len(keys), bool)
    alone[1:] &= keys[1:] != keys[:-1]
    alone[:-1] &= keys[1:] != keys[:-1]
    keys, order = keys[alone], order[alone]
    if len(keys):
        for d in range(len(extent)):
            back = keys - int(np.prod(extent[d + 1 :]))
            at = np.minimum(np.searchsorted(keys, back), len(keys) - 1)
            there = keys[at] == back
            found[d, order[there]] = order[at[there]]
    return found


def _faces(
    body: LatticeBody, boxes: tuple[Reals, Reals, Reals], closed: Closed, count: int,
    before: Indices,
) -> list[list[tuple[Reals, Reals]]]:  # fmt: skip
    """Areas inside on faces of pieces, and their moments, (n,) and (n, m), by axis and side.

    `boxes` are low and high corners, and half the thickness of slabs round faces. Pieces have the
    low faces of those `before` them.
    """
    low, high, thin = boxes
    D, n = len(before), len(low)
    first = [np.flatnonzero(each < 0) for each in before]
    rows = np.concatenate([each for own in first for each in (np.arange(n), own)])
    ends = np.cumsum([0, *(n + len(own) for own in first)])
    a, b, across = low[rows], high[rows], np.repeat(np.arange(D), np.diff(ends))
    for d, (begin, end, own) in enumerate(zip(ends[:-1], ends[1:], first, strict=True)):
        at, half = np.concatenate([high[:, d], low[own, d]]), thin[rows[begin:end], d]
        a[begin:end, d], b[begin:end, d] = at - half, at + half
        if (d, -1) in closed:
            a[begin + n : end, d] = np.maximum(a[begin + n : end, d], body.edges[d][0])
        if (d, 1) in closed:
            b[begin : begin + n, d] = np.minimum(b[begin : begin + n, d], body.edges[d][-1])
    inside, moments = measure(body.region, a, b, count, across if body.exact else None)
    thickness = (b - a)[np.arange(len(a)), across]
    inside /= thickness
    moments /= thickness[:, None]
    found = []
    for begin, each, own in zip(ends[:-1].tolist(), before, first, strict=True):
        place = each + begin
        place[own] = begin + n + np.arange(len(own))
        upper = slice(begin, begin + n)
        found.append([(inside[place], moments[place]), (inside[upper], moments[upper])])
    return found


def cut_elements(
    body: LatticeBody, ranges: Sequence[Indices], closed: Closed, cuts: Sequence[Region]
) -> Elements:
    """Elements of a surface that cuts boxes; none of them crosses a plane of the regions `cuts`.

    On such planes each side of a box has an element of its own, so that edges have none.
    """
    D, box = len(ranges), _near_boxes(body, ranges)
    parts = _PARTS[D - 1]
    each = combinations([np.arange(parts)] * D)
    part = np.tile(each, (len(box), 1))
    box = np.repeat(box, len(each), axis=0)
    low, high = np.empty(box.shape), np.empty(box.shape)
    for d, e in enumerate(body.edges):
        a, b = edge(e, box[:, d]), edge(e, box[:, d] + 1)
        low[:, d] = a + part[:, d] / parts * (b - a)
        high[:, d] = np.where(part[:, d] + 1 < parts, a + (part[:, d] + 1) / parts * (b - a), b)
    near = np.flatnonzero(_near(body, low, high))
    box, low, high, number = box[near], low[near], high[near], parts * box[near] + part[near]
    thickness = _THINNER if body.exact else _THIN
    thin = 0.5 * thickness * (high - low)  # the same for pieces side by side
    for region in cuts:
        row, low, high = pieces(region, low, high)
        box, thin, number = box[row], thin[row], number[row]
    n, size, count = len(box), high - low, PRODUCTS[D - 1] if body.exact else 0
    area, moment = np.zeros((n, D)), np.zeros((n, D, D))
    second = np.zeros((n, PRODUCTS[D - 1], D))
    volume, inner = measure(body.region, low, high, count)
    full = size.prod(axis=1)
    whole = volume > (1.0 - _ROUNDING) * full
    # Pieces without a surface inside, but for their faces, have an element for each of these.
    plain = whole | (volume < _ROUNDING * full) if cuts else np.zeros(n, bool)
    flat = np.flatnonzero(plain)
    sides: list[tuple[Reals, Reals, Reals, int]] = []
    faces = _faces(body, (low, high, thin), closed, count, _before(number))
    for d in range(D):
        moment[:, d, d] += volume
        for side, (face, first) in zip((-1.0, 1.0), faces[d], strict=True):
            half_size = 0.5 * side * size[:, d]
            area[:, d] -= side * face
            arms = np.zeros((n, D))
            for j in range(D):
                arms[:, j] = half_size * face if j == d else first[:, j]
                moment[:, j, d] -= side * arms[:, j]
            more = np.zeros((n, PRODUCTS[D - 1]))
            for k, axes in enumerate(MONOMIALS[D - 1][1 + D : 1 + D + count]):
                if d not in axes:
                    more[:, k] = first[:, D + k]
                else:
                    rest = _column(axes, d)
                    more[:, k] = half_size * first[:, rest]
                    second[:, k, d] += 0.5 * inner[:, rest]  # once for each side
                second[:, k, d] -= side * more[:, k]
            if len(flat):
                missing = np.where(whole, full / size[:, d], 0.0) - face
                arms[:, d] -= side * 0.5 * np.where(whole, full, 0.0)
                of = (each[flat] for each in (missing, -side * arms, -side * more))
                sides.append(_side(d, side, *of))
    there = np.zeros(n, bool)
    for d in range(D):
        there |= np.abs(area[:, d]) > _LEAST * (full / size[:, d])
    found = Elements(box, 0.5 * (low + high), area, moment, 0.5 * size, second)
    if not len(flat):
        return found.chosen(there)
    every, flat_ones = [found.chosen(there & ~plain)], found.chosen(flat)
    for of_side, moments, seconds, d in sides:
        some = np.abs(of_side[:, d]) > _LEAST * (full[flat] / size[flat, d])
        own = flat_ones._replace(area=of_side, moment=moments, second=seconds)
        every.append(own.chosen(some))
    joined = Elements(*map(np.concatenate, zip(*every, strict=True)))
    return joined.chosen(ascending(joined.box))


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
