"""Thickness of regions of any shape, in cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.geometry.regions.base import Region

Array = np.ndarray

#: Chords of a point are followed so far each way, in such steps, in cells; and then halved.
_FAR, _STEP, _HALVINGS = 10.0, 0.5, 5
#: Points that are tried, and chords through those that are taken; directions in 2D and 3D.
_TRIED, _TAKEN = 4096, 32
_DIRECTIONS = {2: 24, 3: 48}


def thickness(case: Case, region: Region, goes_on: Array) -> float:
    """Thickness of a region where it is thickest, in cells; inf from `_FAR` on.

    That is the longest, of some points in it, of the shortest chords through each.

    Parameters
    ----------
    goes_on : (D, 2) bool
        Faces of the domain beyond which bodies go on, mirrored or repeated.
    """
    cell, origin = np.array(case.grid.cell), np.array(case.grid.origin)
    corner, dimensions = np.array(case.grid.corner), case.dimensions
    low, high = (np.asarray(each, float) for each in region.bounds())
    low, high = np.maximum(low, origin), np.minimum(high, corner)

    def inside(points: Array) -> Array:
        """Whether points, in cells, are in the region, or beyond a face where it goes on."""
        x = origin + points * cell
        below, above = x < origin, x > corner
        on = (below & goes_on[:, 0]) | (above & goes_on[:, 1])
        found = region.contains(np.ascontiguousarray(x)) & ~(below | above).any(axis=1)
        return found | on.any(axis=1)

    # Multiples of powers of an irrational number are even over a box, and the same each time.
    root = {2: 1.32471795724474602596, 3: 1.22074408460575947536}[dimensions]
    share = np.arange(1, _TRIED + 1)[:, None] * root ** -np.arange(1.0, dimensions + 1) % 1.0
    points = (low + share * (high - low) - origin) / cell
    points = points[inside(points)][:_TAKEN]
    if not len(points):
        return np.inf
    ways = _directions(dimensions)
    lengths = np.zeros((len(points), len(ways)))
    starts = np.repeat(points, len(ways), axis=0)
    for sign in (-1.0, 1.0):
        along = np.tile(sign * ways, (len(points), 1))
        reached, left = np.zeros(len(starts)), np.arange(len(starts))
        for n in range(1, int(_FAR / _STEP) + 1):
            left = left[inside(starts[left] + n * _STEP * along[left])]
            reached[left] = n * _STEP
        reach = _STEP
        for _ in range(_HALVINGS):
            reach *= 0.5
            reached += reach * inside(starts + (reached + reach)[:, None] * along)
        reached[left] = np.inf
        lengths += reached.reshape(lengths.shape)
    return float(lengths.min(axis=1).max())


def _directions(dimensions: int) -> Array:
    """Directions, even over half of a circle or of a sphere."""
    count = _DIRECTIONS[dimensions]
    part = (np.arange(count) + 0.5) / count
    if dimensions == 2:
        return np.column_stack([np.cos(np.pi * part), np.sin(np.pi * part)])
    turn, across = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count), np.sqrt(1.0 - part**2)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), part])
