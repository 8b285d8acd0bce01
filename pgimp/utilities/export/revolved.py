"""Particles of axisymmetric scenes revolved about the axis, as hexahedra of a file for VTK.

A particle is the ring of its section, a square of twice its `radius`, which does not reach beyond
the axis. Corners lie on circles: N hexahedra have the volume of their ring times sin(a)/a with
a = 2 pi/N. The field `volume` is of the whole ring, as in the frame. Vectors
and tensors are turned into the directions of space, at the middle of each hexahedron. The axis
stays y, and x the radius of the section.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from pgimp.io.results.frame import FOR_READERS, Frame
from pgimp.physics.fields import components_of
from pgimp.physics.source import TENSOR
from pgimp.utilities.export.files import chosen, collection, replace, values

Array = np.ndarray

#: Components of tensors, row by row, in those of symmetric ones, and the other way round.
_ROWS, _KEPT = [0, 3, 5, 3, 1, 4, 5, 4, 2], [0, 4, 8, 1, 5, 2]

#: Corners of a section, by the sign of their offsets along the radius and the axis.
_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def solids(
    folder: Path, frames: Sequence[Frame], fields: Sequence[str], parts: int
) -> Iterator[Path]:
    """Write a VTU file of each frame's particles, revolved, and a list of them; yield their paths.

    Parameters
    ----------
    folder : Path
        The folder for them.
    fields : sequence of str
        Fields of the particles; those of the frame, if there are none.
    parts : int
        Hexahedra round the axis.
    """
    import meshio

    lines = []
    for frame in frames:
        points, cells = revolve(frame["position"], frame["radius"], parts)
        names = [name for name in frame.fields if name not in (*FOR_READERS, "position")]
        read = {
            name: [turned(name, values(name, names, frame.__getitem__), parts)]
            for name in chosen(names, fields)
        }
        mesh = meshio.Mesh(points, [("hexahedron", cells)], cell_data=read)
        path = folder / f"revolved-{frame.path.stem.partition('-')[2]}.vtu"
        replace(path, partial(mesh.write, file_format="vtu"))
        lines.append((frame.time, path))
        yield path
    if lines:
        yield collection(folder / "revolved.pvd", lines)


def revolve(position: Array, radius: Array, parts: int) -> tuple[Array, Array]:
    """Corners and cells of rings.

    Parameters
    ----------
    position : (n, 3) float
        Their middles: radius, place along the axis, 0.
    radius : (n,) float
        Half the sides of their sections.
    parts : int
        Hexahedra round the axis.

    Returns
    -------
    points : (4 parts n, 3) float64
    cells : (parts n, 8) int64
        Of one part after the other; within a part in the order of the rings.
    """
    count = len(position)
    corners = position[:, None, :2].astype(np.float64) + _CORNERS * radius[:, None, None]
    corners[:, :, 0] = np.maximum(corners[:, :, 0], 0.0)
    angle = 2.0 * np.pi * np.arange(parts) / parts
    points = np.empty((parts, count, 4, 3))
    points[..., 0] = corners[None, :, :, 0] * np.cos(angle)[:, None, None]
    points[..., 1] = corners[None, :, :, 1]
    points[..., 2] = -corners[None, :, :, 0] * np.sin(angle)[:, None, None]
    number = np.arange(parts * count * 4).reshape(parts, count, 4)
    cells = np.concatenate([np.roll(number, -1, axis=0), number], axis=2)
    return points.reshape(-1, 3), cells.reshape(-1, 8)


def turned(name: str, field: Array, parts: int) -> Array:
    """Values of a field of rings, (n, ...), in the directions of space, (parts n, ...)."""
    kind = components_of(name, field.shape[1]) if field.ndim == 2 else []
    middle = 2.0 * np.pi * (np.arange(parts) + 0.5) / parts
    c, s, zero, one = np.cos(middle), np.sin(middle), np.zeros(parts), np.ones(parts)
    # Columns are the directions of the radius, of the axis and round it.
    Q = np.array([[c, zero, s], [zero, one, zero], [-s, zero, c]]).transpose(2, 0, 1)
    if kind == ["x", "y", "z"]:
        return np.einsum("kij,nj->kni", Q, field).reshape(-1, 3)
    if kind == TENSOR.split() or (len(kind) == 9 and kind[0] == "xx"):
        whole = field[:, _ROWS] if len(kind) == 6 else field
        whole = np.einsum("kia,nab,kjb->knij", Q, whole.reshape(-1, 3, 3), Q).reshape(-1, 9)
        return whole[:, _KEPT] if len(kind) == 6 else whole
    return np.concatenate([field] * parts)
