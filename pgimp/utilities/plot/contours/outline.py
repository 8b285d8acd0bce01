"""Outlines of bodies: where half of the space is covered by their particles."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pgimp.utilities.plot.contours.raster import Raster

Array = np.ndarray

#: A gap within a body is closed where so much around it is covered; at a straight face it is half.
_CLOSED = 0.75
#: Part of the area that an outline of particles' own shapes may lose or gain.
_LOST = 0.02


class Outline(NamedTuple):
    """The outline of a body."""

    #: list of (ndarray of shape (n, 2), ndarray of shape (k,)): Points of its parts, and where the
    #: rings of each begin and end: the first one around it, anticlockwise, the others around holes.
    areas: list[tuple[Array, Array]]
    #: list of ndarray, shape (n, 2): What is drawn: the rings, but not along periodic faces.
    lines: list[Array]

    @property
    def area(self) -> float:
        """Area within, without that of holes."""
        return sum(
            _signed(points[first:last])
            for points, ends in self.areas
            for first, last in pairwise(ends.tolist())
        )


def _signed(ring: Array) -> float:
    x, y = ring.T
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def outline(centre: Array, edges: Array, points: Raster, wide: float) -> Outline:
    """Return the outline of particles.

    Parameters
    ----------
    centre : ndarray, shape (n, 3)
        Centres in the picture; the third coordinate is the height above the plane that is seen.
    edges : ndarray, shape (n, 3, 3)
        Half the edges of their parallelepipeds, a row each.
    points : Raster
        Where it is computed; several points a particle.
    wide : float
        Where shapes are not known, as of liquids, particles leave gaps and cover each other. If the
        area is then not theirs, their volumes are smoothed over this distance, should that be
        nearer.
    """
    total = coverage(centre, edges, points)
    covered = np.minimum(total, 1.0)
    reach = np.median(2.0 * np.abs(edges[..., :2]).sum(axis=1), axis=0)
    found = _level(np.maximum(covered, _smooth(covered, reach, points) - _CLOSED + 0.5), points)
    area = float(total.sum() * points.step.prod())
    if abs(found.area - area) > _LOST * area:
        other = _level(_smooth(total, np.full(2, wide), points), points)
        found = min(found, other, key=lambda one: abs(one.area - area))
    return found


def _level(covered: Array, points: Raster) -> Outline:
    """Return the outline of what is covered by more than one half."""
    from contourpy import FillType, LineType, contour_generator

    found = contour_generator(
        points.x, points.y, covered, fill_type=FillType.OuterOffset, line_type=LineType.Separate
    )
    areas: Any = found.filled(0.5, np.inf)
    lines: Any = found.lines(0.5)
    return Outline(list(zip(*areas, strict=True)), list(lines))


def coverage(centre: Array, edges: Array, points: Raster) -> Array:
    """Return how often points are covered, (rows, columns), with edges softened over a point.

    Each particle adds the product of a ramp across each pair of its faces, one half at the face.
    Ramps of neighbours add up to one, so that no seam is seen; and one half is the face itself.
    """
    ramp = float(points.step.max())
    volume = np.abs(np.linalg.det(edges))
    there = volume > 0.0
    centre, edges = centre[there], edges[there]
    inverse = np.linalg.inv(edges)
    # Rows of the inverse are gradients of the coordinates along the edges.
    height = 1.0 / np.linalg.norm(inverse, axis=1)
    sums = np.zeros(points.shape[0] * points.shape[1])
    reach = np.abs(edges).sum(axis=1)[:, :2]
    wider = 1.0 + ramp / np.linalg.norm(edges, axis=2).min(axis=1)
    reach = np.minimum(reach * wider[:, None], reach + 4.0 * ramp)
    for rows, column, row in points.windows(centre[:, :2], reach):
        x = points.low[0] + points.step[0] * column - centre[rows, 0, None]
        y = points.low[1] + points.step[1] * row - centre[rows, 1, None]
        part = np.ones(x.shape)
        for side in range(3):
            gradient = inverse[rows, :, side, None]
            along = x * gradient[:, 0] + y * gradient[:, 1]
            along -= centre[rows, 2, None] * gradient[:, 2]
            # Thinner than the ramp it would not be seen.
            thick = height[rows, side, None]
            beyond = (np.abs(along) - 1.0) * (thick / np.minimum(ramp, thick))
            part *= np.clip(0.5 - 0.5 * beyond, 0.0, 1.0)
        points.add(sums, column, row, part)
    return sums.reshape(points.shape)


def _smooth(values: Array, reach: Array, points: Raster) -> Array:
    """Return means with weights like tents that end at a distance, (2,)."""
    for axis in (0, 1):
        values = _mean(values, axis, int(np.round(reach[1 - axis] / points.step[1 - axis])))
    return values


def _mean(values: Array, axis: int, reach: int) -> Array:
    """Return the mean along an axis with weights like a tent that ends after `reach` points."""
    if reach < 2:
        return values
    weights = 1.0 - np.abs(np.arange(1 - reach, reach)) / reach
    weights /= weights.sum()
    widths = [(0, 0), (0, 0)]
    widths[axis] = (reach - 1, reach - 1)
    padded = np.pad(values, widths, mode="edge")
    count = values.shape[axis]
    found = np.zeros_like(values)
    for first, weight in enumerate(weights):
        found += weight * np.take(padded, np.arange(first, first + count), axis=axis)
    return found
