"""Means of weights over facets that planes of the grid cut, against sums over many points."""

from itertools import product

import numpy as np
import pytest

from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.surfaces.data import SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.spread import pieces_of, spread_weights


@kernel
def _spread(D, cells, c, every, pieces, found):
    found[0] = spread_weights(D, cells, c, every[0], pieces)


def cells_of(D):
    """A grid of 3 cells a direction; the vertices are those of 4."""
    numbers = np.stack(np.meshgrid(*[np.arange(3)] * D, indexing="ij"), axis=-1).reshape(-1, D)
    vertices = numbers[:, None] + np.stack(
        np.meshgrid(*[(0, 1)] * D, indexing="ij"), axis=-1
    ).reshape(-1, D)
    beside = np.full((len(numbers), 6), -1)
    for d in range(D):
        for side in (0, 1):
            other = numbers + (2 * side - 1) * (np.arange(D) == d)
            there = ((other >= 0) & (other < 3)).all(axis=1)
            beside[there, 2 * d + side] = other[there] @ 3 ** np.arange(D)[::-1]
    low = np.zeros((len(numbers), 3))
    low[:, :D] = numbers
    corners = vertices @ 4 ** np.arange(D)[::-1]
    none = np.zeros(0, np.int64)
    plain = np.zeros(len(low), np.bool_)
    return SurfaceCells(low, corners, none, none, np.zeros((0, 2**D)), beside, plain)


def hats(x, D):
    """Weights of all vertices at points, (n, 4^D)."""
    parts = np.maximum(0.0, 1.0 - np.abs(x[:, :, None] - np.arange(4.0)))
    whole = parts[:, 0]
    for d in range(1, D):
        whole = (whole[:, :, None] * parts[:, None, d]).reshape(len(x), -1)
    return whole


@pytest.mark.parametrize("D", [2, 3])
def test_weights_are_means_over_all_of_a_facet(D):
    """Across planes of the grid, too; with the offset they act where they should."""
    rng, cells, pieces = np.random.default_rng(11), cells_of(D), pieces_of(D)
    middle = (3**D - 1) // 2
    t = (np.arange(200) + 0.5) / 100.0 - 1.0
    for k in range(12):
        every, found = no_facets(1), np.zeros(1, np.int64)
        near = every[0]
        near["place"], near["edges"], near["offset"] = 0.0, 0.0, 0.0
        near["place"][:D] = rng.uniform(-0.1, 1.1, D)
        near["edges"][: D - 1, :D] = rng.uniform(-0.2, 0.2, (D - 1, D))
        if k % 3 == 0:  # along the grid
            near["edges"] = 0.0
            near["edges"][: D - 1, : D - 1] = 0.2 * np.eye(D - 1)
        _spread(D, cells, middle, every, pieces, found)
        weights = np.zeros(4**D)
        for c, own in zip(pieces[0][: found[0]], pieces[1], strict=False):
            np.add.at(weights, cells.corners[c], own)
        a, b = near["edges"][:, :D]
        points = np.array([p * a + q * b for p in t for q in (t if D == 3 else t[:1])])
        mean = hats(1.0 + near["place"][:D] + points, D).mean(axis=0)
        np.testing.assert_allclose(weights, mean, rtol=0.0, atol=2e-5)
        before = weights.sum(), weights @ np.indices([4] * D).reshape(D, -1).T
        near["offset"][:D] = rng.uniform(-0.01, 0.01, D)
        _spread(D, cells, middle, every, pieces, found)
        weights[:] = 0.0
        for c, own in zip(pieces[0][: found[0]], pieces[1], strict=False):
            np.add.at(weights, cells.corners[c], own)
        assert weights.sum() == pytest.approx(before[0], abs=1e-13)
        where = weights @ np.indices([4] * D).reshape(D, -1).T
        np.testing.assert_allclose(where, before[1] + near["offset"][:D], atol=1e-13)


@pytest.mark.parametrize("D", [2, 3])
def test_a_facet_in_a_plane_of_the_grid_is_in_the_cells_beside_it(D):
    """Within rounding of the plane, across the end of a cell; none of it is lost."""
    cells, pieces, every, found = cells_of(D), pieces_of(D), no_facets(1), np.zeros(1, np.int64)
    near = every[0]
    offs, tilts = (0.0, -5e-10, 5e-10, 1.3e-9, -2e-9), (4e-11, 1.6e-9)
    for at, off, tilt in product((0.0, 1.0), offs, tilts):
        near["place"], near["edges"], near["offset"] = 0.0, 0.0, 0.0
        near["place"][:D] = [*[0.95] * (D - 1), at + off]
        near["edges"][: D - 1, : D - 1] = 0.125 * np.eye(D - 1)
        near["edges"][0, D - 1] = tilt
        place = near["place"][:D].copy()
        _spread(D, cells, (3**D - 1) // 2, every, pieces, found)
        weights = np.zeros(4**D)
        for c, own in zip(pieces[0][: found[0]], pieces[1], strict=False):
            np.add.at(weights, cells.corners[c], own)
        assert weights.sum() == pytest.approx(1.0, abs=1e-13)
        where = weights @ np.indices([4] * D).reshape(D, -1).T
        np.testing.assert_allclose(where, 1.0 + place, atol=1e-8)


@pytest.mark.parametrize("D", [2, 3])
def test_weights_are_continued_beyond_the_last_cell(D):
    """Where no cell is known a facet has the weights of the last one, as its functions go on."""
    cells, pieces, rng = cells_of(D), pieces_of(D), np.random.default_rng(5)
    corners = np.array([*product((0, 1), repeat=D)])
    t = (np.arange(200) + 0.5) / 100.0 - 1.0
    for k in range(8):
        every, found = no_facets(1), np.zeros(1, np.int64)
        near = every[0]
        near["place"], near["edges"], near["offset"] = 0.0, 0.0, 0.0
        near["place"][:D] = rng.uniform(0.0, 1.0, D)
        near["place"][k % D] = rng.uniform(-0.1, 0.1)  # below the first cells, in all or in part
        near["edges"][: D - 1, :D] = rng.uniform(-0.3, 0.3, (D - 1, D))
        _spread(D, cells, 0, every, pieces, found)
        weights = np.zeros(4**D)
        for c, own in zip(pieces[0][: found[0]], pieces[1], strict=False):
            np.add.at(weights, cells.corners[c], own)
        a, b = near["edges"][:, :D]
        points = np.array([p * a + q * b for p in t for q in (t if D == 3 else t[:1])])
        points += near["place"][:D]
        cell = np.clip(np.floor(points), 0, 2)
        y = (points - cell)[:, None]
        parts = np.where(corners > 0, y, 1.0 - y).prod(axis=2) / len(points)
        mean, at = np.zeros(4**D), (cell[:, None] + corners) @ 4 ** np.arange(D)[::-1]
        np.add.at(mean, at.astype(np.int64), parts)
        np.testing.assert_allclose(weights, mean, rtol=0.0, atol=4e-5)
