"""run.json: versions, hosts, state and progress of a run."""

from __future__ import annotations

import datetime
import errno
import json
import os
import platform
import re
import shlex
import socket
import sys
from collections import Counter
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from pgimp.mpi.communicator import Communicator
from pgimp.storage import atomic
from pgimp.storage.hdf5 import load_h5py
from pgimp.storage.plain import read_plain

PROGRAM = "pgimp"
FORMAT_VERSION = 1
# Most bytes of a run.json; a start of a run takes some 2,000.
_LARGEST = 32 << 20


def now() -> str:
    """Return the date and time with the offset from UTC."""
    return datetime.datetime.now().astimezone().isoformat(timespec="seconds")


def describe_start(
    comm: Communicator, particles: int, resumed: int | None = None
) -> dict[str, object]:
    """Collect the data of a run's start.

    Parameters
    ----------
    comm : communicator
        Of all ranks; the call is collective.
    particles : int
        Number of particles of the run.
    resumed : int, optional
        Step from which an earlier start is resumed.

    Returns
    -------
    dict
        An entry of ``starts`` in run.json; equal on all ranks except for the hosts.
    """
    hosts = comm.gather(socket.gethostname())
    return {
        "state": "running",
        "began": now(),
        "ended": None,
        "steps": 0,
        "time": 0.0,
        "seconds": None,
        "message": None,
        "resumed_from": resumed,
        "checkpoint": None,
        "particles": particles,
        "ranks": comm.size,
        "hosts": dict(Counter(hosts or [])),
        "cpu": cpu(),
        "process": os.getpid(),
        "command": shlex.join(sys.argv),
        "working_directory": str(Path.cwd()),
        "versions": versions(),
        "commit": commit(),
    }


def versions() -> dict[str, str | None]:
    """Return the versions of all software that may change results; None if not installed."""
    found: dict[str, str | None] = {"python": platform.python_version()}
    for package in (PROGRAM, "numpy", "numba", "llvmlite", "h5py", "mpi4py"):
        found[package] = installed(package)
    found["hdf5"] = load_h5py().version.hdf5_version
    found["mpi"] = None
    mpi = sys.modules.get("mpi4py.MPI")
    if mpi is not None and mpi.Is_initialized():
        found["mpi"] = mpi.Get_library_version().strip("\0 \n").splitlines()[0]
    found["system"] = platform.platform()
    return found


def installed(package: str) -> str | None:
    """Return the version of an installed package; None if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def commit() -> str | None:
    """Return the commit of the working tree that pgimp runs from; None if it is installed."""
    root = Path(__file__).resolve().parents[2]
    git = root / ".git"
    try:
        if git.is_file():  # a linked working tree
            git = (root / git.read_text().removeprefix("gitdir:").strip()).resolve()
        head = (git / "HEAD").read_text().strip()
        if not head.startswith("ref:"):
            return head
        name = head.removeprefix("ref:").strip()
        link = git / "commondir"
        common = (git / link.read_text().strip()).resolve() if link.is_file() else git
        if (common / name).is_file():
            return (common / name).read_text().strip()
        packed = (common / "packed-refs").read_text()
    except OSError:
        return None
    match = re.search(rf"^([0-9a-f]+) {re.escape(name)}$", packed, re.MULTILINE)
    return match[1] if match else None


def cpu() -> str:
    """Return the type of the processor."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        text = ""
    match = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return match[1] if match else platform.processor() or platform.machine()


def read(path: Path) -> dict[str, Any] | None:
    """Read a run.json.

    Returns
    -------
    dict or None
        None if there is none, or it is not pgimp's.
    """
    try:
        content = json.loads(read_plain(path, _LARGEST).decode())
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(content, dict) or content.get("program") != PROGRAM:
        return None
    starts = content.get("starts")
    if not isinstance(starts, list) or not all(_is_start(start) for start in starts) or not starts:
        return None
    return content | {"starts": [_sound(start) for start in starts]}


def _is_start(start: object) -> bool:
    """Return whether an entry of ``starts`` has the required keys."""
    return isinstance(start, dict) and all(
        start.get(key) is not None and _KINDS[key](start[key])
        for key in ("state", "began", "steps")
    )


def _sound(start: dict[str, Any]) -> dict[str, Any]:
    """Return a start without values that are damaged: those of another kind count as not known."""
    return {
        key: value
        for key, value in start.items()
        if value is None or key not in _KINDS or _KINDS[key](value)
    }


def _text(value: object) -> bool:
    return isinstance(value, str)


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _count(value: object) -> bool:
    return isinstance(value, int) and _number(value) and value >= 0


def _list(kind: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: isinstance(value, list) and all(map(kind, value))


def _named(kind: Callable[[object], bool]) -> Callable[[object], bool]:
    """Return a check of mappings to such values, or to null for what is not known."""
    return lambda value: (
        isinstance(value, dict) and all(each is None or kind(each) for each in value.values())
    )


#: What entries of a start are; of probes see `pgimp.io.rundir.probefiles`.
_KINDS: dict[str, Callable[[Any], bool]] = {
    **dict.fromkeys(("state", "began", "ended", "message", "cpu", "command"), _text),
    **dict.fromkeys(("working_directory", "commit"), _text),
    **dict.fromkeys(("time", "seconds", "total_seconds", "particle_steps", "courant"), _number),
    **dict.fromkeys(("steps", "resumed_from", "checkpoint", "particles", "ranks"), _count),
    **dict.fromkeys(("versions", "functions", "materials"), _named(_text)),
    "hosts": _named(_count),
    "stages": _list(_count),
    "timings": _named(_list(_number)),
}


def write(path: Path, start: dict[str, object]) -> None:
    """Write a run.json with one start.

    Parameters
    ----------
    start : dict
        From `describe_start`.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    content = {"program": PROGRAM, "format": FORMAT_VERSION, "starts": [start]}
    atomic.write(path, json.dumps(content, indent=2) + "\n")


def append(path: Path, start: dict[str, object]) -> None:
    """Add a start to a run.json.

    Parameters
    ----------
    path : Path
        The file; created if missing.
    start : dict
        From `describe_start`.

    Raises
    ------
    OSError
        If it cannot be written; the older version then stays.
    """
    content = read(path)
    if content is None:
        write(path, start)
        return
    last = content["starts"][-1]
    if last["state"] == "running":
        last |= {"state": "failed", "message": "ended without a word: killed, or its machine was"}
    content["starts"].append(start)
    atomic.write(path, json.dumps(content, indent=2) + "\n")


def update(path: Path, **changes: object) -> None:
    """Change entries of the last start in a run.json.

    Parameters
    ----------
    **changes
        The entries.

    Raises
    ------
    OSError
        If it is missing or cannot be written; an older version then stays.
    """
    content = read(path)
    if content is None:
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    content["starts"][-1].update(changes)
    atomic.write(path, json.dumps(content, indent=2) + "\n")
