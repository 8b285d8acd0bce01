"""A field along an axis: the mean over cross-sections, or each particle near a line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import AXES, PlotFrame
from pgimp.utilities.plot.selection import Selection, empty
from pgimp.utilities.plot.style import COLOURS, DASHES, MARKERS, log_ticks, plain
from pgimp.utilities.plot.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = np.ndarray

MOST_POINTS = 20_000
"""Of more particles near a line, or in 1D, only every second, third, ... is drawn."""

_MOST_BINS = 1 << 22
_MARKED = 400


def along(
    snapshots: Sequence[PlotFrame],
    quantities: Sequence[Quantity],
    selection: Selection,
    axis: int,
    logarithmic: bool,
) -> tuple[Figure, Table, list[str]]:
    """Draw a field along an axis, several frames in one diagram.

    Parameters
    ----------
    quantities : sequence of Quantity
        Quantity of each frame.
    selection : Selection
        Particles to draw; with a place the particles that reach that line, each a point. Otherwise,
        in 2D and 3D, volume means over cross-sections, in strips of the particles' initial width.
    logarithmic : bool
        Whether the vertical axis is logarithmic.

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
    from matplotlib.figure import Figure

    means = snapshots[0].shown.dimension > 1 and not selection.place
    name, value = AXES[axis], quantities[0].text
    value = f"position.{name}" if value == name else value
    table = Table(["run", "frame", "time", *([] if means else ["id"]), name, value])
    if means:
        table.columns.append("particles")
    figure = Figure(figsize=(6.4, 4.2))
    axes = figure.subplots()
    remarks = []
    for number, (snapshot, quantity) in enumerate(zip(snapshots, quantities, strict=True)):
        same = [snapshot.shown.name, snapshot.frame.number, snapshot.frame.time]
        if means:
            place, values, counts = _means(snapshot, quantity, selection, axis)
            table.add(same, [place, values, counts])
        else:
            ids, place, values, total = _points(snapshot, quantity, selection, axis)
            table.add(same, [ids, place, values])
            if len(place) < total:
                remarks.append(
                    f"{snapshot.frame.path}: {len(place):,} of {total:,} particles drawn"
                )
        axes.plot(
            place,
            values,
            color=COLOURS[number % len(COLOURS)],
            ls=DASHES[number % len(DASHES)] if len(snapshots) > 1 else "-",
            marker=MARKERS[number % len(MARKERS)] if len(place) <= _MARKED else None,
            ms=3,
            lw=1.1,
            label=_legend(snapshot, snapshots),
        )
    shown = snapshots[0].shown
    axes.set(
        xlabel=shown.label(name, "length"),
        ylabel=shown.label(_described(quantities[0], selection, means), quantities[0].kind),
        title=_title(snapshots),
    )
    axes.title.set_fontsize(10)
    if logarithmic:
        axes.set_yscale("log", nonpositive="mask")
        log_ticks(axes.yaxis)
    if len(snapshots) > 1:
        axes.legend(fontsize=9)
    return figure, table, remarks


def _means(
    snapshot: PlotFrame, quantity: Quantity, selection: Selection, axis: int
) -> tuple[Array, Array, Array]:
    """Return positions, means and numbers of particles of the strips with particles."""
    case = snapshot.shown.case
    grid, each = case["grid"], case["method"]["particles-per-cell"]
    origin, length = float(grid["origin"][axis]), float(grid["size"][axis])
    width = float(grid["cell"][axis]) / float(each[axis])
    strips = int(np.ceil(length / width)) + 1
    if strips > _MOST_BINS:
        raise UsageError(f"{strips:,} strips of particles along {AXES[axis]} are too many to draw")
    sums = np.zeros((4, strips))
    for block in selection.blocks(snapshot.frame, quantity):
        place = block.position[:, axis]
        strip = np.clip(np.floor((place - origin) / width), 0, strips - 1).astype(np.int64)
        weights = (np.ones_like(place), block.volume, block.volume * place)
        for row, weight in zip(sums, (*weights, block.volume * block.value), strict=True):
            row += np.bincount(strip, weight, strips)
    counts, volume, place, value = sums[:, sums[0] > 0]
    if not len(counts):
        raise empty(snapshot.frame, selection.place)
    return place / volume, value / volume, counts.astype(np.int64)


def _points(
    snapshot: PlotFrame, quantity: Quantity, selection: Selection, axis: int
) -> tuple[Array, Array, Array, int]:
    """Return ids, positions and values of particles in order along the axis, and their number."""
    blocks = list(selection.blocks(snapshot.frame, quantity))
    ids = np.concatenate([block.id for block in blocks])
    place = np.concatenate([block.position[:, axis] for block in blocks])
    values = np.concatenate([block.value for block in blocks])
    if not len(ids):
        raise empty(snapshot.frame, selection.place)
    order = np.lexsort((ids, place))[:: -(-len(ids) // MOST_POINTS)]
    return ids[order], place[order], values[order], len(ids)


def _described(quantity: Quantity, selection: Selection, means: bool) -> str:
    if means:
        return f"{quantity.label}, mean across"
    at = ", ".join(f"{AXES[axis]} = {place:g}" for axis, place in sorted(selection.place.items()))
    return f"{quantity.label} at {at}" if at else quantity.label


def _legend(snapshot: PlotFrame, snapshots: Sequence[PlotFrame]) -> str:
    names = {one.shown.name for one in snapshots}
    times = {one.frame.time for one in snapshots}
    parts = [plain(snapshot.shown.name)] if len(names) > 1 else []
    return ", ".join([*parts, *([snapshot.title] if len(times) > 1 or not parts else [])])


def _title(snapshots: Sequence[PlotFrame]) -> str:
    times = {snapshot.frame.time for snapshot in snapshots}
    return snapshots[0].title if len(times) == 1 else ""
