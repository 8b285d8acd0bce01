"""Pictures of frames: particles with position and size, coloured by a field."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.io.results.reader import Frame
from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.rigid import draw_lines, lines, widened
from pgimp.utilities.plot.runs import AXES, PlotFrame
from pgimp.utilities.plot.selection import Block, Selection, empty
from pgimp.utilities.plot.style import plain
from pgimp.utilities.plot.tables import Table
from pgimp.utilities.plot.visible import draw, extent, visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray

_WIDTH, _ONE_WIDTH = 9.0, 6.4
_TALLEST = 8.0
_FLAT = 1.3
#: Height over width of pictures that are below each other, and their greatest number.
_WIDE, _MOST_BELOW = 0.45, 4
_OUTLIERS = (0.5, 99.5)
_ROOM = 0.25
_ARROW = 24.0
_NAMES: dict[str, Callable[[Frame], list[str]]] = {
    "body": lambda frame: frame.bodies,
    "material": lambda frame: frame.materials,
}
_WHOLE = ("body", "material", "rank", "id")
_MOST_NAMES = 12


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
    snapshots : sequence of PlotFrame
        The frames.
    quantities : sequence of Quantity
        Quantity of each frame.
    selection : Selection
        Particles to draw.
    camera : Camera
        The projection.
    look : Look
        Its looks. The colours' range is by default that of the drawn particles, without half a per
        cent at an end that would widen it by more than a quarter.

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
    extents = extents_of(snapshots, selection, camera)
    inside = np.array([extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)])
    inside = inside if look.inside is None else look.inside
    table = Table(["run", "frame", "time", "id", *AXES[:dimension], "radius", quantities[0].text])
    drawn, remarks = [], []
    for snapshot, quantity in zip(snapshots, quantities, strict=True):
        seen, total = visible(snapshot.frame, selection, quantity, camera, inside)
        drawn.append(seen)
        if len(seen.id) < total:
            remarks.append(
                f"{snapshot.frame.path}: {len(seen.id):,} of {total:,} particles drawn, in each "
                "spot of the picture the foremost"
            )
        part = seen.take(np.argsort(seen.id))
        place = part.position[:, :dimension].T
        table.add(
            [snapshot.shown.name, snapshot.frame.number, snapshot.frame.time],
            [part.id, *place, part.radius, part.value],
        )
    nets = [lines(snapshot.frame, camera) for snapshot in snapshots]
    inside = widened(inside, nets)
    shown = [*zip(snapshots, drawn, nets, strict=True)]
    figure = _draw(shown, quantities[0], camera, inside, look)
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
    shown: Sequence[tuple[PlotFrame, Block, Array]],
    quantity: Quantity,
    camera: Camera,
    inside: Array,
    look: Look,
) -> Figure:
    """Draw each frame with its particles and the nets of its rigid bodies."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator

    snapshots = [snapshot for snapshot, _, _ in shown]
    low, high, beyond = scale(np.concatenate([seen.value for _, seen, _ in shown]), look.limits)
    shades = colormaps[look.map].with_extremes(bad="#c8c8c8")
    colours = ScalarMappable(Normalize(low, high), shades)
    size = inside[1] - inside[0]
    columns = look.panels or columns_of(len(snapshots), size)
    wide = size[0] * min(columns, 2) > _FLAT * size[1]
    figure, axes = _panels((len(snapshots), columns), size, wide, camera.along_axes, look.width)
    (left, bottom), (right, top) = inside + 0.03 * size.max() * np.array([[-1.0], [1.0]])
    several = len({snapshot.shown.name for snapshot in snapshots}) > 1
    for number, ((snapshot, seen, net), axis) in enumerate(zip(shown, axes, strict=False)):
        rgba = colours.to_rgba(np.ma.masked_invalid(seen.value))
        draw(axis, camera, seen, rgba, snapshot.shown.dimension < 3)
        if len(net):
            draw_lines(axis, net, snapshot.shown.dimension < 3)
        axis.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        name = f"{plain(snapshot.shown.name)}, " if several else ""
        title = look.title if look.title and len(shown) == 1 else name + snapshot.title
        axis.set_title(title, fontsize="medium")
        axis.grid(False)
        columns = axis.get_subplotspec().get_gridspec().ncols
        _label(axis, snapshot, camera, columns, lowest=number + columns >= len(snapshots))
        if number == 0 and not camera.along_axes:
            _compass(axis, camera)
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


def _label(axis: Axes, snapshot: PlotFrame, camera: Camera, columns: int, *, lowest: bool) -> None:
    """Name the axes at the left and below; `lowest`: no picture is below this one."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    if not camera.along_axes:
        axis.set(xticks=[], yticks=[])  # without axes there would be no space for the title
        axis.spines[:].set_visible(False)
        return
    panel = axis.get_subplotspec()
    first = panel is not None and panel.is_first_col()
    sides = (("x", axis.xaxis, camera.right), ("y", axis.yaxis, camera.up))
    for side, ticks, direction in sides:
        name, reversed_ = camera.axis(direction)
        ticks.set_major_locator(MaxNLocator(3 if side == "x" and columns > 2 else 5))
        if reversed_:
            ticks.set_major_formatter(FuncFormatter(lambda value, _: f"{-value + 0.0:g}"))
        if lowest if side == "x" else first:
            axis.set(**{f"{side}label": snapshot.shown.label(name, "length")})
    axis.xaxis.set_tick_params(labelbottom=lowest)


def _compass(axis: Axes, camera: Camera) -> None:
    """Draw the directions of the axes of space into the lower left corner."""
    options: dict[str, Any] = {
        "xycoords": "axes fraction",
        "textcoords": "offset points",
        "fontsize": 8,
        "annotation_clip": False,
    }
    centred: dict[str, Any] = {"ha": "center", "va": "center"}
    arrow = {"arrowstyle": "<|-,head_width=0.15,head_length=0.3", "color": "#444444", "lw": 0.9}
    for name, right, up in zip(AXES, camera.right, camera.up, strict=True):
        x, y = _ARROW * right, _ARROW * up
        if np.hypot(x, y) > 0.1 * _ARROW:
            axis.annotate("", (0.0, 0.0), xytext=(x, y), arrowprops=arrow, **options)
            axis.annotate(name, (0.0, 0.0), xytext=(1.3 * x, 1.3 * y), **centred, **options)
