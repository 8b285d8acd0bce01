"""A field of particles at points: fitted planes, weighted by volume and tents."""

from __future__ import annotations

import numpy as np

from pgimp.utilities.plot.contours.raster import Raster

Array = np.ndarray

#: Half the width of the tents, in particles: at a face it reaches more than one row of them.
TENT = 3.0
#: Variance of places along a direction, over that of the tent, below which a slope is unknown.
_ALONE = 1e-3


def smoothed(place: Array, values: Array, weight: Array, size: Array, points: Raster) -> Array:
    """Return a field at points, nan where no particle is near.

    Around each point the plane is fitted that is nearest to the particles' values: fields that are
    linear in space stay as they are, also at faces and with unequal distances.

    Parameters
    ----------
    place : ndarray, shape (n, 2)
        Centres in the picture.
    values : ndarray, shape (n,)
        Values; those that are no numbers count as none.
    weight : ndarray, shape (n,)
        Their volumes.
    size : ndarray, shape (2,)
        Size of a particle.

    Returns
    -------
    ndarray, shape (rows, columns)
        The field.
    """
    known = np.isfinite(values) & (weight > 0.0)
    place, values, weight = place[known], values[known], weight[known]
    # Values near zero, lest digits be lost where they are large and alike.
    middle = float(np.median(values)) if len(values) else 0.0
    values = values - middle
    # So that two rows of particles are within reach of the points beside a face.
    reach = np.maximum(TENT * size, 2.0 * points.step + size)
    sums = np.zeros((9, points.shape[0] * points.shape[1]))
    for rows, column, row in points.windows(place, np.broadcast_to(reach, place.shape)):
        u = (place[rows, 0, None] - points.low[0] - points.step[0] * column) / reach[0]
        v = (place[rows, 1, None] - points.low[1] - points.step[1] * row) / reach[1]
        tent = np.maximum(1.0 - np.abs(u), 0.0) * np.maximum(1.0 - np.abs(v), 0.0)
        w = weight[rows, None] * tent
        f = values[rows, None]
        terms = (1.0, u, v, u * u, u * v, v * v, f, f * u, f * v)
        for total, term in zip(sums, terms, strict=True):
            points.add(total, column, row, w * term)
    return (_fitted(sums) + middle).reshape(points.shape)


def _fitted(sums: Array) -> Array:
    """Return the planes' values at the points, of sums of 1, u, v, uu, uv, vv, f, fu, fv."""
    found = np.full(sums.shape[1], np.nan)
    near = sums[0] > 1e-9 * max(float(sums[0].max(initial=0.0)), 1e-300)
    u, v, uu, uv, vv, f, fu, fv = sums[1:, near] / sums[0, near]
    spread = np.array([[uu - u * u, uv - u * v], [uv - u * v, vv - v * v]])
    variance, direction = np.linalg.eigh(spread.transpose(2, 0, 1))
    # Where particles are in a row, or alone, nothing is known of the slope across.
    inverse = np.where(variance > _ALONE, 1.0 / np.maximum(variance, _ALONE), 0.0)
    both = np.stack([fu - f * u, fv - f * v], axis=1)
    slope = np.einsum("nij,nj,nkj,nk->ni", direction, inverse, direction, both)
    found[near] = f - slope[:, 0] * u - slope[:, 1] * v
    return found
