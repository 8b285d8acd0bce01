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
_TOUCHING = 1.0 + 1.0e-6


class Block(NamedTuple):
    """A block of a frame's particles, in ascending id.

    Attributes
    ----------
    id : ndarray of int64, shape (n,)
        Ids.
    position : ndarray of float64, shape (n, 3)
        Centres.
    radius : ndarray of float64, shape (n,)
        Half the side of their boxes.
    value : ndarray of float64, shape (n,)
        Values of the drawn quantity.
    volume : ndarray of float64, shape (n,)
        Volumes.
    """

    id: Array
    position: Array
    radius: Array
    value: Array
    volume: Array

    def take(self, rows: Array) -> Block:
        """Return the block with only the given rows."""
        return Block(*(column[rows] for column in self))


class Selection(NamedTuple):
    """A selection of particles.

    Attributes
    ----------
    bodies : tuple of str
        Names of bodies; all if empty.
    place : mapping of int to float
        By axis, the coordinate of a plane that cuts the particles' boxes.
    """

    bodies: tuple[str, ...] = ()
    place: Mapping[int, float] = {}

    def blocks(self, frame: Frame, quantity: Quantity | None) -> Iterator[Block]:
        """Iterate over the selected particles.

        Parameters
        ----------
        frame : Frame
            The frame.
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
        for first in range(0, len(frame), _BLOCK_ROWS):
            last = min(first + _BLOCK_ROWS, len(frame))
            position = frame.rows("position", first, last).astype(np.float64)
            radius = frame.rows("radius", first, last).astype(np.float64)
            keep = np.isfinite(position).all(axis=1)
            if chosen:
                keep &= np.isin(frame.rows("body", first, last), chosen)
            for axis, place in self.place.items():
                keep &= np.abs(position[:, axis] - place) <= radius * _TOUCHING
            rows = np.flatnonzero(keep)
            none = np.empty(len(radius))
            full = quantity is not None
            yield Block(
                frame.rows("id", first, last) if full else none,
                position,
                radius,
                quantity.rows(frame, first, last) if quantity is not None else none,
                frame.rows("volume", first, last).astype(np.float64) if full else none,
            ).take(rows)


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
