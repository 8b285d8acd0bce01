"""Exact bounds of regions made of regions.

The farthest point of a region along an axis lies on some of its surfaces. In 3D it is a corner of
three planes, an extreme of one or two planes' intersection with a sphere or a cylinder, or the top
of one. For planes, spheres and cylinders all such points are found in closed form; those in the
region decide. Round surfaces must meet in planes, as spheres do; otherwise, and for meshes, there
is no result.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pgimp.geometry.regions.base import Bounds, Region, Round

Reals = NDArray[np.float64]

#: Most planes and round surfaces for which every combination is tested.
_MOST_FLATS, _MOST_ROUNDS = 40, 40

#: Largest distance of a surface point from its region, over the region's coordinates.
_SLACK = 1e-10

#: Distance to which an infinite region is followed, over its coordinates.
_FAR = 1e6

#: Relative size below which a slope counts as zero.
_PARALLEL = 1e-9


def extremes(region: Region, around: Bounds) -> Bounds:
    """Return the exact bounds of a region, where they can be found.

    Parameters
    ----------
    region : Region
        Any region; its simple parts give the surfaces.
    around : (low, high)
        Valid bounds, possibly too wide or infinite.

    Returns
    -------
    low, high : tuple of float
        Exact to rounding; infinite where the region has no end, low above high if it is empty.
        `around` where they are unknown.
    """
    if any(a > b for a, b in zip(*around, strict=True)):
        return around
    D = len(around[0])
    flats = [flat for part in region.simple() for flat in part.flats()]
    rounds = list(dict.fromkeys(one for part in region.simple() for one in part.rounds()))
    between = _planes_between(rounds)
    if between is None or len(rounds) > _MOST_ROUNDS:
        return around
    normals = np.array([flat.normal for flat in flats] + [n for n, _ in between]).reshape(-1, D)
    feet = np.array([flat.point for flat in flats] + [p for _, p in between]).reshape(-1, D)
    reach = [np.abs(feet).max(initial=0.0)]
    reach += [max(map(abs, one.centre)) + one.radius for one in rounds]
    scale = max(reach) or 1.0
    far = _FAR * scale
    if not np.isfinite(around).all():
        normals = np.concatenate([normals, np.eye(D), np.eye(D)])
        feet = np.concatenate([feet, np.full((D, D), far), np.full((D, D), -far)])
    planes = np.unique(np.concatenate([normals, (normals * feet).sum(axis=1)[:, None]], 1), axis=0)
    if len(planes) > _MOST_FLATS:
        return around
    points = np.concatenate(list(_candidates(planes[:, :D], planes[:, D], rounds)))
    points = points[(np.abs(points) <= far * (1.0 + 1e-9)).all(axis=1)]
    points = points[region.distance(points) <= _SLACK * np.maximum(scale, np.abs(points).max(1))]
    if len(points) == 0:
        return (math.inf,) * D, (-math.inf,) * D
    low, high = points.min(axis=0), points.max(axis=0)
    low, high = np.maximum(low, around[0]), np.minimum(high, around[1])
    low[low < -0.5 * far], high[high > 0.5 * far] = -math.inf, math.inf
    return tuple(low.tolist()), tuple(high.tolist())


def _planes_between(rounds: list[Round]) -> list[tuple[list[float], list[float]]] | None:
    """Return the planes, normal and point, of round surfaces' intersections; None for curves.

    Two spheres, or parallel cylinders, meet in one plane. A sphere centred on a cylinder's axis
    meets it in two. Separate surfaces do not matter.
    """
    found = []
    for a, b in combinations(rounds, 2):
        first, second = np.array(a.centre), np.array(b.centre)
        away = second - first
        axis = np.array(a.axis or b.axis) if a.axis or b.axis else np.zeros(len(away))
        across = away - (away @ axis) * axis
        distance = float(np.sqrt(across @ across))
        mixed = (a.axis is None) != (b.axis is None)
        if not mixed:
            if a.axis and b.axis:
                turn = np.cross(a.axis, b.axis)
                if turn @ turn > _PARALLEL**2:
                    return None
            if distance > a.radius + b.radius or distance <= _PARALLEL * max(a.radius, b.radius):
                continue
            along = 0.5 * (distance + (a.radius**2 - b.radius**2) / distance)
            normal = across / distance
            found.append((normal.tolist(), (first + along * normal).tolist()))
        elif distance <= _PARALLEL * max(a.radius, b.radius):
            ball, pipe = (a, b) if a.axis is None else (b, a)
            if ball.radius >= pipe.radius:
                half = math.sqrt(ball.radius**2 - pipe.radius**2)
                centre = np.array(ball.centre)
                found += [
                    (axis.tolist(), (centre + side * half * axis).tolist()) for side in (-1.0, 1.0)
                ]
        elif distance <= a.radius + b.radius:
            return None
    return found


def _candidates(normals: Reals, offsets: Reals, rounds: list[Round]) -> Iterator[Reals]:
    """Yield points, (n, D): intersections of planes, and extremes of round surfaces in planes."""
    D = normals.shape[1]
    yield np.zeros((0, D))
    axes = np.eye(D)
    for k in range(D + 1):
        every = list(combinations(range(len(normals)), k))
        if not every:
            continue
        chosen = np.array(every, int).reshape(len(every), k)
        N, b = normals[chosen], offsets[chosen]
        # (Nearly) parallel planes have no intersection, or coincide.
        square = np.sqrt(np.maximum(np.linalg.det(N @ N.swapaxes(1, 2)), 0.0))
        keep = square > _PARALLEL
        N, b = N[keep], b[keep]
        inverse = np.linalg.pinv(N) if k else np.zeros((len(N), D, 0))
        if k == D:
            yield (inverse @ b[:, :, None])[:, :, 0]
            continue
        within = axes - inverse @ N  # projects onto the directions that lie in all the planes
        for one in rounds:
            centre = np.array(one.centre)
            foot = centre + (inverse @ (b - N @ centre)[:, :, None])[:, :, 0]
            u = np.array(one.axis) if one.axis else np.zeros(D)
            steep = axes - np.outer(u, u)
            bowl = within @ steep @ within
            back = np.linalg.pinv(bowl, rcond=_PARALLEL, hermitian=True)
            slope = (steep @ (foot - centre)[:, :, None])[:, :, 0]
            middle = foot - (back @ (within @ slope[:, :, None]))[:, :, 0]
            away = (steep @ (middle - centre)[:, :, None])[:, :, 0]
            square = one.radius**2 - (away * away).sum(axis=1)
            meets = square >= -1e-12 * one.radius**2
            half = np.sqrt(np.maximum(square[meets], 0.0))
            yield middle[meets]
            for d in range(D):
                goal = within[meets, :, d]
                way = (back[meets] @ goal[:, :, None])[:, :, 0]
                # Along its axis a cylinder ends only at planes.
                ends = np.abs((bowl[meets] @ way[:, :, None])[:, :, 0] - goal).max(axis=1) < 1e-6
                size = np.sqrt(np.maximum((goal * way).sum(axis=1), 0.0))
                ends &= size > 1e-6
                step = (half[ends] / size[ends])[:, None] * way[ends]
                yield middle[meets][ends] + step
                yield middle[meets][ends] - step
