"""Movies: a picture of each frame, all in the same place and range of colours."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.picture import extents_of, picture, scale
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import PlotFrame
from pgimp.utilities.plot.selection import Selection
from pgimp.utilities.plot.visible import visible

FORMATS = ("gif", "mp4")
_DOTS_PER_INCH = 110


def movie(
    kind: str,
    snapshots: Sequence[PlotFrame],
    quantities: Sequence[Quantity],
    selection: Selection,
    camera: Camera,
    look: Look,
    rate: float,
) -> bytes:
    """Return the file of a movie.

    Parameters
    ----------
    kind : str
        One of `FORMATS`; mp4 needs the program ffmpeg.
    snapshots, quantities, selection, camera, look
        As of `picture`.
    rate : float
        Frames in a second.

    Raises
    ------
    UsageError
        If there is no program for it, or no particle to be drawn.
    """
    from matplotlib.animation import writers

    name = "pillow" if kind == "gif" else "ffmpeg"
    if not writers.is_available(name):
        raise UsageError(f"a movie of the kind {kind} needs {name}, which is not here; try .gif")
    inside = extents_of(snapshots, selection, camera)
    inside = np.array([inside[:, 0].min(axis=0), inside[:, 1].max(axis=0)])
    if look.limits is None:
        limits = _colour_range(snapshots, quantities, selection, camera, inside)
        look = look._replace(limits=limits)
    look = look._replace(inside=inside)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"movie.{kind}"
        writer = writers[name](fps=rate)  # type: ignore[arg-type]
        for number, (snapshot, quantity) in enumerate(zip(snapshots, quantities, strict=True)):
            figure, _, _ = picture([snapshot], [quantity], selection, camera, look)
            if number == 0:
                size = _even(figure.get_size_inches())
                figure.set_size_inches(size)
                writer.setup(figure, str(path), _DOTS_PER_INCH)
            figure.set_size_inches(size)
            writer.fig = figure
            writer.grab_frame()
        writer.finish()
        return path.read_bytes()


def _even(size: np.ndarray) -> tuple[float, float]:
    """Size in inches of an even number of pixels, which encoders of video want."""
    wide, high = (2.0 * np.round(0.5 * size * _DOTS_PER_INCH) / _DOTS_PER_INCH).tolist()
    return wide, high


def _colour_range(
    snapshots: Sequence[PlotFrame],
    quantities: Sequence[Quantity],
    selection: Selection,
    camera: Camera,
    inside: np.ndarray,
) -> tuple[float, float]:
    """Return the ends of the colours for several frames, read one after the other."""
    values = [
        visible(snapshot.frame, selection, quantity, camera, inside)[0].value
        for snapshot, quantity in zip(snapshots, quantities, strict=True)
    ]
    return scale(np.concatenate(values), None)[:2]
