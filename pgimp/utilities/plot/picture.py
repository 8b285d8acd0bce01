"""Pictures of frames: particles with position and size, coloured by a field."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.io.results.reader import Frame
from pgimp.utilities.plot.camera import Camera, compass, name_axes
from pgimp.utilities.plot.contours.bodies import DrawnBody, bodies_of, refuse
from pgimp.utilities.plot.contours.drawing import (
    draw_contours,
    draw_outline,
    levels,
    rows_within,
    values_within,
)
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.rigid import draw_lines, lines, widened
from pgimp.utilities.plot.runs import AXES, PlotFrame
from pgimp.utilities.plot.selection import Block, Selection, empty
from pgimp.utilities.plot.style import plain
from pgimp.utilities.plot.tables import Table
from pgimp.utilities.plot.visible import draw, extent, visible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = np.ndarray

_WIDTH, _ONE_WIDTH = 9.0, 6.4
_TALLEST = 8.0
_FLAT = 1.3
#: Height over width of pictures that are below each other, and their greatest number.
_WIDE, _MOST_BELOW = 0.45, 4
_OUTLIERS = (0.5, 99.5)
_ROOM = 0.25
_LITTLE = 0.02
_NAMES: dict[str, Callable[[Frame], list[str]]] = {
    "body": lambda frame: frame.bodies,
    "material": lambda frame: frame.materials,
}
_SHAPELESS = "outlines of undeformed particles: output.fields has no deformation"
_WHOLE = ("body", "material", "rank", "id")
_MOST_NAMES = 12


class _Shown(NamedTuple):
    """What a picture shows: a frame's particles, or none, its bodies, and nets of rigid ones."""

    snapshot: PlotFrame
    seen: Block | None
    bodies: list[DrawnBody]
    net: Array


def picture(
    snapshots: Sequence[PlotFrame],
    quantities: Sequence[Quantity],
    selection: Selection,
    camera: Camera,
    look: Look = Look(),
) -> tuple[Figure, Table, list[str]]:
    """Draw frames side by side, with a common colour scale.

    Parameters
    ----------
    quantities : sequence of Quantity
        Quantity of each frame.
    selection : Selection
        Particles to draw.
    look : Look
        Its looks. The colours' range is by default that of the drawn particles. Half a per cent at
        an end is left out if it would widen it by more than a quarter.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    table : Table
        Data of the figure.
    remarks : list of str
        Remarks on omitted data.

    Raises
    ------
    UsageError
        If there is no such particle.
    """
    dimension = snapshots[0].shown.dimension
    if look.contours or look.outline:
        what = quantities[0].text if look.contours else ""
        refuse(snapshots[0].shown, selection, camera, what)
    extents = extents_of(snapshots, selection, camera)
    inside = np.array([extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)])
    inside = inside if look.inside is None else look.inside
    places = [camera.axis(side)[0] for side in (camera.right, camera.up)] if look.contours else []
    columns = ["body", *places] if look.contours else ["id", *AXES[:dimension], "radius"]
    table = Table(["run", "frame", "time", *columns, quantities[0].text])
    shown, remarks = [], []
    for snapshot, quantity in zip(snapshots, quantities, strict=True):
        same = [snapshot.shown.name, snapshot.frame.number, snapshot.frame.time]
        net, bodies = lines(snapshot.frame, camera, selection.angles, selection.mirrored), []
        if look.contours or look.outline:
            field = look.contours > 0
            bodies = bodies_of(snapshot, selection, quantity, camera, field=field)
            if "deformation" not in snapshot.frame:
                remarks.append(f"{snapshot.frame.path}: {_SHAPELESS}")
        if look.contours:
            shown.append(_Shown(snapshot, None, bodies, net))
            for body in bodies:
                table.add([*same, body.name], list(rows_within(body, camera)))
            continue
        seen, total = visible(snapshot.frame, selection, quantity, camera, inside)
        shown.append(_Shown(snapshot, seen, bodies, net))
        if len(seen.id) < total:
            remarks.append(
                f"{snapshot.frame.path}: {len(seen.id):,} of {total:,} particles drawn, in each "
                "spot of the picture the foremost"
            )
        part = seen.take(np.argsort(seen.id))
        table.add(same, [part.id, *part.position[:, :dimension].T, part.radius, part.value])
    inside = widened(inside, [one.net for one in shown])
    flat = dimension < 3 and not selection.angles
    figure = _draw(shown, quantities[0], camera, inside, look, flat=flat)
    return figure, table, remarks


def extents_of(snapshots: Sequence[PlotFrame], selection: Selection, camera: Camera) -> Array:
    """Return the corners of the particles' extent in each picture, (n, 2, 2).

    Raises
    ------
    UsageError
        If a frame has no such particle.
    """
    extents = np.array([extent(snapshot.frame, selection, camera) for snapshot in snapshots])
    for snapshot, (low, high) in zip(snapshots, extents, strict=True):
        if not (low <= high).all():
            raise empty(snapshot.frame, selection.place)
    return extents


