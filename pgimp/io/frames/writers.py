"""The formats by which other programs read the frames of a run; a further one is entered here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pgimp.io.frames.vtkseries import VtkSeries
from pgimp.io.frames.writer import Writer
from pgimp.io.frames.xdmf import Collection

WRITERS: tuple[type[Writer], ...] = (Collection, VtkSeries)


def writers_of(series: Path) -> list[Writer]:
    """Return the writers of a series, given the path of its files without suffix."""
    return [writer(series.with_suffix(writer.suffix)) for writer in WRITERS]


def begin_frame(file: Any) -> None:
    """Add to a frame's own file what the formats need there, see `Writer.begin`."""
    for writer in WRITERS:
        writer.begin(file)
