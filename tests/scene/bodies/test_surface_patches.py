"""Facets of bodies: they close, lie on faces also at edges, and patches are of one face each."""

import numpy as np
import pytest

from pgimp.geometry.regions import Ball, Box, HalfSpace, Intersection
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_patches import facets_of


def body(region, D):
    """A body exact to its surface, on boxes of half a unit; cells have sides of 1."""
    edges = [np.arange(-2, 19) * 0.5] * D
    return LatticeBody(region, edges, [e[:-1] + 0.25 for e in edges], True, True)


def found(region, D, closed=()):
    return facets_of(body(region, D), np.zeros(D), np.ones(D), closed)


def turned(angles):
    """Axes of a box, turned in the plane of x and y, then in that of y and z; rows."""
    a, b = np.radians(angles)
    one = np.array([[np.cos(a), np.sin(a), 0.0], [-np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    two = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(b), np.sin(b)], [0.0, -np.sin(b), np.cos(b)]])
    return one @ two


def block(middle, sides, axes):
    return Intersection(tuple(
        HalfSpace(point=(middle + 0.5 * way * side * axis).tolist(), normal=(way * axis).tolist())
        for axis, side in zip(axes, sides, strict=True) for way in (-1.0, 1.0)
    ))  # fmt: skip


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["ball", "box"])
def test_facets_close_and_have_the_area_and_the_volume(kind, D):
    low, high = np.array([1.13, 2.21, 1.57])[:D], np.array([6.02, 5.91, 5.33])[:D]
    ball = Ball(centre=[4.1, 4.2, 3.9][:D], radius=2.53)
    facets = found(ball if kind == "ball" else Box(min=low.tolist(), max=high.tolist()), D)
    vectors = facets.area[:, None] * facets.normal
    np.testing.assert_allclose(vectors.sum(axis=0), 0.0, atol=1e-8)
    volume = (vectors * facets.x).sum() / D
    sides = high - low
    if kind == "box":
        area = 2.0 * (sides.sum() if D == 2 else sides.prod() * (1.0 / sides).sum())
        assert facets.area.sum() == pytest.approx(area, rel=1e-6)
        assert volume == pytest.approx(sides.prod(), rel=1e-6)
    else:
        area = (2.0 * np.pi * 2.53, 4.0 * np.pi * 2.53**2)[D - 2]
        assert facets.area.sum() == pytest.approx(area, rel=3e-3)
        np.testing.assert_allclose(
            np.sqrt(((facets.x[:, :D] - [4.1, 4.2, 3.9][:D]) ** 2).sum(axis=1)), 2.53, atol=0.02
        )


@pytest.mark.parametrize("angle", [0.0, 17.0, 30.0, 45.0])
def test_facets_of_a_turned_rectangle_are_on_its_faces(angle):
    """Also at its corners: none has the normal of two faces."""
    axes = turned((angle, 0.0))[:2, :2]
    middle, sides = np.array([4.11, 4.07]), np.array([4.0, 3.0])
    facets = found(block(middle, sides, axes), 2)
    x, normal = (facets.x[:, :2] - middle) @ axes.T, facets.normal[:, :2] @ axes.T
    large = facets.area > 2e-3  # tiny ones may be of two faces
    face = np.abs(normal[large]).max(axis=1)
    np.testing.assert_allclose(face, 1.0, atol=1e-6)
    d = np.abs(normal[large]).argmax(axis=1)
    off = np.abs(x[large][np.arange(large.sum()), d]) - 0.5 * sides[d]
    np.testing.assert_allclose(off, 0.0, atol=1e-6)
    # So areas of faces are right, with what tiny facets have.
    for axis in range(2):
        for way in (-1.0, 1.0):
            of_face = way * facets.area @ np.clip(way * normal[:, axis], 0.0, None) * way
            assert of_face == pytest.approx(sides[1 - axis], abs=5e-3)
    for patch in range(facets.patches):
        some = normal[(facets.patch == patch) & large]
        assert len(some) == 0 or (some @ some[0]).min() > 0.99


def test_edges_and_corners_of_a_turned_box():
    """In 3D: each facet beside edges is parted into two faces, at corners into three."""
    axes = turned((17.0, 31.0))
    middle, sides = np.array([4.11, 4.07, 4.23]), np.array([4.0, 3.0, 3.5])
    facets = found(block(middle, sides, axes), 3)
    normal = facets.normal @ axes.T
    off = 1.0 - np.abs(normal).max(axis=1)
    assert facets.area[off > 1e-3].sum() < 2e-3 * facets.area.sum()
    for axis in range(3):
        area = facets.area[normal[:, axis] > 0.99].sum()
        assert area == pytest.approx(sides.prod() / sides[axis], rel=5e-3)


@pytest.mark.parametrize("angles", [(0.0, 0.0), (17.0, 0.0), (17.0, 31.0)])
def test_facets_have_the_second_moments_of_the_surface(angles):
    """Integrals of x_i x_j n over it, which are those of derivatives over the volume."""
    middle, sides, axes = np.array([4.11, 4.07, 4.23]), np.array([4.0, 3.0, 3.5]), turned(angles)
    facets = found(block(middle, sides, axes), 3)
    x, edges = facets.x - middle, facets.edges
    second = x[:, :, None] * x[:, None] + np.einsum("nki,nkj->nij", edges, edges) / 3.0
    whole = np.einsum("n,nij,nk->ijk", facets.area, second, facets.normal)
    np.testing.assert_allclose(whole, 0.0, atol=2e-3)
    some = facets.normal @ axes[1] > 0.99  # of a face: about its middle
    away = second[some] - 1.5**2 * np.outer(axes[1], axes[1])
    whole = np.einsum("n,nij->ij", facets.area[some], axes @ away @ axes.T)
    np.testing.assert_allclose(np.diag(whole)[[0, 2]], 14.0 * sides[[0, 2]] ** 2 / 12.0, rtol=2e-3)


def test_faces_that_bodies_go_on_behind_have_no_facets():
    region = Box(min=[-1.0, 2.0], max=[4.2, 6.1])
    facets = facets_of(
        LatticeBody(region, [np.arange(0, 19) * 0.5] * 2, [np.arange(18) * 0.5 + 0.25] * 2,
                    True, True),
        np.zeros(2), np.ones(2), [(0, -1)],
    )  # fmt: skip
    assert not (facets.normal[:, 0] < -0.5).any()
    assert facets.area.sum() == pytest.approx(4.1 + 2.0 * 4.2, rel=1e-6)
