"""Elements of surfaces: they close, have the area, and do not depend on the range of planes."""

import numpy as np
import pytest

from pgimp.geometry.regions import Ball, Box
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surfaces.parts import AWAY, parts_of
from pgimp.scene.bodies.surfaces.whole import face_elements

EVERYWHERE = {D: Box(min=[-99.0] * D, max=[99.0] * D) for D in (2, 3)}


def carried(lattice, x, planes):
    """Parts of the surface that particles at `x` in some planes carry."""
    planes = planes[0] - AWAY, planes[1] + AWAY
    return parts_of(lattice, find_elements(lattice, EVERYWHERE[x.shape[1]], planes), x, False)[0]


def body(region, D, cut=True, exact=False):
    """A body on a lattice of boxes of half a unit."""
    edges = [np.arange(17) * 0.5] * D
    return LatticeBody(region, edges, [e[:-1] + 0.25 for e in edges], cut, exact)


def positions(lattice):
    """Positions and volumes of the particles."""
    found = [(lattice.points(v.ranges, i), v.fraction(i)) for v in lattice.slabs((0, 16))
             for i in [np.flatnonzero(v.exists)]]  # fmt: skip
    x, part = (np.concatenate(each) for each in zip(*found, strict=True))
    return x, part * 0.5 ** x.shape[1]


@pytest.mark.parametrize("cut", [True, False])
@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["ball", "box"])
def test_elements_close_and_have_the_volume(kind, D, cut):
    ball = Ball(center=[4.1, 4.2, 3.9][:D], radius=2.53)
    lattice = body(ball if kind == "ball" else Box(min=[0.0] * D, max=[6.13] * D), D, cut)
    x, volume = positions(lattice)
    parts = carried(lattice, x, (0, 16))
    N, M = parts[:, 1 : 1 + D], parts[:, 1 + D :].reshape(-1, D, D)
    np.testing.assert_allclose(N.sum(axis=0), 0.0, atol=1e-9)
    moments = (M + x[:, :, None] * N[:, None, :]).sum(axis=0)
    np.testing.assert_allclose(moments, np.eye(D) * volume.sum(), atol=1e-5 * volume.sum())
    if kind == "ball" and cut:
        exact = (2.0 * np.pi * 2.53, 4.0 * np.pi * 2.53**2)[D - 2]
        assert parts[:, 0].sum() == pytest.approx(exact, rel=2e-2)


def test_ranges_of_planes_give_the_same_bits():
    lattice = body(Ball(center=[4.1, 4.2], radius=2.53), 2)
    x, _ = positions(lattice)
    whole = carried(lattice, x, (0, 16))
    for planes in ((0, 5), (5, 8), (8, 16)):
        mine = (x[:, 0] >= 0.5 * planes[0]) & (x[:, 0] < 0.5 * planes[1])
        np.testing.assert_array_equal(carried(lattice, x[mine], planes), whole[mine])


def test_faces_that_hold_have_no_surface():
    lattice = body(Box(min=[0.0, 0.0], max=[6.0, 6.0]), 2)
    found = find_elements(lattice, EVERYWHERE[2], (-2, 18), [(0, -1), (1, -1)])
    np.testing.assert_allclose(found.area.sum(axis=0), [6.0, 6.0], atol=1e-9)


@pytest.mark.parametrize("D", [2, 3])
def test_exact_elements_end_at_edges_and_regions(D):
    low, high = np.array([1.37, 1.21, 1.5])[:D], np.array([5.37, 5.21, 4.02])[:D]
    lattice = body(Box(min=low.tolist(), max=high.tolist()), D, exact=True)
    found = find_elements(lattice, EVERYWHERE[D], (0, 16))
    np.testing.assert_allclose(found.area.sum(axis=0), 0.0, atol=1e-12)
    sides = high - low
    size = np.sqrt((found.area**2).sum(axis=1))
    for d in range(D):
        up = found.chosen(found.area[:, d] > 0.99 * size)
        np.testing.assert_allclose(up.centroid[:, d], high[d], rtol=1e-12)
        np.testing.assert_allclose(up.area[:, d].sum(), np.delete(sides, d).prod(), rtol=1e-12)
        face = face_elements(lattice, d, 1, (0, 16))
        np.testing.assert_allclose(face.area.sum(axis=0), up.area.sum(axis=0), atol=1e-12)
        mean = [(each.centroid * each.area[:, d, None]).sum(axis=0) for each in (face, up)]
        np.testing.assert_allclose(*mean, rtol=1e-12)
    part = Box(min=[2.33, 5.0, 0.0][:D], max=[4.01, 9.0, 9.0][:D])
    within = find_elements(lattice, part, (0, 16))
    area = 1.68 * np.prod(sides[2:])
    np.testing.assert_allclose(within.area.sum(axis=0)[1], area, rtol=1e-12)


@pytest.mark.parametrize("D", [2, 3])
def test_pieces_of_exact_bodies_close_to_rounding(D):
    """Planes of regions cut boxes into pieces of many sizes, whose faces have the same areas."""
    lattice = body(Ball(center=[4.1, 4.2, 3.9][:D], radius=2.53), D, exact=True)
    area = find_elements(lattice, EVERYWHERE[D], (0, 16)).area
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-11)
