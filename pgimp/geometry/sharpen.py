"""Edges and corners of a rigid body's surface, for pictures (dual contouring).

A vertex of `pgimp.geometry.outline` is the mean of the places where the surface crosses the edges
of a cell, which cuts corners. The tangent planes there meet in the corner or edge itself, if there
is one in the cell: it is their least-squares point. Places and normals are those of the region, not
of the lattice. Each vertex then moves along normals until it is on the surface; so it does where
the surface is round. What is thinner than the lattice has no vertices.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.distancefield import DistanceField
from pgimp.geometry.regions.base import Region

Reals = NDArray[np.float64]

#: Part of the greatest eigenvalue below which tangent planes are one: angles of 12 degrees.
_ALIKE = 0.01
#: Step of differences, and distance from the surface beyond which tangent planes meet elsewhere,
#: over the spacing.
_STEP, _NEAR = 1e-5, 0.2
#: Distance over the spacing that is on the surface.
_ON = 1e-9
#: Vertices per block of the computation.
_BLOCK = 1 << 16
#: Iterations for crossings, and for steps to the surface.
_HALVINGS, _STEPS = 12, 6


def sharpened(points: Reals, field: DistanceField, region: Region) -> Reals:
    """Return the vertices of `outline` on the surface of the region, its corners included, (n, 3).

    Parameters
    ----------
    points : (n, 3) float64
        Vertices, from `outline`.
    field : DistanceField
        The region's distances.
    region : Region
        The body in its initial pose.
    """
    D = int((field.shape > 1).sum())
    if D == 1 or not len(points):
        return points
    places, numbers = _crossings(field, region, D)
    normals = _normals(region, places, field.spacing)
    result = points.copy()
    for begin in range(0, len(points), _BLOCK):
        some = numbers[begin : begin + _BLOCK]
        result[begin : begin + _BLOCK, :D] = _vertices(region, places, normals, some, field.spacing)
    return result


def _vertices(
    region: Region, places: Reals, normals: Reals, numbers: NDArray[np.int64], spacing: float
) -> Reals:
    """Return the vertices of cells by the places and normals of their crossings."""
    there = (numbers >= 0)[..., None]
    mean = np.where(there, places[numbers], 0.0).sum(axis=1) / there.sum(axis=1)
    n = np.where(there, normals[numbers], 0.0)
    away = (n * (places[numbers] - mean[:, None])).sum(axis=2)
    size, axes = np.linalg.eigh(np.einsum("kei,kej->kij", n, n))
    along = np.einsum("kij,ki->kj", axes, np.einsum("kei,ke->ki", n, away))
    known = size > _ALIKE * size[:, -1:]
    step = np.where(known, along / np.where(known, size, 1.0), 0.0)
    corner = mean + np.einsum("kij,kj->ki", axes, step)
    far = np.linalg.norm(corner - mean, axis=1) > 2.0 * np.sqrt(places.shape[1]) * spacing
    far |= np.abs(region.signed_distance(corner)) > _NEAR * spacing
    found = np.where(far[:, None], mean, corner)
    for _ in range(_STEPS):
        distance = region.signed_distance(found)
        off = np.flatnonzero(np.abs(distance) > _ON * spacing)
        if not len(off):
            break
        found[off] -= distance[off, None] * _normals(region, found[off], spacing)
    return found


def _crossings(field: DistanceField, region: Region, D: int) -> tuple[Reals, NDArray[np.int64]]:
    """Return where the surface crosses the lattice's edges, (m, D), and each vertex's crossings.

    These are numbers of rows, (n, D 2^(D - 1)), or -1, in the order of the vertices.
    """
    shape = tuple(int(n) for n in field.shape[:D])
    inside = field.values[:, 0].reshape(shape) < 0.0
    cells = tuple(n - 1 for n in shape)
    ends: list[tuple[Reals, Reals]] = []
    of_cells, count = [], 0
    for d in range(D):
        a = np.take(inside, range(shape[d] - 1), axis=d)
        b = np.take(inside, range(1, shape[d]), axis=d)
        edges = np.argwhere(a != b)
        number = np.full(a.shape, -1, np.int64)
        number[a != b] = count + np.arange(len(edges))
        count += len(edges)
        low = field.low[:D] + field.spacing * edges
        high = low + field.spacing * np.eye(D)[d]
        within = a[a != b][:, None]
        ends.append((np.where(within, low, high), np.where(within, high, low)))
        others = [e for e in range(D) if e != d]
        for offsets in product((0, 1), repeat=D - 1):
            cut = [slice(None)] * D
            for e, offset in zip(others, offsets, strict=True):
                cut[e] = slice(offset, offset + cells[e])
            of_cells.append(number[tuple(cut)])
    numbers = np.stack([each.ravel() for each in of_cells], axis=1)
    numbers = numbers[(numbers >= 0).any(axis=1)]
    within, beyond = (np.concatenate(each) for each in zip(*ends, strict=True))
    return _between(region, within, beyond), numbers


def _between(region: Region, within: Reals, beyond: Reals) -> Reals:
    """Return the points of the surface between points inside and outside, by false position."""
    low, high = np.zeros(len(within)), np.ones(len(within))
    at_low, at_high = region.signed_distance(within), region.signed_distance(beyond)
    length = np.linalg.norm(beyond - within, axis=1)
    part, rows = low.copy(), np.arange(len(within))
    for _ in range(_HALVINGS):
        width = at_high[rows] - at_low[rows]
        step = at_low[rows] * (high - low)[rows] / np.where(width > 0.0, width, 1.0)
        part[rows] = low[rows] - step
        value = region.signed_distance(within[rows] + part[rows, None] * (beyond - within)[rows])
        inside = rows[value < 0.0]
        outside = rows[~(value < 0.0)]
        # The end that stays counts half, so that both come nearer (Illinois).
        low[inside], at_low[inside] = part[inside], value[value < 0.0]
        high[outside], at_high[outside] = part[outside], value[~(value < 0.0)]
        at_high[inside] *= 0.5
        at_low[outside] *= 0.5
        rows = rows[np.abs(value) > _ON * length[rows]]
    return within + part[:, None] * (beyond - within)


def _normals(region: Region, points: Reals, spacing: float) -> Reals:
    """Return unit normals of the surface near points, away from the body, (n, D)."""
    found, step = np.zeros(points.shape), _STEP * spacing
    for d in range(points.shape[1]):
        shift = step * np.eye(points.shape[1])[d]
        found[:, d] = region.signed_distance(points + shift) - region.signed_distance(
            points - shift
        )
    length = np.linalg.norm(found, axis=1)[:, None]
    return found / np.where(length > 0.0, length, 1.0)
