"""Selection of a frame's particles to draw, read block by block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.reader import Frame
from pgimp.schema.messages import unknown
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import AXES

Array = np.ndarray

_BLOCK_ROWS = 1 << 19
#: Half the longest side of a particle that is drawn, in initial distances: one that has exploded
#: would hide all others.
_LARGEST = 3.0
_TOUCHING = 1.0 + 1.0e-6


class Block(NamedTuple):
    """A block of a frame's particles, in ascending id."""

    id: Array  #: ndarray of int64, shape (n,): Ids.
    position: Array  #: ndarray of float64, shape (n, 3): Centres.
    radius: Array  #: ndarray of float64, shape (n,): Half the side of their boxes.
    value: Array  #: ndarray of float64, shape (n,): Values of the drawn quantity.
    volume: Array  #: ndarray of float64, shape (n,): Volumes.
    #: ndarray of float64, shape (n, 3, 3), or (n, 0, 0): Half the edges of the parallelepipeds that
    #: the boxes have become, a row each; none where the frame has no deformation.
    edges: Array

    def take(self, rows: Array) -> Block:
        """Return the block with only the given rows."""
        return Block(*(column[rows] for column in self))

    def with_image(self, axis: int, place: float) -> Block:
        """Return the block together with its image at a plane across an axis.

        Values are those of the particles: a vector's component across the plane keeps its sign.
        """
        position, edges = self.position.copy(), self.edges.copy()
        position[:, axis] = 2.0 * place - position[:, axis]
        if edges.size:
            edges[:, :, axis] *= -1.0
        image = self._replace(position=position, edges=edges)
        return Block(*(np.concatenate(pair) for pair in zip(self, image, strict=True)))

    def revolved(self, angles: Array) -> Block:
        """Return the block of rings about the axis y, a piece of each ring at each angle.

        Parameters
        ----------
        angles : (k,) float
            Middles of the pieces about y, in radians, in equal distances; at 0 a ring is along x.

        Returns
        -------
        Block
            k times as many particles, with edges.
        """
        n, k = len(self.radius), len(angles)
        edges = self.edges
        if not edges.size:
            edges = self.radius[:, None, None] * np.eye(3)
        c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
        position = np.empty((k, n, 3))
        turned = np.empty((k, n, 3, 3))
        for row, found in [(self.position, position)] + [
            (edges[:, side], turned[:, :, side]) for side in (0, 1)
        ]:
            found[..., 0], found[..., 1], found[..., 2] = c * row[:, 0], row[:, 1], -s * row[:, 0]
        half = np.tan(0.5 * (angles[1] - angles[0])) * np.abs(self.position[:, 0])
        turned[:, :, 2, 0], turned[:, :, 2, 1], turned[:, :, 2, 2] = -s * half, 0.0, -c * half
        rest = (np.tile(each, k) for each in (self.id, self.radius, self.value, self.volume))
        number, radius, value, volume = rest
        places, sides = position.reshape(-1, 3), turned.reshape(-1, 3, 3)
        return Block(number, places, radius, value, volume, sides)


