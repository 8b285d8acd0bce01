"""Volume and moments of the part of a box that lies in a region (3, 4).

A box is cut along the planes of the region's surface (`Region.planes`). Pieces that no curved
surface meets lie inside or outside as a whole. For boxes, their unions and differences the result
is exact to rounding. Other pieces are integrated direction by direction. Along the direction most
normal to the surface, the length of the part inside is exact. Over the other directions Gauss's
rule is used between the points where the surface leaves through the piece's edges, so that the
integrand is smooth. Flat cuts at any angle are exact as well, also where several meet within a box:
there the box is cut too, see `pgimp.geometry.flatcuts`.

Every box is computed separately, in a fixed order of operations. Neither the other boxes of a call
nor their number changes a bit.
"""

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.flatcuts import corners
from pgimp.geometry.regions.base import Points, Region

Reals = NDArray[np.float64]
Rows = NDArray[np.int64]

#: Gauss's rule on [0, 1] over each smooth stretch. With two points it is exact for flat cuts, whose
#: integrands are cubics at most, moments included. A curved surface leaves an error of fourth
#: order: for the volume of a ball of radius 2 boxes 2e-4, of radius 16 boxes 7e-8.
_TWO = (0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)), (0.5, 0.5)

#: Likewise with products of inertia, whose integrands have two degrees more.
_THREE = (0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)), (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)

#: The middle, of stretches that lie inside or outside as a whole.
_ONE = (0.5,), (1.0,)

#: Directions of the coordinates that each integral multiplies, by dimensions. The last two in 2D
#: are for rings.
MONOMIALS: tuple[tuple[tuple[int, ...], ...], ...] = (
    ((), (0,)),
    ((), (0,), (1,), (0, 1), (0, 0), (0, 0, 1)),
    ((), (0,), (1,), (2,), (1, 2), (0, 2), (0, 1), (0, 1, 2)),
)

#: Boxes per block; lines per block, times the number of parts of the region.
_BATCH, _CROSSINGS = 16384, 1_000_000

#: Most surfaces in one box along a direction, and most pieces of a box. With more, the region's
#: parts are far smaller than the box, and the measurement would take hours.
_MOST_CUTS, _MOST_PIECES = 48, 2_000


class TangledError(Exception):
    """Too many surfaces meet in one box."""

    def __init__(self) -> None:
        super().__init__(
            "has more surfaces in one particle's box than can be told apart there; use fewer and "
            "larger parts, smaller cells (grid.cell) or surface: whole-particles"
        )


def measure(
    region: Region, low: Points, high: Points, products: int = 0, across: Rows | None = None
) -> tuple[Reals, Reals]:
    """Measure the parts of boxes that lie in a region.

    Parameters
    ----------
    low, high : ndarray of float64, shape (n, D)
        Corners of the boxes.
    products : int
        Number of products of inertia to measure, too.
    across : (n,) int64, optional
        Direction in which each box is thin: its parts are as in the middle of pieces between
        planes, and what has moments along it is not measured.

    Returns
    -------
    volume : ndarray of float64, shape (n,)
    moment : ndarray of float64, shape (n, D + products)
        Integral over the part of the position relative to the box's centre. With `products` also
        those of its components' products: xy, then xx, xxy in 2D; yz, xz, xy, xyz in 3D.

    Raises
    ------
    TangledError
        If the region has too many surfaces in one of the boxes.
    """
    n, D = low.shape
    width = 1 + D + products
    total = np.zeros((n, width))
    for begin in range(0, n, _BATCH):
        part = slice(begin, begin + _BATCH)
        centre = 0.5 * (low[part] + high[part])
        rows, a, b = pieces(region, low[part], high[part])
        thin = None if across is None else across[part][rows]
        found = _piece(region, a, b, centre[rows], width, thin)
        if np.array_equal(rows, np.arange(len(centre))):
            total[part] = found
        else:
            _add(total[part], rows, found)
    return total[:, 0], total[:, 1:]


def _add(total: Reals, rows: Rows, parts: Reals) -> None:
    """Add parts to rows of a total, one after the other."""
    for column in range(total.shape[1]):
        np.add.at(total[:, column], rows, parts[:, column])


