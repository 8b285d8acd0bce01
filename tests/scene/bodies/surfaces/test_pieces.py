"""Pieces of surfaces: points near each other, sections of boxes, faces that pieces share."""

import numpy as np
import pytest

from pgimp.geometry.measure import measure
from pgimp.geometry.regions import Ball, Box
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.beside import beside
from pgimp.scene.bodies.surfaces.cut import cut_elements


@pytest.mark.parametrize("D", [1, 2, 3])
def test_points_beside_places_are_those_of_all_pairs(D):
    draw = np.random.default_rng(D)
    x, points = draw.uniform(-3.0, 3.0, (40, D)), draw.uniform(-4.0, 4.0, (150, D))
    away = draw.uniform(0.1, 1.5, 40)
    near = (np.abs(x[:, None] - points[None]) < away[:, None, None]).all(axis=2)
    np.testing.assert_array_equal(np.stack(beside(x, away, points)), np.nonzero(near))
    assert len(beside(x[:0], away[:0], points)[0]) == len(beside(x, away, points[:0])[0]) == 0


def test_sections_of_a_ball_are_disks():
    """In thin boxes across an axis: area, first moments and products of sections in closed form."""
    at, radius = np.array([-0.9, -0.3, 0.2, 0.8]), 1.3
    low = np.column_stack([at, np.full((4, 2), -2.0)])
    high = np.column_stack([at + 1e-6, np.full((4, 2), 2.0)])
    ball = Ball(centre=[0.0, 0.25, -0.125], radius=radius)
    # Cut into many: a rule between two crossings is not exact for a circle.
    n = 128
    y = np.linspace(-2.0, 2.0, n + 1)
    cells = [(row, j, k) for row in range(4) for j in range(n) for k in range(n)]
    row, j, k = np.array(cells).T
    a, b = low[row], high[row]
    a[:, 1], b[:, 1], a[:, 2], b[:, 2] = y[j], y[j + 1], y[k], y[k + 1]
    volume, moment = measure(ball, a, b, 4, across=np.zeros(len(a), np.int64))
    middle = 0.5 * (a + b)
    area = volume / (b - a)[:, 0]
    sums = np.bincount(row, area)
    square = radius**2 - (at + 0.5e-6) ** 2
    np.testing.assert_allclose(sums, np.pi * square, rtol=1e-5)
    for d, centre in ((1, 0.25), (2, -0.125)):
        first = np.bincount(row, moment[:, d] / (b - a)[:, 0] + middle[:, d] * area)
        np.testing.assert_allclose(first / sums, centre, atol=1e-6)


def test_faces_that_pieces_share_are_as_those_measured_alone():
    """Elements of a box that is not on the lattice, in a lattice or a part of it, are the same."""
    edges = [np.arange(17) * 0.5] * 3
    box = Box(min=[1.13, 2.21, 1.57], max=[6.02, 5.91, 5.33])
    body = LatticeBody(box, edges, [e[:-1] + 0.25 for e in edges], True, True)
    every = [np.arange(16)] * 3
    whole = cut_elements(body, every, (), (box,))
    size = np.sqrt((whole.area**2).sum(axis=1))
    sides = np.array([4.89, 3.7, 3.76])
    assert size.sum() == pytest.approx(2.0 * (sides.prod() / sides).sum(), rel=1e-12)
    for low, high in ((0, 5), (5, 6), (6, 16)):
        part = cut_elements(body, [np.arange(low, high), *every[1:]], (), (box,))
        mine = (whole.box[:, 0] >= low) & (whole.box[:, 0] < high)
        for one, other in zip(part, whole.chosen(mine), strict=True):
            np.testing.assert_array_equal(one, other)
