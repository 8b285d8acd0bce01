"""A run's own files in its directory, and foreign files that block them."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path

from pgimp.errors import UsageError
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.probefiles import PROBES, probe_file, probes_ever

RUN = "run.json"
REPORT = "report.html"
ERRORS = "errors.csv"
#: Folder of companion runs, each a run directory.
COARSE = "coarse"
_LISTS = tuple(
    f"{name}.{kind}"
    for kind in ("xdmf", "vtkhdf")
    for name in ("particles", "grid", "rigid", "surface")
)
TOP = ("case.yaml", "input.yaml", *_LISTS, "history.csv", "log.txt", ERRORS, REPORT, RUN)
FRAME = re.compile(r"particles-(\d{6,})\.h5")
GRID_FRAME = re.compile(r"grid-(\d{6,})\.h5")
RIGID_FRAME = re.compile(r"rigid-(\d{6,})\.h5")
SURFACE_FRAME = re.compile(r"surface-(\d{6,})\.h5")
FOLDERS = ("frames", "checkpoints")
FAILURE = "failure"
#: A file that marks the recorded failure of a run.
FAILED = ".failed"
#: Files being written.
PART = re.compile(
    r"\.(case\.yaml|input\.yaml|run\.json|report\.(txt|html)|errors\.csv|particles\.h5|"
    r"(particles|grid|rigid|surface)\.(xdmf|vtkhdf)|"
    r"(particles|grid|rigid|surface|step)-\d+\.h5)\.part"
)
# Files that a run writes, by folder.
_DATA = {
    "checkpoints": re.compile(r"step-\d{9,}\.h5(\.damaged)?"),
    "frames": re.compile(
        "|".join(one.pattern for one in (FRAME, GRID_FRAME, RIGID_FRAME, SURFACE_FRAME))
    ),
    FAILURE: re.compile(r"particles\.h5|particles\.xdmf|report\.txt"),
}


def own_files(directory: Path) -> Iterator[Path]:
    """Yield the files of a run except run.json, without which the rest counts as no run.

    Raises
    ------
    OSError
        If a folder cannot be read.
    """
    for name, data in {**_DATA, "": PART}.items():
        folder = directory / name
        for entry in folder.iterdir() if folder.is_dir() else ():
            if data.fullmatch(entry.name) or PART.fullmatch(entry.name):
                yield entry
    for name in sorted(probes_so_far(directory)):
        yield probe_file(directory, name)
    for name in (FAILED, *TOP):
        if name != RUN:
            yield directory / name


def companion_files(directory: Path) -> Iterator[Path]:
    """Yield the files of the companion runs in a run directory.

    Raises
    ------
    OSError
        If a folder cannot be read.
    """
    for folder in sorted((directory / COARSE).glob("*")):
        if runinfo.read(folder / RUN) is not None:
            yield from own_files(folder)
            yield folder / RUN


def remove_empty(folder: Path) -> None:
    """Remove the folders without files in a folder, and the folder itself if it is empty then."""
    for name, _, _ in os.walk(folder, topdown=False):
        with suppress(OSError):
            os.rmdir(name)


def probes_so_far(directory: Path) -> set[str]:
    """Return the names of all probes that the run in a directory has or had."""
    return probes_ever(directory, runinfo.read(directory / RUN))


def require_room(directory: Path, resume: bool, probes: Collection[str]) -> None:
    """Ensure that no foreign files block a run; nothing is changed.

    Parameters
    ----------
    resume : bool
        Whether the existing run is continued, so that its files stay.
    probes : collection of str
        Names of the probes that the run is to have.

    Raises
    ------
    UsageError
        With the blocking files and a remedy.
    OSError
        If a folder cannot be read.
    """
    ever = probes_so_far(directory)
    for name in (*FOLDERS, *([PROBES] if probes or ever else [])):
        path = directory / name
        if os.path.lexists(path) and not path.is_dir():
            raise _obstacle(path, "it is no folder, but a run needs a folder of this name")
    files = [directory / name for name in TOP] + [probe_file(directory, name) for name in probes]
    for path in (*files, *(() if resume else own_files(directory))):
        if path.exists() and not path.is_file():
            what = "a folder" if path.is_dir() else "no plain file"
            raise _obstacle(path, f"it is {what}, but a run has a file of this name")
    # Without run.json only the checkpoints may have the names of the probes.
    if runinfo.read(directory / RUN) is not None:
        for name in sorted({*probes} - ever):
            if os.path.lexists(path := probe_file(directory, name)):
                raise _obstacle(path, "a run would replace it, and no earlier start has written it")


def _obstacle(path: Path, why: str) -> UsageError:
    return UsageError(
        f"{path} is in the way and none of pgimp's: {why}.\n"
        "Nothing has been changed; move it away, or choose another directory with -o."
    )
