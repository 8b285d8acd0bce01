"""Boundary of a mesh's cells: triangles, in 2D the segments of its outline."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.mesh.file import RawMesh
from pgimp.schema.messages import shorten, unknown

Ints = NDArray[np.int64]

#: Corners of the faces of volume cells, seen from outside anticlockwise; quadrilaterals have four.
_HEXAHEDRON = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
_FACES: dict[str, list[tuple[int, ...]]] = {
    "tetra": [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)],
    "pyramid": [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
    "wedge": [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "hexahedron": [*_HEXAHEDRON],
}
_CORNERS = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8, "triangle": 3, "quad": 4}
_DIMENSION = {"line": 1, "triangle": 2, "quad": 2, "polygon": 2} | dict.fromkeys(_FACES, 3)

#: Most groups that a note names.
_SHOWN = 20


class Facets(NamedTuple):
    """Boundary of a body: points, (n, D), and corners of its facets, (m, D).

    `cells` are the numbers of the facets' cells in the file, from 0; -1 for facets between other
    cells. `filled`: whether the cells fill the body. `notes`: findings for the user.
    """

    points: NDArray[np.float64]
    facets: Ints
    cells: Ints
    filled: bool
    notes: list[str]


class _Block(NamedTuple):
    """Cells of a kind; their numbers among those of their dimension, and among all of the file."""

    kind: str
    cells: Ints
    numbers: Ints
    places: Ints


def facets_of(mesh: RawMesh, dimensions: int, group: str | None = None) -> Facets:
    """Return the boundary of the body that a mesh, or a group of its cells, encloses.

    The cells of the highest dimension that the case has count. Volumes, and in 2D surfaces, are
    bounded by the faces that belong to only one cell. Curved cells are treated as straight.

    Raises
    ------
    CaseError
        Without the file's name, if the mesh has no such cells or group, or is damaged.
    """
    points, notes = mesh.points, []
    if points.ndim != 2 or points.shape[1] < dimensions:
        raise CaseError(f"has no points with {dimensions} coordinates")
    taken = _taken(mesh, group)
    blocks: dict[int, list[_Block]] = {}
    count, seen = 0, dict.fromkeys(range(4), 0)
    for kind, cells in mesh.cells:
        base = re.sub(r"\d+$", "", kind)
        places = count + np.arange(len(cells))
        count += len(cells)
        if cells.size == 0 or base == "vertex":
            continue
        if base not in _DIMENSION or cells.ndim != 2:
            raise CaseError(f"has cells of the type {shorten(kind)}, which are not supported")
        if base == "polygon":
            base = {3: "triangle", 4: "quad"}.get(cells.shape[1], base)
        wrong = ((cells < 0) | (cells >= len(points))).any(axis=1)
        if wrong.any():
            raise CaseError(
                f"has cells with a corner that is none of its {len(points):,} points, the first is "
                f"{base} {wrong.argmax()} (from 0): it is damaged"
            )
        if base != "polygon" and (base != kind or base == "line"):
            corners = _CORNERS.get(base, 2)
            if cells.shape[1] > corners:
                notes.append("curved cells are taken for straight ones")
            cells = cells[:, :corners]
        d = _DIMENSION[base]
        numbers = seen[d] + np.arange(len(cells))
        seen[d] += len(cells)
        if (kept := taken[places]).any():
            block = _Block(base, cells[kept], numbers[kept], places[kept])
            blocks.setdefault(d, []).append(block)
    top = max((d for d in blocks if d <= dimensions), default=0)
    if top < dimensions - 1:
        whose = "" if group is None else f" in its group '{shorten(group)}'"
        wanted = "triangles or volume cells" if dimensions == 3 else "lines, triangles or quads"
        raise CaseError(f"has no {wanted}{whose}: nothing in it encloses a part of space")
    if 3 in blocks and dimensions == 2:
        raise CaseError("has volume cells, but the case has two dimensions")
    if group is None:
        notes += _groups(mesh, np.concatenate([block.places for block in blocks[top]]))
    used = np.unique(np.concatenate([block.cells.ravel() for block in blocks[top]]))
    if len(bad := used[~np.isfinite(points[used]).all(axis=1)]):
        raise CaseError(
            f"has {len(bad):,} points that are not finite, the first is number {bad[0]} from 0"
        )
    if dimensions == 2 and points.shape[1] > 2:
        z = points[used, 2]
        if np.ptp(z) > 1e-9 * max(float(np.ptp(points[used, :2], axis=0).max()), 1e-300):
            raise CaseError("is not flat: in 2D all points must have the same z coordinate")
    points = np.ascontiguousarray(points[:, :dimensions]) + 0.0  # -0.0 and 0.0 are one point
    if top == dimensions:
        # Faces between cells with coincident but unshared corners are inside as well.
        same, first, _ = unique_rows(points.view(np.int64))
        points = points[first]
        cells_of = [(block.kind, same[block.cells]) for block in blocks[top]]
        facets = (_boundary if dimensions == 3 else _outline)(points, cells_of)
        numbers = np.full(len(facets), -1)
    else:
        # Polygons are divided into triangles; lines stay lines.
        each = [block.cells.shape[1] - 2 if dimensions == 3 else 1 for block in blocks[top]]
        facets = np.concatenate(
            [_triangles(block.cells) if dimensions == 3 else block.cells for block in blocks[top]]
        )
        numbers = np.concatenate(
            [np.repeat(block.numbers, n) for block, n in zip(blocks[top], each, strict=True)]
        )
    return Facets(points, facets, numbers, top == dimensions, list(dict.fromkeys(notes)))


def _taken(mesh: RawMesh, group: str | None) -> NDArray[np.bool_]:
    """Which cells are taken, over all blocks."""
    count = sum(len(cells) for _, cells in mesh.cells)
    if group is None:
        return np.ones(count, bool)
    if group not in mesh.groups:
        raise CaseError(f"has an {unknown('group', group, mesh.groups, 'it has')}")
    taken = np.zeros(count, bool)
    taken[mesh.groups[group]] = True
    return taken


def _groups(mesh: RawMesh, places: Ints) -> list[str]:
    """List the groups that cells at these places are in, if they are parts of what is taken."""
    numbers = {name: int(np.isin(cells, places).sum()) for name, cells in mesh.groups.items()}
    own = {name: number for name, number in numbers.items() if number}
    together = np.concatenate([mesh.groups[name] for name in own]) if own else places
    rest = int((~np.isin(places, together)).sum())
    if len(own) + (rest > 0) < 2:
        return []
    shown = [f"'{shorten(name)}' ({number:,})" for name, number in [*own.items()][:_SHOWN]]
    shown += [f"and {len(own) - _SHOWN} more"] * (len(own) > _SHOWN)
    shown += [f"cells in none ({rest:,})"] * (rest > 0)
    return [f"its groups are taken together, by cells: {', '.join(shown)}; group: takes one"]


def _triangles(faces: Ints) -> Ints:
    """Triangle fans of the faces, from each face's lowest-numbered corner, so both sides agree.

    A face may repeat its corners at its end.
    """
    n = faces.shape[1]
    if n == 3:
        return faces
    first = faces.argmin(axis=1)
    turned = faces[np.arange(len(faces))[:, None], (first[:, None] + np.arange(n)) % n]
    fans = [turned[:, [0, k, k + 1]] for k in range(1, n - 1)]
    return np.stack(fans, axis=1).reshape(-1, 3)


def _boundary(points: NDArray[np.float64], blocks: list[tuple[str, Ints]]) -> Ints:
    """Triangles of the faces that belong to one volume cell, outwards."""
    found: dict[int, list[Ints]] = {3: [], 4: []}
    for kind, cells in blocks:
        for face in _FACES[kind]:
            corners = cells[:, list(face)]
            # The faces of a cell numbered inside out are reversed.
            centre, middle = points[cells].mean(axis=1), points[corners].mean(axis=1)
            a, b = points[corners[:, 1]], points[corners[:, -1]]
            normal = np.cross(a - points[corners[:, 0]], b - points[corners[:, 0]])
            inward = ((middle - centre) * normal).sum(axis=1) < 0.0
            corners = np.where(inward[:, None], corners[:, ::-1], corners)
            found[len(face)].append(corners)
    parts = [_single(np.concatenate(faces)) for faces in found.values() if faces]
    return np.concatenate([_triangles(faces) for faces in parts])


def _outline(points: NDArray[np.float64], blocks: list[tuple[str, Ints]]) -> Ints:
    """Edges that belong to one cell in 2D, with the body on their left."""
    edges = []
    for _, cells in blocks:
        p = points[cells]
        q = np.roll(p, -1, axis=1)
        area = (p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]).sum(axis=1)
        cells = np.where((area < 0.0)[:, None], cells[:, ::-1], cells)
        edges.append(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2))
    return _single(np.concatenate(edges))


def _single(faces: Ints) -> Ints:
    """Faces that occur once, in order; faces that occur more than twice are refused."""
    keys = np.sort(faces, axis=1)
    _, first, counts = unique_rows(keys)
    if counts.max() > 2:
        raise CaseError(f"has a face that belongs to {counts.max()} cells: cells overlap")
    return faces[np.sort(first[counts == 1])]


def unique_rows(keys: Ints) -> tuple[Ints, Ints, Ints]:
    """Group number of each row, and first row and size of each group of equal rows."""
    order = np.lexsort(keys.T[::-1])
    ordered = keys[order]
    new = np.ones(len(keys), bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    starts = np.flatnonzero(new)
    group = np.empty(len(keys), np.int64)
    group[order] = np.cumsum(new) - 1
    # lexsort is stable: the first of a group is the lowest row.
    return group, order[starts], np.diff(np.append(starts, len(keys)))
