"""Contours and outlines of bodies in the axes of a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.contours.bodies import DrawnBody

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.path import Path

Array = np.ndarray

_EDGE, _WIDTH = "#222222", 0.8
#: Fewest colours of those who ask for as many.
_MIN_COLOURS = 12


def levels(low: float, high: float, count: int, *, exact: bool) -> Array:
    """Return the ends of the colours: equal parts, or about as many between round numbers.

    From 12 on there are 12 of them at least.
    """
    from matplotlib.ticker import MaxNLocator

    if exact:
        return np.linspace(low, high, count + 1)
    least = _MIN_COLOURS if count >= _MIN_COLOURS else 0
    for most in range(count, 4 * count):
        found = np.asarray(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
        if len(found) > least:
            break
    return found


def values_within(bodies: Sequence[DrawnBody]) -> Array:
    """Return the values of the fields within the outlines."""
    return np.concatenate([np.zeros(0), *(body.values[_inside(body)] for body in bodies)])


def rows_within(body: DrawnBody, camera: Camera) -> tuple[Array, Array, Array]:
    """Return coordinates along the picture's axes, and the field, at points within the outline."""
    x, y = np.meshgrid(body.points.x, body.points.y)
    if camera.axis(camera.right)[1]:
        x = -x
    inside = _inside(body)
    return x[inside], y[inside], body.values[inside]


def _inside(body: DrawnBody) -> Array:
    """Return which points are within the outline, (rows, columns)."""
    x, y = np.meshgrid(body.points.x, body.points.y)
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    inside = np.zeros(len(points), bool)
    for path in _paths(body):
        within = np.zeros(len(points), bool)
        for ring in path.to_polygons():
            within ^= type(path)(ring).contains_points(points)
        inside |= within
    return inside.reshape(body.points.shape) & np.isfinite(body.values)


def _paths(body: DrawnBody) -> list[Path]:
    from matplotlib.path import Path

    found = []
    for points, ends in body.outline.areas:
        codes = np.full(len(points), Path.LINETO, Path.code_type)
        codes[ends[:-1]] = Path.MOVETO
        codes[np.asarray(ends[1:]) - 1] = Path.CLOSEPOLY
        found.append(Path(points, codes))
    return found


def draw_contours(axis: Axes, body: DrawnBody, colours: ScalarMappable, ends: Array) -> None:
    """Add a body's field, cut off at its outline; grey where there is no number.

    `ends` are those of the colours, which `colours` knows too.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    paths = _paths(body)
    if not paths:
        return
    whole = Path.make_compound_path(*paths)
    axis.add_patch(PathPatch(whole, facecolor=colours.cmap.get_bad(), lw=0.0))
    values = np.ma.masked_invalid(body.values)
    if values.mask.all():
        return
    shown = axis.contourf(
        body.points.x,
        body.points.y,
        values,
        levels=ends,
        cmap=colours.cmap,
        norm=colours.norm,
        extend="both",
    )
    shown.set_edgecolor("face")  # hides hairlines between colours
    shown.set_linewidth(0.2)
    shown.set_clip_path(whole, axis.transData)


def draw_outline(axis: Axes, body: DrawnBody) -> None:
    """Add a body's outline."""
    from matplotlib.collections import LineCollection

    axis.add_collection(LineCollection(body.outline.lines, colors=_EDGE, linewidths=_WIDTH))