class Selection(NamedTuple):
    """A selection of particles."""

    bodies: tuple[str, ...] = ()  #: Names of bodies; all if empty.
    #: By axis, the coordinate of a plane that cuts the particles' boxes.
    place: Mapping[int, float] = {}
    #: Initial distance of the particles by axis; if empty, they are squares and cubes.
    spacing: tuple[float, ...] = ()
    #: tuple of (int, float): Planes of symmetry, by axis and coordinate, at which their images are
    #: added.
    mirrored: tuple[tuple[int, float], ...] = ()
    #: Angles about the axis y at which pieces of rings are drawn; if empty, their section is.
    angles: tuple[float, ...] = ()

    def blocks(self, frame: Frame, quantity: Quantity | None) -> Iterator[Block]:
        """Iterate over the selected particles.

        Parameters
        ----------
        quantity : Quantity or None
            The drawn quantity; with None values, ids and volumes are left out.

        Raises
        ------
        UsageError
            If there is no such body.
        RunError
            If the frame cannot be read.
        """
        for name in self.bodies:
            if name not in frame.bodies:
                raise UsageError(f"{frame.path}: {unknown('body', name, frame.bodies, 'it has')}")
        chosen = [frame.bodies.index(name) for name in self.bodies]
        step = max(1, _BLOCK_ROWS // max(1, len(self.angles)))
        for first in range(0, len(frame), step):
            last = min(first + step, len(frame))
            position = frame.rows("position", first, last).astype(np.float64)
            radius = frame.rows("radius", first, last).astype(np.float64)
            if self.spacing:
                radius = np.minimum(radius, _LARGEST * max(self.spacing))
            keep = np.isfinite(position).all(axis=1)
            if chosen:
                keep &= np.isin(frame.rows("body", first, last), chosen)
            for axis, place in self.place.items():
                keep &= np.abs(position[:, axis] - place) <= radius * _TOUCHING
            rows = np.flatnonzero(keep)
            none = np.empty(len(radius))
            full = quantity is not None
            block = Block(
                frame.rows("id", first, last) if full else none,
                position,
                radius,
                quantity.rows(frame, first, last) if quantity is not None else none,
                frame.rows("volume", first, last).astype(np.float64) if full else none,
                self._edges(frame, first, last, radius) if full else np.empty((len(none), 0, 0)),
            ).take(rows)
            for plane in self.mirrored:
                block = block.with_image(*plane)
            if self.angles:
                block = block.revolved(np.array(self.angles))
            yield block

    def _edges(self, frame: Frame, first: int, last: int, radius: Array) -> Array:
        """Half the edges of the particles' parallelepipeds, as large as their boxes."""
        if not self.spacing or "deformation" not in frame:
            return np.empty((last - first, 0, 0))
        D = len(self.spacing)
        F = frame.rows("deformation", first, last).astype(np.float64).reshape(-1, 3, 3)
        edges = np.zeros((last - first, 3, 3))
        edges[:, :D, :D] = F[:, :D, :D].transpose(0, 2, 1) * np.array(self.spacing)[:, None]
        # Whatever the initial size was, cut by a surface or of a ring, now it is that of the box.
        size = np.abs(np.linalg.det(edges[:, :D, :D])) ** (1.0 / D)
        longest = np.linalg.norm(edges, axis=2).max(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = np.minimum(radius / size, _LARGEST * max(self.spacing) / longest)
        edges *= np.where(np.isfinite(factor), factor, 0.0)[:, None, None]
        for axis in range(D, 3):
            edges[:, axis, axis] = radius
        return edges


def empty(frame: Frame, place: Mapping[int, float]) -> UsageError:
    """Return the error of an empty selection, with the available range."""
    if not len(frame):
        return UsageError(f"{frame.path} has no particles: all have left the domain")
    if not place:
        return UsageError(f"{frame.path} has no such particle")
    axes = sorted(place)
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for block in Selection().blocks(frame, None):
        if len(block.radius):
            low = np.minimum(low, (block.position - block.radius[:, None]).min(axis=0))
            high = np.maximum(high, (block.position + block.radius[:, None]).max(axis=0))
    where = " and ".join(f"{AXES[axis]} = {place[axis]:g}" for axis in axes)
    reach = ", ".join(f"{AXES[axis]} from {low[axis]:g} to {high[axis]:g}" for axis in axes)
    return UsageError(f"{frame.path} has no particle at {where}; its particles reach {reach}")


def parse_place(text: str | None, option: str, axes: Sequence[int]) -> dict[int, float]:
    """Return the coordinates in ``y=0.5,z=0.1``, by axis.

    Raises
    ------
    UsageError
        If the text has another form, or an axis is not one of `axes`.
    """
    place: dict[int, float] = {}
    for part in (text or "").split(",") if text is not None else ():
        name, _, number = part.partition("=")
        name = name.strip()
        allowed = ", ".join(AXES[axis] for axis in axes) or "none here"
        if name not in [AXES[axis] for axis in axes]:
            raise UsageError(
                f"{option} {text}: write AXIS=COORDINATE, such as "
                f"{AXES[axes[-1]] if axes else 'y'}=0.5; axes: {allowed}"
            )
        try:
            value = float(number)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise UsageError(f"{option} {text}: the coordinate of {name} is no number")
        if AXES.index(name) in place:
            raise UsageError(f"{option} {text}: {name} is named twice")
        place[AXES.index(name)] = value
    return place