def pieces(region: Region, low: Points, high: Points) -> tuple[Rows, Points, Points]:
    """Cut boxes along the planes: for each piece the row of its box, ascending, and its corners."""
    cuts, met = _cuts(region, low, high), np.zeros(len(low), bool)
    for rows, _ in cuts:
        met[rows] = True
    alone = np.flatnonzero(~met & (low < high).all(axis=1))
    some = np.flatnonzero(met)
    if not len(some):
        return alone, low[alone], high[alone]
    cuts = [(np.searchsorted(some, rows), at) for rows, at in cuts]
    row, a, b = _parted(low[some], high[some], cuts)
    rows = np.concatenate([alone, some[row]])
    order = np.argsort(rows, kind="stable")
    a, b = np.concatenate([low[alone], a])[order], np.concatenate([high[alone], b])[order]
    return rows[order], a, b


def _cuts(region: Region, low: Points, high: Points) -> list[tuple[Rows, Reals]]:
    """By axis the rows of boxes that planes cut, and where, as often as there are such planes."""
    D = low.shape[1]
    found: list[list[tuple[Rows, Reals]]] = [
        [(np.zeros(0, np.int64), np.zeros(0))] for _ in range(D)
    ]
    least, most = low.min(axis=0, initial=np.inf), high.max(axis=0, initial=-np.inf)
    for plane in region.planes():
        axis, at = plane.axis, plane.at
        if not least[axis] < at < most[axis]:
            continue
        rows = np.flatnonzero((low[:, axis] < at) & (at < high[:, axis]))
        for d in range(D):
            if len(rows) and d != axis:
                meets = (low[rows, d] <= plane.high[d]) & (plane.low[d] <= high[rows, d])
                rows = rows[meets]
        found[axis].append((rows, np.full(len(rows), at)))
    return [
        (np.concatenate(rows), np.concatenate(at))
        for rows, at in (zip(*e, strict=True) for e in found)
    ]


def _parted(
    low: Points, high: Points, cuts: list[tuple[Rows, Reals]]
) -> tuple[Rows, Points, Points]:
    """See `pieces`, for cuts by axis."""
    n, D = low.shape
    stretches, counts = [], []
    for axis, cut in enumerate(cuts):
        stretches.append(_stretches(low[:, axis], high[:, axis], *cut))
        counts.append(np.bincount(stretches[-1][0], minlength=n))
    many = np.prod(counts, axis=0)
    if many.max(initial=0) > _MOST_PIECES:
        raise TangledError
    row = np.repeat(np.arange(n), many)
    number = np.arange(len(row)) - np.repeat(np.cumsum(many) - many, many)
    a, b = np.empty((len(row), D)), np.empty((len(row), D))
    for axis in reversed(range(D)):
        number, along = np.divmod(number, counts[axis][row])
        place = (np.cumsum(counts[axis]) - counts[axis])[row] + along
        a[:, axis], b[:, axis] = stretches[axis][1][place], stretches[axis][2][place]
    return row, a, b


def _stretches(low: Reals, high: Reals, rows: Rows, cuts: Reals) -> tuple[Rows, Reals, Reals]:
    """Intervals of the rows from `low` to `high`, cut at `cuts`: rows, ascending, and both ends.

    The cuts of a row, in any order and some of them twice, lie between its ends.
    """
    every = np.flatnonzero(low < high)
    if not len(rows):
        return every, low[every], high[every]
    rows = np.concatenate([every, rows, every])
    ends = np.concatenate([low[every], cuts, high[every]])
    order = np.lexsort((ends, rows))
    rows, ends = rows[order], ends[order]
    starts = np.flatnonzero((rows[1:] == rows[:-1]) & (ends[:-1] < ends[1:]))
    return rows[starts], ends[starts], ends[starts + 1]


def _piece(
    region: Region, low: Points, high: Points, centre: Points, width: int, across: Rows | None
) -> Reals:
    """Volume and moments about `centre` of pieces without cuts by planes, (n, width)."""
    n, D = low.shape
    middle, size = 0.5 * (low + high), high - low
    total = np.zeros((n, width))
    square = np.zeros(n)
    for d in range(D):
        square += size[:, d] * size[:, d]
    uniform = (region.curved(middle) >= 0.5 * np.sqrt(square)) | (across is not None and D == 1)
    whole = np.flatnonzero(uniform)
    whole = whole[region.contains(middle[whole])]
    volume = np.ones(len(whole))
    for d in range(D):
        volume *= size[whole, d]
    for column, axes in enumerate(MONOMIALS[D - 1][:width]):
        total[whole, column] = volume
        for d in sorted({*axes}):
            arm = middle[whole, d] - centre[whole, d]
            total[whole, column] *= (
                arm if axes.count(d) == 1 else arm * arm + size[whole, d] ** 2 / 12.0
            )
    rest = np.flatnonzero(~uniform)
    if len(rest) == 0:
        return total
    if across is not None and D == 2:  # lines have the other direction
        steep = np.zeros((len(rest), D))
    else:
        steep = _steepness(region, middle[rest], size[rest])
    if across is not None:
        steep[np.arange(len(rest)), across[rest]] = -1.0
    order = np.argsort(steep, axis=1, kind="stable")  # the line's direction comes last
    last = order[:, -1] + D * order[:, 0]
    for axes in permutations(range(D)):
        rows = rest[last == axes[-1] + D * axes[0]]
        if not len(rows):
            continue
        along = axes if across is None else axes[1:]
        total[rows] = _integrate(region, middle[rows], rows, (low, high, centre), along, width)
        if across is not None:
            total[rows] *= size[rows, axes[0], None]
    return total


