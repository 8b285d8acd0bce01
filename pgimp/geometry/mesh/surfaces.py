"""Readers of surfaces that modellers export: OBJ, STL as text; PLY is in a file of its own.

meshio refuses much of what these formats allow: indices of normals and textures, other names of
types and lists, capitals. Each reader returns points and blocks of cells, and groups of them. They
run in the process with limits of `pgimp.geometry.mesh.child`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Cells = list[tuple[str, NDArray[np.int64]]]

_KINDS = {2: "line", 3: "triangle", 4: "quad"}


class Read(NamedTuple):
    """Content of a file."""

    points: NDArray[np.float64]  #: (n, d) float64.
    cells: Cells  #: list of (str, (m, k) int64): Blocks by type.
    #: dict of str to (c,) int64: Numbers of cells over all blocks, by the names of groups.
    groups: dict[str, NDArray[np.int64]]


class Faces:
    """Faces by their number of corners, and the groups that they are in."""

    def __init__(self) -> None:
        self.corners: dict[int, list[list[int]]] = {}
        self.names: dict[int, list[str]] = {}

    def add(self, corners: list[int], name: str = "") -> None:
        """Take a face, or a line of two corners."""
        self.corners.setdefault(len(corners), []).append(corners)
        self.names.setdefault(len(corners), []).append(name)

    def read(self, points: NDArray[np.float64]) -> Read:
        """Return what was read, with the file's points."""
        cells = [
            (_KINDS.get(k, "polygon"), np.array(rows, np.int64).reshape(-1, k))
            for k, rows in self.corners.items()
        ]
        names = np.array([name for each in self.names.values() for name in each])
        groups = {name: np.flatnonzero(names == name) for name in dict.fromkeys(names.tolist())}
        groups.pop("", None)
        return Read(points, cells, groups)


def read_obj(name: str) -> Read:
    """Read Wavefront OBJ: corners and faces, and lines; not normals, textures and materials."""
    points: list[list[float]] = []
    faces, group = Faces(), ""
    with open(name, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            words = line.split()
            try:
                if not words:
                    continue
                if words[0] == "v":
                    points.append([float(word) for word in words[1:4]])
                elif words[0] in ("f", "l"):
                    corners = [int(word.partition("/")[0]) for word in words[1:]]
                    # From 1; negative ones count back from the last point so far.
                    corners = [k + len(points) if k < 0 else k - 1 for k in corners]
                    if words[0] == "f":
                        faces.add(corners, group)
                    else:
                        for ends in pairwise(corners):
                            faces.add(list(ends), group)
                elif words[0] in ("g", "o"):
                    group = " ".join(words[1:])
            except ValueError:
                raise ValueError(f"line {number}: '{line.strip()[:80]}' cannot be read") from None
    if len({len(point) for point in points}) > 1:
        raise ValueError("its points have different numbers of coordinates")
    return faces.read(np.array(points, float).reshape(len(points), -1))


def read_stl_text(name: str) -> Read:
    """Read STL as text, in any capitals: three corners of each facet."""
    corners: list[list[float]] = []
    facets: list[str] = []
    solid = ""
    with open(name, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            words = line.split()
            key = words[0].lower() if words else ""
            if key == "vertex":
                try:
                    corners.append([float(word) for word in words[1:4]])
                except ValueError:
                    corners.append([])
                if len(corners[-1]) < 3:
                    text = f"'{line.strip()[:80]}' is no corner of three numbers"
                    raise ValueError(f"line {number}: {text}")
            elif key == "solid":
                solid = " ".join(words[1:])
            elif key == "endfacet":
                facets.append(solid)
                if len(corners) != 3 * len(facets):
                    raise ValueError(f"line {number}: a facet that has not three corners")
    if len(corners) != 3 * len(facets):
        raise ValueError("it ends within a facet: it is truncated")
    numbers = np.arange(len(corners)).reshape(-1, 3)
    names = np.array(facets)
    groups = {each: np.flatnonzero(names == each) for each in dict.fromkeys(facets) if each}
    return Read(np.array(corners).reshape(-1, 3), [("triangle", numbers)], groups)
