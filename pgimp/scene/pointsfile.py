"""The user's own particles, read block by block from an HDF5 or a CSV file.

HDF5: datasets `position` (n, D), `volume` (n,), and if wanted `velocity` (n, D), `stress` (n, 6);
vectors may have three columns in any dimension, as in the frames of a run. CSV: a line of names,
`x, y, z, volume, velocity-x, ..., stress-xx, ...`, then a line for each particle; empty lines and
those that begin with # do not count.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.scene.meshfile import check_file

Reals = NDArray[np.float64]

#: Rows, and bytes of text, that are read at a time; the largest chunk of a dataset [bytes].
_BLOCK, _TEXT, _CHUNK = 200_000, 8_000_000, 256_000_000

_STRESS = ("xx", "yy", "zz", "xy", "yz", "xz")


class Block(NamedTuple):
    """Some particles, rows `first` onwards: (n, D), (n,), and (n, D) and (n, 6) where given.

    `lines` are their places in the file for people, "row 0" or "line 2".
    """

    first: int
    position: Reals
    volume: Reals
    velocity: Reals | None
    stress: Reals | None
    lines: Any

    def place(self, row: int) -> str:
        """Where a row of the block stands in the file, for people."""
        return self.lines(row)


def blocks(name: str, dimensions: int) -> Iterator[Block]:
    """Yield the particles of a file.

    Raises
    ------
    CaseError
        With the file, the row, and what is wrong.
    """
    check_file(name, "the particles")
    ending = Path(name).suffix.lower()
    if ending in (".h5", ".hdf5"):
        found = _hdf5(name, dimensions)
    elif ending in (".csv", ".txt"):
        found = _csv(name, dimensions)
    else:
        raise CaseError(
            f"cannot read the particles {name}: its name must end in .h5, .hdf5 or .csv, not "
            f"'{ending}'"
        )
    try:
        yield from found
    except CaseError as error:
        raise CaseError(f"cannot use the particles {name}: {error}") from None
    except (OSError, RuntimeError, UnicodeDecodeError, KeyError, ValueError, MemoryError) as error:
        text = " ".join(str(error).split())[:200]
        raise CaseError(
            f"cannot read the particles {name}: {text or type(error).__name__}; it is damaged or "
            "no file of its kind: write it anew"
        ) from None


def _hdf5(name: str, D: int) -> Iterator[Block]:
    from pgimp.output.hdf5 import load_h5py, open_file

    h5py = load_h5py()
    with open_file(Path(name), "r") as file:
        data = {}
        for key, columns in (("position", D), ("volume", 1), ("velocity", D), ("stress", 6)):
            if key in file:
                data[key] = _dataset(h5py, file[key], key, columns)
            elif key in ("position", "volume"):
                raise CaseError(f"it has no dataset '{key}'; expected position and volume")
        count = len(data["position"])
        for key, dataset in data.items():
            if len(dataset) != count:
                raise CaseError(f"{len(dataset):,} rows of {key}, but {count:,} of position")
        for first in range(0, count, _BLOCK):
            rows = {k: np.asarray(d[first : first + _BLOCK], float) for k, d in data.items()}
            for key in ("position", "velocity"):
                if key in rows:
                    beyond = rows[key][:, D:]
                    if len(bad := np.flatnonzero((beyond != 0.0).any(axis=1))):
                        raise CaseError(
                            f"row {first + bad[0]} (from 0): {key} has a part along a direction "
                            f"that the case, {D}D, does not have"
                        )
                    rows[key] = rows[key][:, :D]
            yield Block(
                first, rows["position"], rows["volume"].reshape(-1), rows.get("velocity"),
                rows.get("stress"), lambda row, first=first: f"row {first + row} (from 0)",
            )  # fmt: skip


def _dataset(h5py: Any, data: Any, key: str, columns: int) -> Any:
    """Check the type and shape of a dataset."""
    allowed = {1: ((), (1,)), 6: ((6,),)}.get(columns, ((columns,), (3,)))
    if key != "volume" and columns == 1:
        allowed = ((), (1,), (3,))
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in "fiu":
        raise CaseError(f"'{key}' is no dataset of numbers")
    if data.ndim == 0 or data.shape[1:] not in allowed:
        wanted = " or ".join(str(("n", *shape)).replace("'", "") for shape in allowed)
        raise CaseError(f"'{key}' has the shape {data.shape}; expected {wanted}")
    if data.chunks and np.prod(data.chunks, dtype=float) * data.dtype.itemsize > _CHUNK:
        raise CaseError(f"'{key}' is stored in chunks of {data.chunks}; use smaller ones")
    if key in ("position", "velocity") and data.ndim == 1:
        return _Column(data)
    return data


class _Column:
    """A vector in 1D that is stored as a plain list."""

    def __init__(self, data: Any) -> None:
        self.data = data

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, rows: slice) -> Reals:
        return self.data[rows][:, None]


def _csv(name: str, D: int) -> Iterator[Block]:
    axes = "xyz"[:D]
    velocity = [f"velocity-{axis}" for axis in axes]
    stress = [f"stress-{part}" for part in _STRESS]
    head: list[str] | None = None
    first = 0
    for line, text in _text(name):
        lines = text.split("\n")
        kept = [
            (line + i, row) for i, row in enumerate(lines) if row.strip() and row.lstrip()[0] != "#"
        ]
        if head is None and kept:
            head = [word.strip().lower() for word in kept[0][1].split(",")]
            _check_head(head, D, velocity, stress)
            kept = kept[1:]
        if not kept or head is None:
            continue
        values = _numbers(kept, len(head))
        column = {key: values[:, i] for i, key in enumerate(head)}

        def taken(keys: list[str], column: dict[str, Reals] = column) -> Reals | None:
            return np.stack([column[k] for k in keys], axis=1) if keys[0] in column else None

        position = taken(list(axes))
        assert position is not None
        yield Block(
            first, position, column["volume"], taken(velocity), taken(stress),
            lambda row, kept=kept: f"line {kept[row][0]}",
        )  # fmt: skip
        first += len(values)
    if head is None:
        raise CaseError("it has no line of names, such as x,y,z,volume")


def _check_head(head: list[str], D: int, velocity: list[str], stress: list[str]) -> None:
    """Check the names of the columns: each group is there altogether, or not at all."""
    needed = [*"xyz"[:D], "volume"]
    known = [*needed, *velocity, *stress]
    example = ",".join(needed)
    if missing := [key for key in needed if key not in head]:
        raise CaseError(
            f"its first line names no column {', '.join(missing)}; expected {example} and, if "
            f"wanted, {', '.join(velocity)} and {stress[0]} to {stress[-1]}"
        )
    if strange := [key for key in head if key not in known]:
        raise CaseError(f"unknown column '{strange[0][:40]}'; known: {', '.join(known)}")
    if len(set(head)) < len(head):
        raise CaseError("its first line names a column twice")
    for group in (velocity, stress):
        there = [key in head for key in group]
        if any(there) and not all(there):
            raise CaseError(f"column {group[there.index(False)]} is missing beside the others")


def _text(name: str) -> Iterator[tuple[int, str]]:
    """Yield whole lines of a file, some megabytes at a time, with the number of the first."""
    line, rest = 1, b""
    with open(name, "rb") as file:
        while part := file.read(_TEXT):
            whole, newline, rest_of_part = (rest + part).rpartition(b"\n")
            if not newline:
                rest += part
                if len(rest) > _TEXT:
                    raise CaseError(f"line {line} is longer than {_TEXT:,} characters: no CSV file")
                continue
            rest = rest_of_part
            text = whole.decode("utf-8-sig")
            yield line, text
            line += text.count("\n") + 1
    if rest:
        yield line, rest.decode("utf-8-sig")


def _numbers(kept: list[tuple[int, str]], columns: int) -> Reals:
    """Numbers of lines, (n, columns)."""
    try:
        source = io.StringIO("\n".join(row for _, row in kept))
        values = np.loadtxt(source, delimiter=",", ndmin=2, comments=None)
        if values.shape == (len(kept), columns):
            return values
    except ValueError:
        pass
    for number, row in kept:
        words = row.split(",")
        if len(words) != columns:
            raise CaseError(f"line {number}: {len(words)} values, expected {columns}")
        for word in words:
            try:
                float(word)
            except ValueError:
                raise CaseError(f"line {number}: '{word.strip()[:40]}' is no number") from None
    raise CaseError(f"line {kept[0][0]} and those after it are no numbers")