def _steepness(region: Region, middle: Points, size: Points) -> Reals:
    """Slope, in each direction, of the curved surface nearest to each piece, in amount, (n, D).

    Only the distance from the curved part counts, not the planes that end the pieces.
    """
    steep, nearest = np.zeros_like(middle), np.full(len(middle), np.inf)
    for part in region.simple():
        gap = part.curved(middle)
        rows = np.flatnonzero(gap < nearest)
        nearest[rows], points = gap[rows], middle[rows]
        for d in range(middle.shape[1]):
            ends, own, side = [], points[:, d].copy(), size[rows, d]
            for away in (-0.25, 0.25):
                points[:, d] = own + away * side
                ends.append(part.distance(points))
            points[:, d] = own
            steep[rows, d] = np.abs(ends[1] - ends[0]) / side
    return steep


def _integrate(
    region: Region,
    points: Points,
    row: Rows,
    boxes: tuple[Points, Points, Points],
    axes: tuple[int, ...],
    columns: int,
) -> Reals:
    """Integrals over the directions `axes`, the others fixed at `points`; (n, columns).

    `row` are the points' rows in `boxes`: their low and high corners, and centres.
    """
    from pgimp.geometry.lines import add_nodes, add_stretches, cut_lines, set_nodes

    n, D = points.shape
    most = max(1, _CROSSINGS // region.parts)
    if n > most:
        few = [slice(begin, begin + most) for begin in range(0, n, most)]
        return np.concatenate(
            [_integrate(region, points[i], row[i], boxes, axes, columns) for i in few]
        )
    axis, inner = axes[0], axes[1:]
    crossings = []
    for corner in np.ndindex(*(2,) * len(inner)):
        edge = points.copy() if inner else points
        for d, end in zip(inner, corner, strict=True):
            edge[:, d] = boxes[end][row, d]
        crossings.append(region.crossings(edge, axis))
    every = np.concatenate(crossings, axis=1)
    more, cut = np.zeros(0, np.int64), np.zeros(0)
    if inner and (found := [*corners(region, points, boxes[:2], row, axes)]):
        more, cut = (np.concatenate(each) for each in zip(*found, strict=True))
        order = np.argsort(more, kind="stable")
        more, cut = more[order], cut[order]
    room = n * (1 + every.shape[1]) + len(more)
    of, left, right = np.empty(room, np.int64), np.empty(room), np.empty(room)
    scratch = np.empty(2 + every.shape[1] + len(more))
    count, many = cut_lines(boxes, row, axis, every, (more, cut), scratch, (of, left, right))
    if many > _MOST_CUTS:
        raise TangledError
    stretches = of[:count], left[:count], right[:count]
    rule = (_TWO if columns == 1 + D else _THREE) if inner else _ONE
    at, total = np.empty((count * len(rule[0]), D)), np.zeros((n, columns))
    set_nodes(points, *stretches, axis, np.array(rule[0]), at)
    monomials, lines = MONOMIALS[D - 1][:columns], (row, boxes[2], axis)
    if inner:
        nodes = np.repeat(row[stretches[0]], len(rule[0]))
        parts = _integrate(region, at, nodes, boxes, inner, columns)
        powers = np.array([each.count(axis) for each in monomials])
        others = [monomials.index(tuple(d for d in each if d != axis)) for each in monomials]
        weights, columns_of = np.array(rule[1]), (powers, np.array(others))
        add_nodes(stretches, weights, at, lines, columns_of, parts, total)
    else:
        second = monomials.index((axis, axis)) if (axis, axis) in monomials else -1
        add_stretches(stretches, region.contains(at), at, lines, (1 + axis, second), total)
    return total
