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
from pgimp.geometry.terrain.read import Heights

Reals = NDArray[np.float64]

#: Most nodes of a surface: each has four triangles, of some 300 bytes.
MOST_NODES = 1_000_000


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
                f"covers {'xy'[d]} from {places[0]:.10g} to {places[-1]:.10g} (its first and last "
                f"node), but the part goes from {begin:.10g} to {end:.10g}"
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


def ground_below(found: Heights, bottom: float) -> Facets:
    """Return the surface of the ground between heights and a bottom.

    Raises
    ------
    CaseError
        See `require_heights`.
    """
    require_heights(found, bottom)
    points, facets = (_line if found.values.ndim == 1 else _field)(found, bottom)
    return Facets(points, facets, np.full(len(facets), -1), False, [])


def _line(found: Heights, bottom: float) -> tuple[Reals, NDArray[np.int64]]:
    """Return an outline: along the profile, and back along the bottom."""
    x = found.axes[0]
    ends = [[x[-1], bottom], [x[0], bottom]]
    points = np.vstack([np.column_stack([x, found.values]), ends])
    number = np.arange(len(points))
    return points, np.column_stack([np.roll(number, -1), number])


def _field(found: Heights, bottom: float) -> tuple[Reals, NDArray[np.int64]]:
    """Return triangles: four to a cell on top, two to an edge of the sides, one on the bottom."""
    (x, y), z = found.axes, found.values
    n, m = z.shape
    X, Y = np.meshgrid(x, y, indexing="ij")
    nodes = np.column_stack([X.ravel(), Y.ravel(), z.ravel()])
    number = np.arange(n * m).reshape(n, m)
    corners = [part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:],
                                         number[:-1, 1:])]  # fmt: skip
    middles = 0.25 * (nodes[corners[0]] + nodes[corners[1]] + nodes[corners[2]] + nodes[corners[3]])
    middle = n * m + np.arange(len(middles))
    top = [np.column_stack([corners[k], corners[(k + 1) % 4], middle]) for k in range(4)]
    # The nodes round the edge, anticlockwise, and what lies below them.
    edge = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    below = nodes[edge].copy()
    below[:, 2] = bottom
    first = n * m + len(middles)
    foot = first + np.arange(len(edge))
    next_edge, next_foot = np.roll(edge, -1), np.roll(foot, -1)
    centre = np.array([[0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1]), bottom]])
    last = first + len(edge)
    sides = [
        np.column_stack([edge, foot, next_foot]),
        np.column_stack([edge, next_foot, next_edge]),
        np.column_stack([next_foot, foot, np.full(len(edge), last)]),
    ]
    return np.vstack([nodes, middles, below, centre]), np.vstack([*top, *sides])
