"""Quantities of surfaces that meet: curves along the outlines in 2D, maps in 3D."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.gridreader import GridFrame
from pgimp.schema.messages import unknown
from pgimp.utilities.plot.camera import Camera, compass, name_axes
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.picture import scale
from pgimp.utilities.plot.runs import AXES, PlotFrame
from pgimp.utilities.plot.style import COLOURS, DASHES, plain
from pgimp.utilities.plot.tables import Table
from pgimp.utilities.plot.units import kind_of_field

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = np.ndarray

#: Part of an outline below which only the part with values that are not zero is shown.
_SHORT = 0.6


class _Values(NamedTuple):
    """A quantity on the cells of some bodies."""

    corners: Array  #: (n, nodes, 3) float64: Corners of the cells.
    body: Array  #: (n,) int64.
    normal: Array  #: (n, 3) float64.
    value: Array  #: (n,) float64.
    names: list[str]  #: Of all bodies.


def surface_of(snapshot: PlotFrame, name: str, bodies: Sequence[str]) -> _Values:
    """Read a quantity of the surfaces beside a frame of particles.

    Parameters
    ----------
    name : str
        A quantity, the component of one, such as ``traction.x``, or the magnitude of a vector.
    bodies : sequence of str
        Names of the bodies; empty for all.

    Raises
    ------
    UsageError
        If there is no such frame, quantity or body.
    """
    path = snapshot.frame.path
    path = path.with_name(path.name.replace("particles-", "surface-"))
    if not path.is_file():
        raise UsageError(
            f"{snapshot.shown.path} has no surfaces; output: {{surface: [contact-pressure]}} asks "
            "for them"
        )
    frame = GridFrame(path)
    field, _, component = name.partition(".")
    fields = [each for each in frame.of_cells if each != "normal"]
    if field not in fields:
        raise UsageError(unknown("quantity of surfaces", field, fields))
    values = np.asarray(frame[field], float)
    if component:
        if values.ndim == 1 or component not in [*AXES]:
            raise UsageError(f"{field} has no component {component}")
        values = values[:, AXES.index(component)]
    elif values.ndim == 2:
        values = np.sqrt((values * values).sum(axis=1))
    for each in bodies:
        if each not in frame.bodies:
            raise UsageError(unknown("body", each, frame.bodies))
    body = frame["body"]
    chosen = np.isin(body, [frame.bodies.index(each) for each in bodies or frame.bodies])
    corners = np.asarray(frame["position"][frame["connectivity"][chosen]], float)
    return _Values(corners, body[chosen], frame["normal"][chosen], values[chosen], frame.bodies)


def curves_of_surfaces(
    snapshots: Sequence[PlotFrame], name: str, bodies: Sequence[str], axis: int | None
) -> tuple[Figure, Table]:
    """Draw a quantity along the outlines of bodies in 2D.

    Parameters
    ----------
    axis : int or None
        The axis of space that it is drawn over; None: the length along the outline,
        counter-clockwise from its point with the least x.

    Raises
    ------
    UsageError
        See `surface_of`.
    """
    from matplotlib.figure import Figure

    along = ["length"] if axis is None else []
    table = Table(["run", "frame", "time", "body", *AXES[:2], *along, name])
    figure = Figure(figsize=(6.4, 4.2))
    axes, shown, number, ends = figure.subplots(), snapshots[0].shown, 0, []
    for snapshot in snapshots:
        every = surface_of(snapshot, name, bodies)
        for body in np.unique(every.body):
            own = every.body == body
            order, place = _outline(every.corners[own])
            middle, value = every.corners[own][order].mean(axis=1), every.value[own][order]
            if not np.nan_to_num(value).any() and not bodies:
                continue
            if axis is not None:
                place = middle[:, axis]
            columns = [middle[:, 0], middle[:, 1], *([place] if axis is None else []), value]
            same = [snapshot.shown.name, snapshot.frame.number, snapshot.frame.time]
            table.add([*same, every.names[body]], columns)
            parts = [plain(every.names[body])]
            if len({each.shown.name for each in snapshots}) > 1:
                parts.append(plain(snapshot.shown.name))
            if len({each.frame.time for each in snapshots}) > 1:
                parts.append(snapshot.title)
            axes.plot(
                place, value, color=COLOURS[number % len(COLOURS)],
                ls=DASHES[number % len(DASHES)], lw=1.1, marker=".", ms=3, label=", ".join(parts),
            )  # fmt: skip
            some = place[np.nan_to_num(value) != 0.0]
            loaded = some.min(initial=np.inf), some.max(initial=-np.inf)
            ends.append((place.min(), place.max(), *loaded))
            number += 1
    if not number:
        raise UsageError(f"{name} is zero on all surfaces: nothing touches; --body draws one")
    low, high, first, last = np.array(ends).T
    least, most = first.min(), last.max()
    if 0.0 < most - least < _SHORT * (high.max() - low.min()):
        room = 0.15 * (most - least)
        axes.set_xlim(least - room, most + room)
    label = "along the outline" if axis is None else AXES[axis]
    axes.set(
        xlabel=shown.label(label, "length"),
        ylabel=shown.label(_label(name), kind_of_field(name.partition(".")[0])),
    )
    if len({snapshot.frame.time for snapshot in snapshots}) == 1:
        axes.set_title(snapshots[0].title, fontsize=10)
    if number > 1:
        axes.legend(fontsize=9)
    return figure, table


def map_of_surfaces(
    snapshot: PlotFrame, name: str, bodies: Sequence[str], camera: Camera, look: Look
) -> tuple[Figure, Table]:
    """Draw a quantity on the surfaces of bodies in 3D, as they are seen.

    Raises
    ------
    UsageError
        See `surface_of`.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    every = surface_of(snapshot, name, bodies)
    middle = every.corners.mean(axis=1)
    table = Table(["run", "frame", "time", "body", *AXES, name])
    for body in np.unique(every.body):
        own = every.body == body
        same = [snapshot.shown.name, snapshot.frame.number, snapshot.frame.time]
        table.add([*same, every.names[body]], [*middle[own].T, every.value[own]])
    low, high, beyond = scale(every.value, look.limits)
    shades = colormaps[look.map].with_extremes(bad="#c8c8c8")
    colours = ScalarMappable(Normalize(low, high), shades)
    towards = every.normal @ camera.towards
    seen = np.flatnonzero(towards > 0.0)
    seen = seen[np.argsort(camera.project(middle[seen])[:, 2], kind="stable")]
    flat = camera.project(every.corners[seen])[..., :2]
    rgba = colours.to_rgba(np.ma.masked_invalid(every.value[seen]))
    rgba[:, :3] *= (0.75 + 0.25 * towards[seen])[:, None]
    figure = Figure(figsize=(look.width or 6.4, 0.78 * (look.width or 6.4)))
    axes = figure.subplots()
    axes.add_collection(PolyCollection(list(flat), facecolors=rgba, edgecolors=rgba, lw=0.2))
    axes.autoscale_view()
    axes.set(aspect="equal")
    axes.set_title(look.title or snapshot.title, fontsize="medium")
    axes.grid(False)
    name_axes(axes, snapshot, camera, 1, lowest=True)
    if not camera.along_axes:
        compass(axes, camera)
    label = snapshot.shown.label(_label(name), kind_of_field(name.partition(".")[0]))
    figure.colorbar(colours, ax=axes, label=label, extend=beyond, shrink=0.85, aspect=25)
    return figure, table


def _label(name: str) -> str:
    field, _, component = name.partition(".")
    return f"{field.replace('-', ' ')} {component}".rstrip()


def _outline(corners: Array) -> tuple[Array, Array]:
    """Order of lines along their outlines, and the length up to the middle of each."""
    begin, end = corners[:, 0, :2], corners[:, 1, :2]
    left, order = np.ones(len(begin), bool), []
    one = int(np.lexsort((begin[:, 1], begin[:, 0]))[0])
    while True:
        order.append(one)
        left[one] = False
        rest = np.flatnonzero(left)
        if not len(rest):
            break
        one = int(rest[np.argmin(((begin[rest] - end[one]) ** 2).sum(axis=1))])
    length = np.sqrt(((end - begin) ** 2).sum(axis=1))[order]
    return np.array(order), np.cumsum(length) - 0.5 * length
