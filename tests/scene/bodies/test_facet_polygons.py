"""Polygons of facets: areas, points that neighbours share, edges."""

import numpy as np
import pytest

from pgimp.geometry.regions import Ball, Box
from pgimp.scene.bodies.facet_polygons import polygons_of
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_patches import facets_of


def polygons(region, D):
    """Facets of a body on boxes of half a unit, and their polygons."""
    edges = [np.arange(-2, 19) * 0.5] * D
    body = LatticeBody(region, edges, [e[:-1] + 0.25 for e in edges], True, True)
    facets = facets_of(body, np.zeros(D), np.ones(D))
    return facets, polygons_of(facets, np.zeros(len(facets.x), np.int64), D)


def areas(found):
    """Areas of the cells."""
    corners = found.x[found.cells]
    if found.cells.shape[1] == 2:
        return np.sqrt(((corners[:, 1] - corners[:, 0]) ** 2).sum(axis=1))
    arm = corners[:, 1:] - corners[:, :1]
    both = np.cross(arm[:, 0], arm[:, 1]) + np.cross(arm[:, 1], arm[:, 2])
    return 0.5 * np.sqrt((both * both).sum(axis=1))


@pytest.mark.parametrize("D", [2, 3])
def test_a_box_is_closed_and_each_cell_has_its_area(D):
    low, high = [1.13, 2.21, 1.57][:D], [6.02, 5.91, 5.33][:D]
    facets, found = polygons(Box(min=low, max=high), D)
    np.testing.assert_allclose(areas(found), facets.area[found.of] * found.part, rtol=1e-5)
    ends = found.cells if D == 2 else np.sort(_edges(found.cells), axis=1)
    _, uses = np.unique(ends, axis=0 if D == 3 else None, return_counts=True)
    assert (uses == 2).all()  # of points in 2D, of edges in 3D
    for corner in np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, D):
        assert np.abs(found.x[:, :D] - corner).max(axis=1).min() < 1e-6


def _edges(cells):
    """Edges of quadrilaterals, without those of no length."""
    pairs = np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    return pairs[pairs[:, 0] != pairs[:, 1]]


@pytest.mark.parametrize("D", [2, 3])
def test_a_ball_has_its_area_and_points_are_on_it(D):
    centre, radius = [4.1, 4.2, 3.9][:D], 2.53
    facets, found = polygons(Ball(centre=centre, radius=radius), D)
    exact = (2.0 * np.pi * radius, 4.0 * np.pi * radius**2)[D - 2]
    assert areas(found).sum() == pytest.approx(exact, rel=5e-3)
    np.testing.assert_allclose(np.bincount(found.of, found.part), 1.0, rtol=1e-12)
    away = np.sqrt(((found.x[:, :D] - centre) ** 2).sum(axis=1)) - radius
    assert np.abs(away).max() < 0.05
    assert len(found.x) < (1.05, 1.5)[D - 2] * len(facets.x)  # they are shared


def test_points_in_1d_are_the_facets():
    facets, found = polygons(Box(min=[1.3], max=[4.2]), 1)
    np.testing.assert_array_equal(found.x, facets.x)
    assert found.cells.shape == (2, 1)
