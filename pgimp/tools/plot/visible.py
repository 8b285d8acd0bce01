"""The particles that can be seen: of many, the nearest to the eye in each spot of the picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.io.results.reader import Frame
from pgimp.tools.plot.camera import Camera
from pgimp.tools.plot.quantity import Quantity
from pgimp.tools.plot.selection import Block, Selection

Array = np.ndarray

FEW = 20_000
"""So many particles are all drawn, each as a polygon."""

SPOTS = 1000
"""Spots along the longer side of a picture with more of them."""


class Extent(NamedTuple):
    """What particles fill of a picture.

    Attributes
    ----------
    low, high : ndarray, shape (2,)
        Corners; `low` above `high` if there are no particles.
    number : int
        Number of particles.
    """

    low: Array
    high: Array
    number: int

    def union(self, other: Extent) -> Extent:
        """Return the extent of both."""
        low, high = np.minimum(self.low, other.low), np.maximum(self.high, other.high)
        return Extent(low, high, self.number + other.number)

    @property
    def size(self) -> Array:
        """Width and height, at least a thousandth of each other."""
        size = self.high - self.low
        return np.maximum(size, max(1e-3 * size.max(), np.finfo(float).tiny))


NOTHING = Extent(np.full(2, np.inf), np.full(2, -np.inf), 0)


class Visible(NamedTuple):
    """Particles to draw, from the back to the front.

    Attributes
    ----------
    particles : Block
        The particles.
    place : ndarray, shape (n, 2)
        Their centres in the picture.
    total : int
        How many there were to choose from.
    spot : float
        Size of the spots by which they were chosen; 0 if these are all.
    """

    particles: Block
    place: Array
    total: int
    spot: float


def extent(frame: Frame, selection: Selection, camera: Camera, dimension: int) -> Extent:
    """Measure a frame.

    Parameters
    ----------
    frame : Frame
        The frame.
    selection : Selection
        The particles.
    camera : Camera
        The projection.
    dimension : int
        Of the case.

    Returns
    -------
    Extent
        What they fill.
    """
    reach = np.abs(camera.generators(dimension)).sum(axis=0)
    found = NOTHING
    for block in selection.blocks(frame, None):
        if len(block.radius):
            place = camera.project(block.position)[:, :2]
            half = block.radius[:, None] * reach
            low, high = (place - half).min(axis=0), (place + half).max(axis=0)
            found = found.union(Extent(low, high, len(block.radius)))
    return found


def visible(
    frame: Frame, selection: Selection, quantity: Quantity, camera: Camera, inside: Extent
) -> Visible:
    """Choose the particles to draw, in memory that does not grow with their number.

    Parameters
    ----------
    frame : Frame
        The frame.
    selection : Selection
        Which to choose from.
    quantity : Quantity
        What is drawn of them.
    camera : Camera
        The projection.
    inside : Extent
        What they fill, or more.

    Returns
    -------
    Visible
        All, if there are few; otherwise for each spot the one whose centre is nearest to the eye,
        of equally near ones that with the greatest id.
    """
    few = len(frame) <= FEW
    spot = 0.0 if few else float(inside.size.max()) / SPOTS
    kept: Block | None = None
    keys = np.empty(0, dtype=np.int64)
    total = 0
    for block in selection.blocks(frame, quantity):
        total += len(block.radius)
        merged = block if kept is None else _join(kept, block)
        if few:
            kept = merged
            continue
        place = camera.project(block.position)
        columns = np.int64(np.ceil(inside.size[0] / spot)) + 1
        cell = np.floor((place[:, :2] - inside.low) / spot).astype(np.int64)
        keys = np.concatenate([keys, cell[:, 1] * columns + cell[:, 0]])
        depth = camera.project(merged.position)[:, 2]
        order = np.lexsort((merged.id, depth, keys))
        last = np.append(keys[order][1:] != keys[order][:-1], True)[: len(order)]
        rows = order[last]
        kept, keys = merged.take(rows), keys[rows]
    assert kept is not None or total == 0
    if kept is None:
        kept = Block(*np.empty((5, 0)))._replace(position=np.empty((0, 3)))
    place = camera.project(kept.position)
    order = np.lexsort((kept.id, place[:, 2]))
    return Visible(kept.take(order), place[order, :2], total, spot)


def _join(first: Block, second: Block) -> Block:
    return Block(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))


def paint(seen: Visible, camera: Camera, dimension: int, inside: Extent) -> Array:
    """Paint particles as an image.

    Parameters
    ----------
    seen : Visible
        The particles, chosen by spots.
    camera : Camera
        The projection.
    dimension : int
        Of the case.
    inside : Extent
        What the image shows.

    Returns
    -------
    ndarray, shape (rows, columns)
        The value in each spot, from the lower left; nan where there is no particle.
    """
    columns, rows = np.ceil(inside.size / seen.spot).astype(np.int64)
    front = np.full(rows * columns, -1, dtype=np.int64)
    edges = camera.generators(dimension)
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    reach = np.abs(normals @ edges.T).sum(axis=1)
    centre = (seen.place - inside.low) / seen.spot
    home = np.floor(centre).astype(np.int64)
    radius = seen.particles.radius / seen.spot
    steps = np.ceil(radius * np.abs(edges).sum(axis=0).max()).astype(np.int64)
    steps = np.minimum(steps, SPOTS)
    for size in np.unique(steps):
        some = np.flatnonzero(steps == size)
        for dx in range(-size, size + 1):
            for dy in range(-size, size + 1):
                spot = home[some] + (dx, dy)
                away = np.abs((spot + 0.5 - centre[some]) @ normals.T)
                covered = (away <= radius[some, None] * reach).all(axis=1)
                if dx == 0 and dy == 0:
                    covered[:] = True  # none is too small to be seen
                covered &= ((spot >= 0) & (spot < (columns, rows))).all(axis=1)
                at = spot[covered, 1] * columns + spot[covered, 0]
                # Rows rise from the back to the front.
                np.maximum.at(front, at, some[covered])
    image = np.append(seen.particles.value, np.nan)[front]
    return image.reshape(rows, columns)
