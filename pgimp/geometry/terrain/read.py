"""Grids of heights from files: ESRI ASCII, and arrays of NumPy.

The header is read first. Of the values only those of the wanted part are kept.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import inf, prod
from pathlib import Path
from tokenize import TokenError
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.mesh.file import check_file
from pgimp.schema.messages import shorten
from pgimp.storage.plain import open_plain

Reals = NDArray[np.float64]

#: Most bytes of a file; a survey of 5000 x 5000 places has 0.2 GB.
_MOST_BYTES = 1_000_000_000
_NODATA = -9999.0

#: Most nodes of a surface: each has four triangles, of some 400 bytes.
MOST_NODES = 2_000_000

#: Bytes of text that are read at once, and of a header at most.
_BLOCK, _HEADER = 1 << 20, 1 << 16

#: Nodes beyond each end of a part, for its interpolation.
_MARGIN = 2
_ENTRY = re.compile(r"\s*([A-Za-z_]+)\s+(\S+)(?=\s)")
_KEYS = (
    "ncols nrows xllcorner xllcenter yllcorner yllcenter cellsize dx dy nodata_value".split()
)  # fmt: skip


class Heights(NamedTuple):
    """Heights at the nodes of a grid."""

    #: tuple of (n,) float64: Coordinates of the nodes by horizontal direction, ascending.
    axes: tuple[Reals, ...]
    values: Reals  #: (n, ...) float64: Heights; nan where there is none.


#: Ends of the wanted part by direction, in the file's coordinates; None where it has no end.
Ends = Sequence[tuple[float, float] | None]


def read_heights(
    name: str,
    horizontal: int,
    origin: Sequence[float] | None = None,
    spacing: Sequence[float] | None = None,
    ends: Ends = (None, None),
) -> Heights:
    """Read a grid of heights, or as much of it as a part needs.

    Parameters
    ----------
    name : str
        The file: ``.asc`` (ESRI ASCII) or ``.npy``.
    horizontal : int
        Horizontal directions, 1 or 2.
    origin, spacing : sequence of float, optional
        Place of the first node, and distance of nodes, by direction: of an array without places.
    ends : sequence of (float, float) or None
        Ends of the wanted part by direction; it is taken with nodes beyond them, where there are.

    Raises
    ------
    CaseError
        Without the file's name: an unusable file, or one that does not fit the directions.
    """
    if check_file(name, "the heights") > _MOST_BYTES:
        raise CaseError("is larger than 1 GB; take a part of it, or every other line")
    kind = Path(name).suffix.lower()
    if kind == ".asc":
        if origin is not None:
            raise CaseError("says itself where its nodes are; leave out nodes, or use translate")
        with open_plain(name) as stream:
            found = _esri(stream, horizontal, ends)
    elif kind == ".npy":
        found = _array(name, horizontal, origin, spacing, ends)
    else:
        raise CaseError("is neither .asc (ESRI ASCII) nor .npy (an array of NumPy)")
    for axis, places in zip("xy", found.axes, strict=False):
        if len(places) < 2:
            raise CaseError(f"has {len(places) or 'no'} node along {axis}; expected two or more")
        if not (np.isfinite(places).all() and (np.diff(places) > 0.0).all()):
            raise CaseError(
                f"has nodes along {axis} from {places[0]:.10g} to {places[-1]:.10g}, at places "
                "that are not finite or not apart"
            )
    return found


def _needed(low: float, step: float, count: int, ends: tuple[float, float] | None) -> slice:
    """Nodes that a part needs; all, where the part is not within them."""
    if ends is None or not (np.isfinite([low, step, *ends]).all() and step > 0.0):
        return slice(0, count)
    first, last = ((end - low) / step for end in ends)
    if not (-1.0 < first <= last < count):
        return slice(0, count)
    return slice(max(int(first) - _MARGIN, 0), min(int(last) + _MARGIN + 2, count))


def _require_few(shape: Sequence[int]) -> None:
    """Refuse, before values are read, a part of more nodes than a surface can have."""
    number = prod(max(count - 2 * _MARGIN - 1, 1) for count in shape)
    if number > MOST_NODES:
        raise CaseError(
            f"has {number:,} nodes in this part, more than {MOST_NODES:,}; take a smaller part, "
            "or every other node"
        )


def _esri(stream: BinaryIO, horizontal: int, ends: Ends) -> Heights:
    """Read an ESRI ASCII grid, whose values belong to the centres of its cells.

    Half a cell beyond the outermost centres, where its cells end, the slope at the border goes on.
    """
    head, rest = _header(stream)
    for key in ("ncols", "nrows"):
        if not (head.get(key, 0.0) >= 1.0 and head[key].is_integer()):
            raise CaseError(f"is no ESRI ASCII grid: it has no {key}, a whole number")
    if not max(head["ncols"], head["nrows"]) < 1e9:
        raise CaseError("is no ESRI ASCII grid: its ncols or nrows are above a billion")
    columns, rows = int(head["ncols"]), int(head["nrows"])
    dx, dy = (head.get(key, head.get("cellsize", 0.0)) for key in ("dx", "dy"))
    if not (0.0 < dx < inf and 0.0 < dy < inf):
        raise CaseError("is no ESRI ASCII grid: it has no cellsize above zero")
    if horizontal == 1 and rows > 1:
        raise CaseError(f"has {rows} rows of heights, but a case in 2D has a profile: one row")
    axes: list[Reals] = []
    parts: list[slice] = []
    for axis, count, step, wanted in zip("xy", (columns, rows), (dx, dy), ends, strict=True):
        if f"{axis}llcenter" in head:
            low = head[f"{axis}llcenter"]
        elif f"{axis}llcorner" in head:
            low = head[f"{axis}llcorner"] + 0.5 * step
        else:
            raise CaseError(f"is no ESRI ASCII grid: it has no {axis}llcorner or {axis}llcenter")
        parts.append(_needed(low, step, count, wanted))
    _require_few([part.stop - part.start for part in parts])
    for axis, step, part in zip("xy", (dx, dy), parts, strict=True):
        low = head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", 0.0) + 0.5 * step)
        axes.append(np.asarray(low + step * np.arange(part.start, part.stop), np.float64))
    # The first row is the north.
    south = slice(rows - parts[1].stop, rows - parts[1].start)
    values = _numbers(stream, rest, columns, rows, south, parts[0])
    values[values == head.get("nodata_value", _NODATA)] = np.nan
    values = np.ascontiguousarray(values[::-1].T)
    if horizontal == 1:
        axes, values = axes[:1], values[:, 0]
    for d, (count, part) in enumerate(zip((columns, rows), parts, strict=True)):
        if d < horizontal and len(axes[d]) > 1:
            axes[d], values = _bordered(axes[d], values, d, part.start == 0, part.stop == count)
    return Heights(tuple(axes), values)


def _bordered(
    places: Reals, values: Reals, axis: int, low: bool, high: bool
) -> tuple[Reals, Reals]:
    """Add the ends of the outermost cells, half a cell beyond their centres."""
    pairs = [(0, 1)] * low + [(-1, -2)] * high
    edges = {}
    for one, two in pairs:
        z, inner = np.take(values, one, axis), np.take(values, two, axis)
        slope = np.where(np.isfinite(inner), z - inner, 0.0)
        edges[one] = np.expand_dims(z + 0.5 * slope, axis)
    half = {one: places[one] + 0.5 * (places[one] - places[two]) for one, two in pairs}
    ends = [[half[k]] if k in half else [] for k in (0, -1)]
    around = [*[edges[k] for k in (0,) if k in edges], values, *[edges[k] for k in (-1,)
                                                                 if k in edges]]  # fmt: skip
    return np.concatenate([ends[0], places, ends[1]]), np.concatenate(around, axis=axis)


def _header(stream: BinaryIO) -> tuple[dict[str, float], bytes]:
    """Read the keys with their values, and what has been read beyond them."""
    begin = stream.read(_HEADER)
    try:
        text = begin.decode("ascii") if begin[:3] != b"\xef\xbb\xbf" else begin[3:].decode("ascii")
    except UnicodeDecodeError:
        raise CaseError("is no text: an ESRI ASCII grid begins with ncols and nrows") from None
    head: dict[str, float] = {}
    at = 0
    while (found := _ENTRY.match(text, at)) and found[1].lower() in _KEYS:
        head[found[1].lower()] = _number(found[2], found[1])
        at = found.end()
    return head, text[at:].encode()


def _numbers(
    stream: BinaryIO, rest: bytes, columns: int, rows: int, kept: slice, across: slice
) -> Reals:
    """Read rows of numbers, some at a time, and keep a part of them."""
    values = np.empty((kept.stop - kept.start, across.stop - across.start))
    waiting, row, count = np.zeros(0), 0, 0
    last = False
    while not last:
        block = stream.read(_BLOCK)
        last = not block
        rest += block
        end = len(rest) if last else max(rest.rfind(mark) for mark in (b" ", b"\n", b"\t")) + 1
        text, rest = rest[:end], rest[end:]
        if len(rest) > _BLOCK:
            raise CaseError("has a height that is no number: a word of a megabyte")
        found = _floats(text)
        waiting = np.concatenate([waiting, found])
        count += len(found)
        if count > columns * rows:
            raise CaseError(f"has more heights than ncols x nrows, {columns * rows:,}")
        whole = len(waiting) // columns
        some = waiting[: whole * columns].reshape(whole, columns)
        low, high = max(kept.start, row), min(kept.stop, row + whole)
        if low < high:
            values[low - kept.start : high - kept.start] = some[low - row : high - row, across]
        row, waiting = row + whole, waiting[whole * columns :]
    if count < columns * rows:
        raise CaseError(f"has {count:,} heights, but ncols x nrows are {columns * rows:,}")
    return values


def _floats(text: bytes) -> Reals:
    """Return the numbers of a text."""
    words = text.split()
    try:
        if b"_" in text:  # Python takes 1_0 for 10
            raise ValueError
        return np.array(words, "S").astype(np.float64) if words else np.zeros(0)
    except ValueError:
        for word in words:
            _number(word.decode(errors="replace"), "", "has a height that is no number: {text}")
        raise CaseError("has a height that is no number") from None


def _number(text: str, key: str, wrong: str = "has {key} {text}, which is no number") -> float:
    try:
        return float(text.replace("_", "no number"))
    except ValueError:
        raise CaseError(wrong.format(key=key, text=repr(shorten(text)))) from None


def _array(
    name: str,
    horizontal: int,
    origin: Sequence[float] | None,
    spacing: Sequence[float] | None,
    ends: Ends,
) -> Heights:
    """Read an array: heights by node, or in 2D also rows of x and height."""
    try:
        values = np.load(name, mmap_mode="r", allow_pickle=False)
    except (ValueError, OSError, EOFError, MemoryError, SyntaxError, TokenError) as error:
        raise CaseError(f"is no array of NumPy: {shorten(str(error))}") from None
    if values.dtype.kind not in "fiu":
        raise CaseError(f"holds {values.dtype}, and no numbers")
    if horizontal == 1 and values.ndim == 2 and values.shape[1] == 2:
        if origin is not None:
            raise CaseError("has rows of x and height; leave out nodes, or use translate")
        _require_few(values.shape[:1])
        values = values.astype(np.float64)
        if not (np.diff(values[:, 0]) > 0.0).all():
            raise CaseError("has rows of x and height, whose x must increase")
        return Heights((values[:, 0].copy(),), values[:, 1].copy())
    if values.ndim != horizontal:
        also = ", or (n, 2), rows of x and height" if horizontal == 1 else ""
        raise CaseError(
            f"has an array of {values.ndim} dimensions, expected {horizontal}{also}: heights by "
            f"{'x' if horizontal == 1 else 'x and y'}"
        )
    if origin is None or spacing is None:
        raise CaseError(
            "has heights without places: say nodes: {origin: [0.0, ..], spacing: [1.0, ..]}"
        )
    parts = [
        _needed(x, step, count, wanted)
        for x, step, count, wanted in zip(origin, spacing, values.shape, ends, strict=False)
    ]
    _require_few([part.stop - part.start for part in parts])
    axes: list[Reals] = [
        np.asarray(x + step * np.arange(part.start, part.stop), np.float64)
        for x, step, part in zip(origin, spacing, parts, strict=True)
    ]
    return Heights(tuple(axes), values[tuple(parts)].astype(np.float64))
