"""The closed surface of the ground below a grid of heights.

Each cell of the grid is four triangles, which meet in its middle at the mean of its corners'
heights. So the ground has the volume of bilinear interpolation, and is as symmetric as the heights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.mesh.cells import Facets
from pgimp.geometry.mesh.closed import enclose
from pgimp.geometry.mesh.tree import Surface, boxes_of, interleave
from pgimp.geometry.terrain.read import MOST_NODES, Heights

Reals = NDArray[np.float64]


def part_of(found: Heights, low: Sequence[float] | None, high: Sequence[float] | None) -> Heights:
    """Return the part of heights from `low` to `high`, linear between nodes.

    Raises
    ------
    CaseError
        If they do not cover it, or a node around an end of the part has no height.
    """
    axes, values = list(found.axes), found.values
    around = []
    for d, places in enumerate(found.axes):
        begin = places[0] if low is None else low[d]
        end = places[-1] if high is None else high[d]
        slack = 1e-9 * (places[-1] - places[0])
        if begin < places[0] - slack or end > places[-1] + slack:
            raise CaseError(
                f"covers {'xy'[d]} from {places[0]:.10g} to {places[-1]:.10g} (its nodes, of an "
                f".asc the edges of its cells), but the part goes from {begin:.10g} to {end:.10g}"
            )
        begin, end = max(begin, places[0]), min(end, places[-1])
        first = int(np.searchsorted(places, begin, "right")) - 1
        last = int(np.searchsorted(places, end, "left"))
        around.append(slice(first, last + 1))
        inner = places[(places > begin + slack) & (places < end - slack)]
        axes[d] = np.concatenate([[begin], inner, [end]])
        values = _between(places, values, axes[d], d)
    if not np.isfinite(values).all():  # named are nodes of the file, not ends between them
        named = tuple(places[one] for places, one in zip(found.axes, around, strict=True))
        _require_known(Heights(named, found.values[tuple(around)]))
    return Heights(tuple(axes), values)


def _between(places: Reals, values: Reals, at: Reals, axis: int) -> Reals:
    """Interpolate linearly along an axis; exact at nodes."""
    right = np.clip(np.searchsorted(places, at), 1, len(places) - 1)
    part = (at - places[right - 1]) / (places[right] - places[right - 1])
    shape = [1] * values.ndim
    shape[axis] = -1
    part = part.reshape(shape)
    left_values, right_values = (np.take(values, i, axis) for i in (right - 1, right))
    with np.errstate(invalid="ignore"):
        mixed = left_values + part * (right_values - left_values)
    return np.where(part == 0.0, left_values, np.where(part == 1.0, right_values, mixed))


def require_heights(found: Heights, bottom: float) -> None:
    """Ensure that every node has a height above the bottom.

    Raises
    ------
    CaseError
        Otherwise, with the number of nodes and the first of them.
    """
    if found.values.size > MOST_NODES:
        raise CaseError(
            f"has {found.values.size:,} nodes in this part, more than {MOST_NODES:,}; take a "
            "smaller part, or every other node"
        )
    _require_known(found)
    low = found.values <= bottom
    if low.any():
        raise CaseError(
            f"is at or below the bottom, {bottom:.10g}, at {int(low.sum()):,} of {low.size:,} "
            f"nodes, first at {_place(found, low)}; the lowest is {found.values.min():.10g}"
        )


def _require_known(found: Heights) -> None:
    """Refuse nodes without a height."""
    missing = ~np.isfinite(found.values)
    if missing.any():
        raise CaseError(
            f"has no height at {int(missing.sum()):,} of {missing.size:,} nodes, first at "
            f"{_place(found, missing)}: fill them, or take a part without them (part: {{min: .., "
            "max: ..})"
        )


def _place(found: Heights, which: NDArray[np.bool_]) -> str:
    first = np.argwhere(which)[0]
    pairs = zip("xy", found.axes, first, strict=False)
    return ", ".join(f"{axis} = {places[i]:.10g}" for axis, places, i in pairs)


def ground_below(found: Heights, bottom: float) -> Surface:
    """Return the closed surface of the ground between heights and a bottom.

    Raises
    ------
    CaseError
        See `require_heights`.
    """
    require_heights(found, bottom)
    if found.values.ndim == 1:
        points, facets = _line(found, bottom)
        return enclose(Facets(points, facets, np.full(len(facets), -1), False, []))
    return _field(found, bottom)


def _line(found: Heights, bottom: float) -> tuple[Reals, NDArray[np.int64]]:
    """Return an outline: along the profile, and back along the bottom."""
    x = found.axes[0]
    ends = [[x[-1], bottom], [x[0], bottom]]
    points = np.vstack([np.column_stack([x, found.values]), ends])
    number = np.arange(len(points))
    return points, np.column_stack([np.roll(number, -1), number])


def _field(found: Heights, bottom: float) -> Surface:
    """Return triangles, outwards: four to a cell on top, two to an edge of the sides and below.

    They are closed by construction, so that nothing has to be searched. Below, the sides' corners
    lie on edges of two triangles. Along the axes these edges have no shadow, so no line can pass.
    """
    (x, y), z = found.axes, found.values
    n, m = z.shape
    i, j = (each.ravel() for each in np.meshgrid(np.arange(n - 1), np.arange(m - 1), indexing="ij"))
    # Near cells follow each other; those of one are a leaf of the tree.
    near = np.stack([i, j, np.zeros_like(i)], axis=1).astype(np.uint64)
    order = np.argsort(interleave(near), kind="stable")
    i, j = i[order], j[order]
    sides = 2 * (n + m - 2)
    triangles = np.empty((4 * len(i) + 2 * sides + 2, 3, 3))
    cells = triangles[: 4 * len(i)].reshape(-1, 4, 3, 3)
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    for k, (a, b) in enumerate(corners):
        for axis, values in enumerate((x[a], y[b], z[a, b])):
            cells[:, k, 0, axis] = cells[:, k - 1, 1, axis] = values
    cells[:, :, 2] = (0.25 * cells[:, :, 0].sum(axis=1))[:, None]
    # The nodes round the edge, anticlockwise, and what lies below them.
    nodes = np.stack([*np.meshgrid(x, y, indexing="ij"), z], axis=2)
    edge = np.concatenate([nodes[:-1, 0], nodes[-1, :-1], nodes[:0:-1, -1], nodes[0, :0:-1]])
    foot = np.column_stack([edge[:, :2], np.full(len(edge), bottom)])
    next_edge, next_foot = np.roll(edge, -1, axis=0), np.roll(foot, -1, axis=0)
    around = triangles[4 * len(i) : -2].reshape(-1, 2, 3, 3)
    around[:, 0] = np.stack([edge, foot, next_foot], axis=1)
    around[:, 1] = np.stack([edge, next_foot, next_edge], axis=1)
    low, high = (x[0], y[0], bottom), (x[-1], y[-1], bottom)
    triangles[-2:] = [[low, (x[0], y[-1], bottom), high], [low, high, (x[-1], y[0], bottom)]]
    one = np.zeros(len(triangles), np.int64)
    return Surface(triangles, one, *boxes_of(triangles), 3, facets=len(triangles))
