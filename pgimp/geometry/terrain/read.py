"""Grids of heights from files: ESRI ASCII, and arrays of NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path
from tokenize import TokenError
from typing import NamedTuple

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
_KEYS = (
    "ncols nrows xllcorner xllcenter yllcorner yllcenter cellsize dx dy nodata_value".split()
)  # fmt: skip


class Heights(NamedTuple):
    """Heights at the nodes of a grid.

    Attributes
    ----------
    axes : tuple of (n,) float64
        Coordinates of the nodes by horizontal direction, ascending.
    values : (n, ...) float64
        Heights; nan where there is none.
    """

    axes: tuple[Reals, ...]
    values: Reals


def read_heights(
    name: str,
    horizontal: int,
    origin: Sequence[float] | None = None,
    spacing: Sequence[float] | None = None,
) -> Heights:
    """Read a grid of heights.

    Parameters
    ----------
    name : str
        The file: ``.asc`` (ESRI ASCII) or ``.npy``.
    horizontal : int
        Horizontal directions, 1 or 2.
    origin, spacing : sequence of float, optional
        Place of the first node, and distance of nodes, by direction: of an array without places.

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
        found = _esri(name)
        if horizontal == 1:
            if len(found.axes[1]) > 1:
                raise CaseError(
                    f"has {len(found.axes[1])} rows of heights, but a case in 2D has a profile: "
                    "one row"
                )
            found = Heights(found.axes[:1], found.values[:, 0])
    elif kind == ".npy":
        found = _array(name, horizontal, origin, spacing)
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


def _esri(name: str) -> Heights:
    """Read an ESRI ASCII grid, whose values belong to the centres of its cells."""
    with open_plain(name) as stream:
        try:
            text = stream.read().decode("utf-8-sig")
        except UnicodeDecodeError:
            raise CaseError("is no text: an ESRI ASCII grid begins with ncols and nrows") from None
    words = text.split()
    head: dict[str, float] = {}
    first = 0
    while first + 1 < len(words) and words[first].lower() in _KEYS:
        head[words[first].lower()] = _number(words[first + 1], words[first])
        first += 2
    for key in ("ncols", "nrows"):
        if not (head.get(key, 0.0) >= 1.0 and head[key].is_integer()):
            raise CaseError(f"is no ESRI ASCII grid: it has no {key}, a whole number")
    if not max(head["ncols"], head["nrows"]) < 1e9:
        raise CaseError("is no ESRI ASCII grid: its ncols or nrows are above a billion")
    columns, rows = int(head["ncols"]), int(head["nrows"])
    dx, dy = (head.get(key, head.get("cellsize", 0.0)) for key in ("dx", "dy"))
    if not (0.0 < dx < inf and 0.0 < dy < inf):
        raise CaseError("is no ESRI ASCII grid: it has no cellsize above zero")
    if len(words) - first != columns * rows:
        raise CaseError(
            f"has {len(words) - first:,} heights, but ncols x nrows are {columns * rows:,}"
        )
    if text.count("_") > sum(word.count("_") for word in words[:first]):
        wrong = next(word for word in words[first:] if "_" in word)  # Python takes 1_0 for 10
        raise CaseError(f"has a height that is no number: {shorten(wrong)!r}")
    try:
        values = np.array(words[first:], float).reshape(rows, columns)
    except ValueError as error:
        raise CaseError(f"has a height that is no number: {shorten(str(error))}") from None
    values[values == head.get("nodata_value", _NODATA)] = np.nan
    axes: list[Reals] = []
    for axis, count, step in (("x", columns, dx), ("y", rows, dy)):
        if f"{axis}llcenter" in head:
            low = head[f"{axis}llcenter"]
        elif f"{axis}llcorner" in head:
            low = head[f"{axis}llcorner"] + 0.5 * step
        else:
            raise CaseError(f"is no ESRI ASCII grid: it has no {axis}llcorner or {axis}llcenter")
        axes.append(np.asarray(low + step * np.arange(count), np.float64))
    return Heights(tuple(axes), np.ascontiguousarray(values[::-1].T))  # the first row is the north


def _number(text: str, key: str) -> float:
    try:
        return float(text.replace("_", "no number"))
    except ValueError:
        raise CaseError(f"has {key} {shorten(text)!r}, which is no number") from None


def _array(
    name: str, horizontal: int, origin: Sequence[float] | None, spacing: Sequence[float] | None
) -> Heights:
    """Read an array: heights by node, or in 2D also rows of x and height."""
    try:
        with open_plain(name) as stream:
            values = np.asarray(np.load(stream, allow_pickle=False))
    except (ValueError, OSError, EOFError, MemoryError, SyntaxError, TokenError) as error:
        raise CaseError(f"is no array of NumPy: {shorten(str(error))}") from None
    if values.dtype.kind not in "fiu":
        raise CaseError(f"holds {values.dtype}, and no numbers")
    values = values.astype(np.float64)
    if horizontal == 1 and values.ndim == 2 and values.shape[1] == 2:
        if origin is not None:
            raise CaseError("has rows of x and height; leave out nodes, or use translate")
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
    axes: list[Reals] = [
        np.asarray(x + step * np.arange(count), np.float64)
        for x, step, count in zip(origin, spacing, values.shape, strict=True)
    ]
    return Heights(tuple(axes), values)
