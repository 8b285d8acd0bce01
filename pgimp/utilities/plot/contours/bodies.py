"""Bodies of a frame as a picture shows them: their outlines, and a field within."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.reader import Frame
from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.contours.outline import Outline, outline
from pgimp.utilities.plot.contours.raster import Raster, raster
from pgimp.utilities.plot.contours.smooth import TENT, smoothed
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import AXES, PlotFrame, PlotRun
from pgimp.utilities.plot.selection import Block, Selection

Array = np.ndarray

#: Points of outlines and of fields along a particle.
_FINE, _COARSE = 6.0, 2.0
#: Points along a side, at most.
_MOST_FINE, _MOST_COARSE = 1000, 300
#: Where shapes are unknown, the distance over which outlines are smoothed, in particles.
_UNKNOWN = 1.25
#: Thickness over the side of the cube of the same volume down to which outlines are as fine.
_FLAT = 0.4
_NAMES = ("body", "material", "rank", "id")


class DrawnBody(NamedTuple):
    """A body in a picture."""

    name: str  #: Its name.
    outline: Outline  #: Its outline.
    points: Raster  #: Where its field is known.
    #: ndarray, shape (rows, columns): The field there, nan away from its particles; of no rows
    #: without a field.
    values: Array


def refuse(shown: PlotRun, selection: Selection, camera: Camera, field: str) -> None:
    """Check that outlines can be drawn of a run, and contours of a field; empty for none.

    Raises
    ------
    UsageError
        If the picture is no plane, or if the field is no quantity that varies in space.
    """
    if field in _NAMES:
        raise UsageError(f"--contours: {field} is a number of particles, which nothing smooths")
    if shown.dimension < 3:
        return
    what = "--contours and --outline are for a plane"
    if len(selection.place) != 1:
        raise UsageError(f"{what}: in three dimensions cut one with --slice, such as y=0.5")
    (axis,) = selection.place
    if abs(camera.towards[axis]) < 1.0:
        raise UsageError(f"{what}: leave --camera out, or look along {AXES[axis]}")


def bodies_of(
    snapshot: PlotFrame, selection: Selection, quantity: Quantity, camera: Camera, *, field: bool
) -> list[DrawnBody]:
    """Return the bodies of a frame that have particles, in their order.

    Parameters
    ----------
    selection : Selection
        Particles of which the bodies consist.
    quantity : Quantity
        The field.
    field : bool
        Whether the field is wanted, besides the outlines.

    Raises
    ------
    UsageError
        If there is no such body.
    RunError
        If the frame cannot be read.
    """
    particles, number = _particles(snapshot.frame, selection, quantity)
    found = []
    for index in np.unique(number):
        part = particles.take(np.flatnonzero(number == index))
        drawn = _body(snapshot, selection, camera, part, field=field)
        if drawn is not None:
            found.append(DrawnBody(snapshot.frame.bodies[int(index)], *drawn))
    return found


def _particles(frame: Frame, selection: Selection, quantity: Quantity) -> tuple[Block, Array]:
    """Return the selected particles of a frame, and the number of the body of each."""
    blocks = list(selection.blocks(frame, quantity))
    numbers = [block.value for block in selection.blocks(frame, Quantity("body", "body", None))]
    whole = Block(*(np.concatenate(columns) for columns in zip(*blocks, strict=True)))
    return whole, np.concatenate(numbers).astype(np.int64)


def _body(
    snapshot: PlotFrame, selection: Selection, camera: Camera, part: Block, *, field: bool
) -> tuple[Outline, Raster, Array] | None:
    """Return outline and field of particles; none if they are without size."""
    known = part.edges.size > 0
    edges = part.edges if known else _unturned(part.radius, selection.spacing)
    part = part._replace(edges=edges).take(
        np.flatnonzero((part.radius > 0.0) & (np.linalg.det(edges) != 0.0))
    )
    if not len(part.id):
        return None
    box = np.abs(part.edges).sum(axis=1)
    for axis, low, high in _periodic(snapshot.shown):
        margin = 2.0 * TENT * float(np.median(box[:, axis])) + 2.0 * (high - low) / _MOST_COARSE
        part = _around(part, axis, (low, high), margin)
    centre = camera.project(part.position)
    level = next(iter(selection.place.items()), None)
    centre[:, 2] -= camera.project(level[1] * np.eye(3)[level[0]])[2] if level else centre[:, 2]
    edges = camera.project(part.edges)
    half = np.abs(edges).sum(axis=1)[:, :2]
    size = 2.0 * np.median(half, axis=0)
    low, high = (centre[:, :2] - half).min(axis=0), (centre[:, :2] + half).max(axis=0)
    fixed = np.zeros(2, bool)
    for axis, first, last in _periodic(snapshot.shown):
        ends = np.sort(camera.project(np.array([[first], [last]]) * np.eye(3)[axis])[:, :2], axis=0)
        side = int(np.argmax(ends[1] - ends[0]))
        # Bodies that do not reach the face end where their particles do.
        reaches = low[side] < ends[0, side] or high[side] > ends[1, side]
        fixed[side] = reaches and last > first and bool(np.ptp(ends[:, side]) > 0.0)
        if fixed[side]:
            low[side], high[side] = ends[:, side]
    fine = raster(low, high, np.full(2, _thickness(edges) / _FINE), fixed, _MOST_FINE)
    size = size if known else np.full(2, size.max())
    edge = outline(centre, edges, fine, _UNKNOWN * float(size.max()))
    points = raster(low, high, size / _COARSE, fixed, _MOST_COARSE)
    if not field:
        return edge, points, np.zeros((0, 0))
    # Of a section, those in whose middle it is count most.
    depth = np.abs(edges[:, :, 2]).sum(axis=1)
    weight = np.abs(np.linalg.det(edges)) * np.maximum(1.0 - np.abs(centre[:, 2]) / depth, 0.0)
    return edge, points, smoothed(centre[:, :2], part.value, weight, size, points)


def _thickness(edges: Array) -> float:
    """Return the least distance of opposite faces of most particles, very flat ones apart."""
    least = 2.0 / np.linalg.norm(np.linalg.inv(edges), axis=1).max(axis=1)
    side = 2.0 * np.abs(np.linalg.det(edges)) ** (1.0 / 3.0)
    return float(np.median(np.maximum(least, _FLAT * side)))


def _unturned(radius: Array, spacing: Sequence[float]) -> Array:
    """Return half the edges of particles of unknown deformation, (n, 3, 3), of their volume."""
    sides = np.array(spacing) if spacing else np.ones(1)
    shape = np.ones(3)
    shape[: len(sides)] = sides / sides.prod() ** (1.0 / len(sides))
    return radius[:, None, None] * np.diag(shape)


def _periodic(shown: PlotRun) -> list[tuple[int, float, float]]:
    """Return the directions of a run with periodic faces: axis and ends."""
    faces = shown.case.get("boundaries") or {}
    low, high = shown.corners
    return [
        (axis, low[axis], high[axis])
        for axis in range(shown.dimension)
        if "periodic" in str(faces.get(f"{AXES[axis]}-min", ""))
    ]


def _around(part: Block, axis: int, ends: tuple[float, float], margin: float) -> Block:
    """Return particles together with their images beyond both periodic faces, as far as needed."""
    place = part.position[:, axis]
    low, high = ends
    blocks = [part]
    for shift, near in ((low - high, place > high - margin), (high - low, place < low + margin)):
        image = part.take(np.flatnonzero(near))
        image.position[:, axis] += shift
        blocks.append(image)
    return Block(*(np.concatenate(columns) for columns in zip(*blocks, strict=True)))
