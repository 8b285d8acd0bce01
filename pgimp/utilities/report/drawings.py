"""Figures of a report: curves as SVG whose text is text, pictures of particles as PNG."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import PgimpError, UsageError
from pgimp.utilities.plot.curves.curves import curves
from pgimp.utilities.plot.runs import PlotFrame, PlotRun
from pgimp.utilities.plot.selection import Selection
from pgimp.utilities.plot.style import STYLE
from pgimp.utilities.report.html import Markup, figure, image, join, paragraph

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PIXELS_PER_INCH = 144
_POINTS_PER_INCH = 96
#: Ids that nothing refers to, and that several figures of a page would share.
_IDLE = re.compile(
    r' id="(?:figure|axes|patch|line2d|text|matplotlib\.axis|xtick|ytick|legend|'
    r'LineCollection|PathCollection|EllipseCollection|QuadMesh)_\d+"'
)
_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
#: Curves in a figure of forces, the greatest ones.
_MOST_FORCES = 8

FORCE = re.compile(r"((reaction|constraint)\..*|rigid\..*\.force|contact\..*)-[xyz]")


def svg(drawn: Figure, description: str, run: str) -> Markup:
    """Return a figure as a part of a page; its text is in the reader's fonts.

    Parameters
    ----------
    drawn : matplotlib.figure.Figure
        The figure.
    description, run : str
        What it shows, and of which run: no other figure of the page has both.
    """
    from matplotlib import rc_context

    stream = io.StringIO()
    style: Any = {"svg.fonttype": "none", "svg.hashsalt": f"{run}: {description}"}
    with rc_context(style):
        drawn.savefig(
            stream, format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.05
        )
    content = _METADATA.sub("", _HEAD.sub("", stream.getvalue()))
    content = _IDLE.sub("", content)
    title = description.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return Markup(content.replace("<svg ", f'<svg role="img" aria-label="{title}" ', 1).strip())


def png(drawn: Figure, description: str) -> Markup:
    """Return a figure as a picture, in the size in which it was made."""
    stream = io.BytesIO()
    drawn.savefig(stream, format="png", dpi=_PIXELS_PER_INCH, bbox_inches="tight", pad_inches=0.05)
    content = stream.getvalue()
    pixels = int.from_bytes(content[16:20], "big")
    return image(content, description, round(pixels * _POINTS_PER_INCH / _PIXELS_PER_INCH))


def history_figure(shown: PlotRun, columns: Sequence[str], caption: str) -> Markup:
    """Return curves of some columns over time; a sentence where there are none to draw."""
    from matplotlib import rc_context

    if not columns:
        return Markup()
    style: Any = STYLE
    try:
        with rc_context(style):
            drawn, _, _ = curves([shown], [], columns, "time", False)
            return figure(svg(drawn, caption, shown.name), caption)
    except PgimpError as error:
        return paragraph(f"{caption}: {error}")


def energies(history: np.ndarray) -> list[str]:
    """Return the columns of energies that are not always zero."""
    names = history.dtype.names or ()
    kinds = r"(kinetic|strain|dissipated|damped)-energy|(external|plastic|viscous)-work|heat"
    some = [name for name in names if re.fullmatch(kinds, name) and _greatest(history, name) > 0.0]
    return some or [name for name in ("kinetic-energy", "strain-energy") if name in names]


def forces(history: np.ndarray) -> list[str]:
    """Return the columns of the greatest forces, in the order of the history."""
    names = [name for name in history.dtype.names or () if FORCE.fullmatch(name)]
    size = {name: _greatest(history, name) for name in names}
    most = max(size.values(), default=0.0)
    ranked = sorted((name for name in names if size[name] > 1e-9 * most), key=lambda n: -size[n])
    return [name for name in names if name in ranked[:_MOST_FORCES]]


def motions(history: np.ndarray) -> list[str]:
    """Return the columns of prescribed displacements, and of rigid bodies' ways."""
    names = history.dtype.names or ()
    kinds = r"displacement\..*-[xyz]|rigid\..*\.displacement-[xyz]"
    some = [name for name in names if re.fullmatch(kinds, name) and _greatest(history, name) > 0.0]
    return some[:_MOST_FORCES]


def _greatest(history: np.ndarray, name: str) -> float:
    return float(np.abs(np.nan_to_num(history[name])).max()) if len(history) else 0.0


def pictures(shown: PlotRun, field: str | None = None, most: int = 3) -> Markup:
    """Return the first, the middle and the last frame with particles, in one scale of colours.

    Parameters
    ----------
    field : str, optional
        The quantity, as for ``pgimp plot --field``.
    most : int
        Number of frames; 1 is the last.
    """
    try:
        frames = [frame for frame in shown.run.frames if len(frame)]
    except PgimpError as error:
        return paragraph(f"The frames cannot be read: {error}")
    if not frames:
        return paragraph("There is no frame with particles.")
    numbers = np.linspace(0, len(frames) - 1, most) if most > 1 else [len(frames) - 1]
    chosen = list(dict.fromkeys(round(float(k)) for k in numbers))
    try:
        return _pictures(shown, [PlotFrame(shown, frames[k]) for k in chosen], field)
    except UsageError:
        if field is not None:
            raise
        return paragraph("The frames have nothing that can be drawn.")
    except PgimpError as error:
        return paragraph(f"The frames cannot be drawn: {error}")


def _pictures(shown: PlotRun, chosen: list[PlotFrame], field: str | None) -> Markup:
    from matplotlib import rc_context

    from pgimp.utilities.plot.along import along
    from pgimp.utilities.plot.camera import camera
    from pgimp.utilities.plot.picture import picture
    from pgimp.utilities.plot.quantity import quantity

    first = quantity(field, chosen[0].frame, shown.dimension)
    quantities = [quantity(first.text, each.frame, shown.dimension) for each in chosen]
    times = ", ".join(each.title for each in chosen)
    what = f"{first.label}, {times}"
    style: Any = STYLE
    with rc_context(style):
        if shown.dimension == 1:
            drawn, _, remarks = along(chosen, quantities, Selection(), 0, False)
            content = svg(drawn, what, shown.name)
        else:
            view = camera(None, shown.dimension, None)
            drawn, _, remarks = picture(chosen, quantities, Selection(spacing=shown.spacing), view)
            content = png(drawn, what)
    said = [paragraph(f"{text[0].upper()}{text[1:]}.") for text in map(_without_path, remarks)]
    return join([figure(content, f"{what}: of {len(shown.run.frames)} frames."), *said[:1]])


def _without_path(remark: str) -> str:
    return remark.rpartition(": ")[2]
