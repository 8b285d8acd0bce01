"""Products of inertia of the parts of boxes in a region, against sums over many small boxes."""

import numpy as np
import pytest

from pgimp.geometry.measure import measure
from pgimp.geometry.regions import Ball, HalfSpace

LOW = {2: [[0.3, 0.2], [1.0, 0.75], [0.25, 1.25]], 3: [[0.3, 0.2, 0.1], [1.0, 0.8, 0.5]]}


#: Directions of the coordinates in products, the last two for sections of rings.
PRODUCTS = {2: ((0, 1), (0, 0), (0, 0, 1)), 3: ((1, 2), (0, 2), (0, 1), (0, 1, 2))}


def summed(region, low, high, n):
    """Volume and moments by midpoints."""
    D = len(low)
    each = [a + (np.arange(n) + 0.5) / n * (b - a) for a, b in zip(low, high, strict=True)]
    x = np.stack(np.meshgrid(*each, indexing="ij"), axis=-1).reshape(-1, D)
    x, d = x[region.contains(x)], np.prod(high - low) / n**D
    r = x - 0.5 * (low + high)
    products = [r[:, axes].prod(axis=1).sum() for axes in PRODUCTS[D]]
    return np.array([len(x), *r.sum(axis=0), *products]) * d


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["ball", "plane"])
def test_products(kind, D):
    ball = Ball(center=[0.1, 0.2, 0.15][:D], radius=1.4)
    normal = [0.6, 0.5, 0.3][:D]
    plane = HalfSpace(point=[0.9, 0.6, 0.4][:D], normal=normal)
    region = ball if kind == "ball" else plane
    low = np.array(LOW[D])
    high = low + 0.5
    volume, moment = measure(region, low, high, len(PRODUCTS[D]))
    n = {2: 1500, 3: 160}[D]
    for row in range(len(low)):
        truth = summed(region, low[row], high[row], n)
        scale = 0.5 ** (D + np.array([0, *[1] * D, *map(len, PRODUCTS[D])]))
        np.testing.assert_allclose(
            np.array([volume[row], *moment[row]]) / scale, truth / scale, atol=4.0 / n**1.5
        )
    plain = measure(region, low, high)
    np.testing.assert_allclose(volume, plain[0], rtol=1e-3, atol=1e-12)