def scale(values: Array, limits: tuple[float, float] | None) -> tuple[float, float, str]:
    """Return the ends of the colour scale, and the ends that values exceed.

    Parameters
    ----------
    values : ndarray, shape (n,)
        All drawn values.
    limits : tuple of float, or None
        The ends, if prescribed.

    Returns
    -------
    low, high : float
        The ends.
    extend : str
        ``neither``, ``min``, ``max`` or ``both``.
    """
    values = values[np.isfinite(values)]
    if not len(values):
        values = np.zeros(1)
    low, high = float(values.min()), float(values.max())
    if limits is None:
        inner = [float(end) for end in np.percentile(values, _OUTLIERS)]
        room = _ROOM * (inner[1] - inner[0])
        if room > 0.0:
            low = low if inner[0] - low <= room else inner[0]
            high = high if high - inner[1] <= room else inner[1]
        if low == high:
            low, high = low - 0.05 * abs(low), high + (0.05 * abs(high) or 1.0)
    else:
        low, high = limits
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max"}
    return low, high, ends.get((bool(values.min() < low), bool(values.max() > high)), "both")


def _draw(
    shown: Sequence[_Shown],
    quantity: Quantity,
    camera: Camera,
    inside: Array,
    look: Look,
    *,
    flat: bool,
) -> Figure:
    """Draw each frame with its particles or bodies, and the nets of its rigid bodies."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, Normalize
    from matplotlib.ticker import MaxNLocator

    snapshots = [one.snapshot for one in shown]
    fields = [one.seen.value if one.seen else values_within(one.bodies) for one in shown]
    values = np.concatenate(fields)
    low, high, beyond = scale(values, look.limits)
    shades = colormaps[look.map].with_extremes(bad="#c8c8c8")
    colours = ScalarMappable(Normalize(low, high), shades)
    ends = np.zeros(0)
    if look.contours:
        ends = levels(low, high, look.contours, exact=look.limits is not None)
        low, high = ends[0], ends[-1]
        room = _LITTLE * (high - low)  # planes go on beyond the outermost particles
        beyond = scale(values, (low - room, high + room))[2]
        colours = ScalarMappable(BoundaryNorm(ends, shades.N), shades)
    size = inside[1] - inside[0]
    columns = look.panels or columns_of(len(snapshots), size)
    wide = size[0] * min(columns, 2) > _FLAT * size[1]
    figure, axes = _panels((len(snapshots), columns), size, wide, camera.along_axes, look.width)
    (left, bottom), (right, top) = inside + 0.03 * size.max() * np.array([[-1.0], [1.0]])
    several = len({snapshot.shown.name for snapshot in snapshots}) > 1
    for number, ((snapshot, seen, bodies, net), axis) in enumerate(zip(shown, axes, strict=False)):
        if seen is not None:
            rgba = colours.to_rgba(np.ma.masked_invalid(seen.value))
            draw(axis, camera, seen, rgba, flat)
        for body in bodies:
            if seen is None:
                draw_contours(axis, body, colours, ends)
            draw_outline(axis, body)
        if len(net):
            draw_lines(axis, net, flat)
        axis.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        name = f"{plain(snapshot.shown.name)}, " if several else ""
        title = look.title if look.title and len(shown) == 1 else name + snapshot.title
        axis.set_title(title, fontsize="medium")
        axis.grid(False)
        columns = axis.get_subplotspec().get_gridspec().ncols
        name_axes(axis, snapshot, camera, columns, lowest=number + columns >= len(snapshots))
        if number == 0 and not camera.along_axes:
            compass(axis, camera)
    for axis in axes[len(snapshots) :]:
        axis.set_visible(False)
    if look.title and len(shown) > 1:
        figure.suptitle(look.title, fontsize="large")
    bar = figure.colorbar(
        colours,
        ax=list(axes),
        label=snapshots[0].shown.label(quantity.label, quantity.kind),
        extend=beyond,
        location="bottom" if wide else "right",
        shrink=0.7 if wide else 0.85,
        aspect=40 if wide else 25,
    )
    bar.outline.set_linewidth(0.6)
    names = _NAMES.get(quantity.text, lambda _: [])(snapshots[0].frame)
    named = [number for number in range(len(names)) if low <= number <= high]
    if 0 < len(named) <= _MOST_NAMES:
        bar.set_ticks(named, labels=[plain(names[number]) for number in named])
    elif quantity.text in _WHOLE:
        bar.locator = MaxNLocator(integer=True)
        bar.update_ticks()
    return figure


def columns_of(count: int, size: Array) -> int:
    """Return the number of pictures side by side; wide ones are below each other."""
    ratio = float(size[1] / size[0])
    if ratio < _WIDE and count <= _MOST_BELOW:
        return 1
    return count if count <= 3 else int(np.ceil(count / np.ceil(count / 4)))


def _panels(
    count: tuple[int, int], size: Array, wide: bool, labelled: bool, width: float
) -> tuple[Figure, Array]:
    """Return a figure with axes for pictures of this size.

    `count` is the number of pictures, and of those side by side. The colour scale is below them if
    they are `wide`, else to their right; only `labelled` axes have ticks. `width` is in inches, or
    0.
    """
    from matplotlib.figure import Figure

    ratio = float(np.clip(size[1] / size[0], 0.12, 3.0))
    columns = min(count[1], count[0])
    rows = -(-count[0] // columns)
    chosen = width or (_ONE_WIDTH if columns == 1 else _WIDTH)
    room = (0.9 if wide else 0.72) * chosen / columns
    height = room * ratio * rows + 0.45 * rows + (1.3 if wide else 0.4)
    height -= 0.0 if labelled else 0.4
    if width:
        height = max(height, 0.5)
    elif height > _TALLEST:
        chosen, height = max(3.6, chosen * _TALLEST / height), _TALLEST
    width = chosen
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    return figure, axes.ravel()
