"""VTK's group in the frames of a run, and the series that list them, for runs without them."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from pgimp.errors import RunError, UsageError, explain
from pgimp.io.frames.mesh import described
from pgimp.io.frames.vtkhdf import ROOT, add_group
from pgimp.io.frames.vtkseries import VtkSeries
from pgimp.io.results.frame import Reading
from pgimp.io.rundir.ownfiles import FRAME, GRID_FRAME, RIGID_FRAME, SURFACE_FRAME
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import Serial
from pgimp.storage.atomic import publish, temporary
from pgimp.storage.hdf5 import open_file

_SERIES = {
    "particles": FRAME, "grid": GRID_FRAME, "rigid": RIGID_FRAME, "surface": SURFACE_FRAME
}  # fmt: skip


def export(path: Path) -> Iterator[str]:
    """Add the group to each frame that has none, and list all frames again.

    A frame is replaced by a copy once that is complete on the disk.

    Parameters
    ----------
    path : Path
        The run directory, of a run that does not go on.

    Yields
    ------
    str
        A line for each series, and for each frame that cannot be read.

    Raises
    ------
    UsageError
        If the run goes on, or has no frames.
    RunError
        If the disk is full, or a frame cannot be replaced.
    """
    directory = RunDirectory(path, Serial(), resume=True)
    try:
        there = False
        for name, pattern in _SERIES.items():
            frames = sorted(
                (int(match[1]), file)
                for file in (path / "frames").iterdir()
                if (match := pattern.fullmatch(file.name)) and file.is_file()
            )
            if frames:
                there = True
                yield from _series(path / f"{name}.vtkhdf", [file for _, file in frames])
        if not there:
            raise UsageError(f"{path} has no frames; output.every makes them")
    except OSError as error:
        raise RunError(f"cannot write to {path}: {explain(error)}") from error
    finally:
        directory.release()


def _series(target: Path, frames: list[Path]) -> Iterator[str]:
    series, new, listed = VtkSeries(target), 0, 0
    for file in frames:
        try:
            mesh = described(file)
            new += _complete(file)
        except RunError as error:
            yield f"note: {error}; {target.name} goes without it"
            continue
        series.add(mesh)
        listed += 1
    if not listed:
        return
    series.write(durable=True)
    number = "1 frame" if listed == 1 else f"{listed} frames"
    yield f"wrote {target}: {number}, {new or 'none'} of them new to VTK"


def _complete(path: Path) -> bool:
    """Add the group to a frame; whether it had none."""
    with Reading(path) as file:
        if ROOT in file.names:
            return False
    part = temporary(path)
    try:
        shutil.copyfile(path, part)
        shutil.copymode(path, part)
        with open_file(part, "r+") as frame:
            add_group(frame)
        publish(part, path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
    return True
