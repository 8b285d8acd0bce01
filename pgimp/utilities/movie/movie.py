"""Movies: a picture of each frame, all in the same place and range of colours."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.contours.drawing import levels
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
    from matplotlib import rc_context
    from matplotlib.animation import writers

    name = "pillow" if kind == "gif" else "ffmpeg"
    if not writers.is_available(name):
        raise UsageError("an .mp4 needs the program ffmpeg, which is not here; a .gif needs none")
    inside = extents_of(snapshots, selection, camera)
    inside = np.array([inside[:, 0].min(axis=0), inside[:, 1].max(axis=0)])
    if look.limits is None:
        limits = _colour_range(snapshots, quantities, selection, camera, inside)
        if look.contours:
            ends = levels(*limits, look.contours, exact=False)
            limits, look = (ends[0], ends[-1]), look._replace(contours=len(ends) - 1)
        look = look._replace(limits=limits)
    look = look._replace(inside=inside)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"movie.{kind}"
        writer = writers[name](fps=rate)  # type: ignore[arg-type]
        try:
            # Files of styles may cut pictures to what is on them, each to another size.
            with rc_context({"savefig.bbox": None}):
                _write(writer, path, snapshots, quantities, selection, camera, look)
        except (OSError, subprocess.CalledProcessError) as error:
            raise UsageError(f"{name} has failed: {_reason(error)}; try a .gif") from error
        return path.read_bytes()


def _write(
    writer: Any,
    path: Path,
    snapshots: Sequence[PlotFrame],
    quantities: Sequence[Quantity],
    selection: Selection,
    camera: Camera,
    look: Look,
) -> None:
    """Write the pictures to a file, by one of matplotlib's writers."""
    size: tuple[float, float] | None = None
    try:
        for snapshot, quantity in zip(snapshots, quantities, strict=True):
            figure, _, _ = picture([snapshot], [quantity], selection, camera, look)
            first = size is None
            size = size or _even(figure.get_size_inches())
            figure.set_size_inches(size)
            if first:
                writer.setup(figure, str(path), _DOTS_PER_INCH)
            writer.fig = figure
            writer.grab_frame()
    except BrokenPipeError:
        pass  # the program has ended; finish tells why
    writer.finish()


def _reason(error: OSError | subprocess.CalledProcessError) -> str:
    """Return the last line that a program of movies said, else what Python says."""
    said = getattr(error, "stderr", None) or getattr(error, "output", None) or b""
    lines = (said.decode(errors="replace") if isinstance(said, bytes) else said).strip()
    return lines.splitlines()[-1] if lines else str(error)


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
