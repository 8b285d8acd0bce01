"""Reading files of comma-separated values, also while they grow or after foreign changes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pgimp.errors import RunError, UsageError, explain
from pgimp.storage.plain import open_plain

# Most bytes of a line; a hundred columns have 2,000.
_LONGEST = 1 << 20
_BLOCK = 4096


def numbered(stream: BinaryIO) -> tuple[bytes, Iterator[tuple[int, bytes]]]:
    """Return the line of names, and each further complete line with its step.

    Raises
    ------
    ValueError, IndexError
        If a line has no step.
    """
    header = stream.readline(_LONGEST)
    column = header.rstrip(b"\n").split(b",").index(b"step")

    def lines() -> Iterator[tuple[int, bytes]]:
        while (line := stream.readline(_LONGEST)).endswith(b"\n"):
            yield int(line.split(b",")[column]), line

    return header, lines()


def require_whole(path: Path, step: int, count: int | None) -> None:
    """Refuse a file with missing or reordered lines up to a step.

    A file that is missing, unreadable or too short passes: `LineFile.resume` reports it.

    Parameters
    ----------
    step : int
        Step of the last line before the point from which a run resumes.
    count : int or None
        Number of lines up to and including that line; None if unknown.

    Raises
    ------
    UsageError
        With the wrong line.
    """
    advice = "put the file back as it was, or move it away, and the run goes on with a new one"
    if step < 0:
        return
    last, there, widest = -1, 0, (0, 0, 0, 0)
    try:
        with open_plain(path) as stream:
            for line, (number, _) in enumerate(numbered(stream)[1], start=2):
                if number <= last:
                    raise UsageError(f"{path}:{line}: step {number} follows step {last}; {advice}")
                if number > step:
                    raise UsageError(
                        f"{path}:{line}: step {number} follows step {last}, but there was a line "
                        f"of step {step}; {advice}"
                    )
                there += 1
                widest = max(widest, (number - max(last, 0), -line, last, number))
                last = number
                if number == step:
                    break
    except (OSError, ValueError, IndexError):
        return
    if last == step and count is not None and there != count:
        _, line, before, after = widest
        where = f"the widest gap is from step {max(before, 0)} to step {after}"
        raise UsageError(
            f"{path}:{-line}: there are {there} lines up to step {step}, but there were {count}; "
            f"{where}; {advice}"
        )


def so_far(directory: Path) -> dict[str, object]:
    """Return the progress of a run from the last line of its history.

    Returns
    -------
    dict
        ``steps`` and ``time``, as in run.json at the end; empty if unknown.
    """
    try:
        with open_plain(directory / "history.csv") as stream:
            names = stream.readline(_LONGEST).decode().rstrip("\n").split(",")
            begin = stream.tell()
            stream.seek(max(begin, stream.seek(0, os.SEEK_END) - _LONGEST))
            last = stream.read(_LONGEST).rpartition(b"\n")[0].rpartition(b"\n")[2]
        found = dict(zip(names, last.decode().split(","), strict=True))
        return {"steps": int(found["step"]), "time": float(found["time"])}
    except (OSError, ValueError, KeyError):
        return {}


def read(path: Path) -> np.ndarray:
    """Read such a file, also while it grows.

    Returns
    -------
    ndarray, shape (lines,)
        A structured array with a field of float64 for each column, nan for empty entries; no lines
        if there is no file.

    Raises
    ------
    RunError
        If it cannot be read or is damaged.
    """
    blocks: list[np.ndarray] = []
    rows: list[tuple[float, ...]] = []
    number = width = 1
    names = np.dtype([])
    try:
        with open_plain(path) as stream:
            # The last line may be incomplete or empty.
            while (line := stream.readline(_LONGEST)).endswith(b"\n"):
                text = line.decode(errors="replace").rstrip("\r\n").split(",")
                if number == 1:
                    names = np.dtype([(name, np.float64) for name in text])
                    width = len(text)
                else:
                    rows.append(tuple(float(value or "nan") for value in text))
                    if len(text) != width:
                        raise ValueError(f"{len(text)} values in {width} columns")
                number += 1
                if len(rows) == _BLOCK:
                    blocks.append(np.array(rows, names))
                    rows = []
            if len(line) == _LONGEST:
                raise ValueError(f"no line has {_LONGEST:,} bytes")
    except FileNotFoundError:
        pass
    except OSError as error:
        raise RunError(f"cannot read {path}: {explain(error)}") from error
    except ValueError as error:
        raise RunError(f"{path}, line {number} is damaged: {str(error)[:80]!r}") from error
    return np.concatenate([*blocks, np.array(rows, names)])
