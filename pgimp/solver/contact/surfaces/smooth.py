"""Loads on facets, made smooth: forces of neighbouring patches alternate about a smooth pressure.

With the pressures p, D p is what p lacks of a linear fit to its neighbourhood, and A the areas:

    A p <- A p - D^T A D p.

D of a linear function is zero. So the sum and the moments stay, and what is linear stays as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.surfaces.search import find_beside
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.surfaces.table import bins_of

#: Radius of a neighbourhood in cells, and how often loads are made smooth: two passes leave 3 % of
#: what alternates from cell to cell.
RADIUS, PASSES = 1.5, 2

#: Least cosine between normals of neighbours; least eigenvalue of second moments, over the
#: greatest, of a neighbourhood with a fit.
_ALIKE, _LEAST = 0.7, 0.02


class Smoothed(NamedTuple):
    """Facets under load, or about to be."""

    x: np.ndarray  #: (n, 3) float64: Centroids.
    normal: np.ndarray  #: (n, 3) float64: Unit normals.
    area: np.ndarray  #: (n,) float64: Areas.
    body: np.ndarray  #: (n,) int64: Bodies.


def smooth(call: Bound, facets: Smoothed, loads: np.ndarray, cell: float, D: int) -> np.ndarray:
    """Loads of facets made smooth, (n, columns); `loads` are not over the areas."""
    x, normal, area, body = facets
    if D == 1 or not len(x):
        return loads
    own, other = _pairs(call, x, body, RADIUS * cell, D)
    alike = (normal[own] * normal[other]).sum(axis=1) > _ALIKE
    own, other = own[alike], other[alike]
    count, way = len(x), x[other] - x[own]
    a, b = _tangents(normal)
    xi = [(way * t[own]).sum(axis=1) for t in (a, b)[: D - 1]]
    far = np.sqrt((way * way).sum(axis=1)) / (RADIUS * cell)
    weight = area[other] * np.maximum(0.0, 1.0 - far)

    def added(values: np.ndarray) -> np.ndarray:
        return np.bincount(own, values, count)

    moments = np.empty((count, D, D))
    every = [np.ones(len(own)), *xi]
    for i in range(D):
        for j in range(D):
            moments[:, i, j] = added(weight * every[i] * every[j])
    second = moments[:, 1:, 1:] / (moments[:, :1, :1] * cell * cell)
    good = np.linalg.eigvalsh(second)[:, 0] > _LEAST
    moments[~good] = np.eye(D)
    fit = np.linalg.inv(moments)[:, 0]
    part = weight * sum(fit[own, i] * each for i, each in enumerate(every))
    part[~good[own]] = 0.0
    found = loads.copy()
    for _ in range(PASSES):
        for n in range(loads.shape[1]):
            p = found[:, n] / area
            lacks = np.where(good, p - added(part * p[other]), 0.0) * area
            found[:, n] -= lacks - np.bincount(other, part * lacks[own], count)
    return found


def _pairs(
    call: Bound, x: np.ndarray, body: np.ndarray, radius: float, D: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of facets of one body within a radius, also each with itself; by the first one."""
    key_of, strides = bins_of(x, radius, D)
    order, start = np.argsort(key_of, kind="stable"), np.zeros(len(x) + 1, np.int64)
    bins = key_of[order], order
    beside, found = grown(
        64 * len(x),
        lambda size: np.empty(size, np.int64),
        lambda room: call(find_beside, x, body, key_of, bins, strides, radius, start, room),
    )
    number = np.arange(len(x))
    own = np.concatenate([number, np.repeat(number, np.diff(start))])
    return own, np.concatenate([number, beside[:found]])


def _tangents(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across each normal; of normals in the plane of x and y the first is, too."""
    axis = np.argmin(np.abs(normal).round(9)[:, ::-1], axis=1)
    a = np.cross(normal, np.eye(3)[2 - axis])
    a /= np.sqrt((a * a).sum(axis=1))[:, None]
    return a, np.cross(normal, a)
