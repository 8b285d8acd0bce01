"""Regions: the boxes around them, how far their surfaces are, where lines cross these."""

import math

import numpy as np
import pytest
from around_regions import around
from hypothesis import given, settings
from hypothesis import strategies as st
from region_entries import ball, box, cylinder, entries, half_space, region


def test_bounds_are_tight():
    assert region(**ball([1, 2], 0.5)).bounds() == ((0.5, 1.5), (1.5, 2.5))
    assert region(**cylinder([0, 0, 1], [0, 0, 3], 2)).bounds() == ((-2, -2, 1), (2, 2, 3))
    low, high = region(**cylinder([0, 0, 0], [1, 1, 0], 1)).bounds()
    assert low == pytest.approx((-math.sqrt(0.5), -math.sqrt(0.5), -1))
    assert high == pytest.approx((1 + math.sqrt(0.5), 1 + math.sqrt(0.5), 1))
    both = {"union": [box([0, 0], [1, 1]), ball([3, -1], 0.5)]}
    assert region(**both).bounds() == ((0.0, -1.5), (3.5, 1.0))
    cut = {"difference": [box([0, 0], [1, 1]), ball([3, -1], 2.5)]}
    assert region(**cut).bounds() == ((0.0, 0.0), (1.0, 1.0))


QUARTER = [half_space([0, 0, 0], [-1, 0, 0]), half_space([0, 0, 0], [0, -2, 0])]
INFINITE = math.inf


@pytest.mark.parametrize(
    ("entry", "low", "high"),
    [
        # Quarters of a ball, made in three ways.
        ({"intersection": [ball([0, 0, 0], 2), *QUARTER]}, [0, 0, -2], [2, 2, 2]),
        ({"intersection": [ball([0, 0, 0], 2), box([0, 0, -3], [3, 3, 3])]}, [0, 0, -2], [2, 2, 2]),
        (
            {
                "difference": [
                    ball([0, 0, 0], 2),
                    box([-3, -3, -3], [0, 3, 3]),
                    box([-3, -3, -3], [3, 0, 3]),
                ]
            },
            [0, 0, -2],
            [2, 2, 2],
        ),
        ({"difference": [ball([0, 0], 1), half_space([0.6, 0], [1, 0])]}, [0.6, -0.8], [1, 0.8]),
        # Of a tilted cut the circle has its end where the plane lets it: at 45 degrees.
        (
            {"intersection": [ball([0, 0], 1), half_space([0, 0], [1, 1])]},
            [-1, -1],
            [math.sqrt(0.5)] * 2,
        ),
        ({"difference": [cylinder([0, 0, 0], [0, 0, 5], 1), *QUARTER[:1]]}, [-1, -1, 0], [0, 1, 5]),
        (
            {"intersection": [cylinder([-3, 0, 0], [3, 0, 0], 1), half_space([0] * 3, [1, 0, 1])]},
            [-3, -1, -1],
            [1, 1, 1],
        ),
        # Two balls meet in a circle; a pin with a round end.
        ({"intersection": [ball([0, 0], 5), ball([6, 0], 5)]}, [1, -4], [5, 4]),
        ({"difference": [ball([0, 0], 5), ball([3, 0], 4)]}, [-5, -5], [3, 5]),
        (
            {"intersection": [ball([0, 0, 0], 5), cylinder([0, 0, 0], [0, 0, 9], 3)]},
            [-3, -3, 0],
            [3, 3, 5],
        ),
        (
            {"difference": [ball([0, 0, 0], 5), cylinder([0, 0, -9], [0, 0, 9], 3)]},
            [-5, -5, -4],
            [5, 5, 4],
        ),
        # Only half-spaces: a triangle, and a wedge without an end.
        (
            {"intersection": [half_space([0, 0], n) for n in ([-1, -1], [1, -1])]},
            [-INFINITE, 0],
            [INFINITE, INFINITE],
        ),
        (
            {
                "intersection": [
                    half_space([0, 0], [-1, -1]),
                    half_space([0, 0], [1, -1]),
                    half_space([0, 2], [0, 1]),
                ]
            },
            [-2, 0],
            [2, 2],
        ),
        ({"union": [ball([0], 1), half_space([3], [-1])]}, [-1], [INFINITE]),
        ({"intersection": [ball([0], 1), half_space([3], [-1])]}, [3], [1]),
        ({"difference": [ball([0, 0], 1), ball([0.1, 0], 2)]}, [INFINITE] * 2, [-INFINITE] * 2),
        # Round surfaces that meet in no plane: wide enough.
        (
            {"intersection": [ball([0, 0, 0], 1), cylinder([0.5, 0, -2], [0.5, 0, 2], 1)]},
            [-0.5, -1, -1],
            [1, 1, 1],
        ),
    ],
)
def test_bounds_of_combinations_are_exact(entry, low, high):
    found = region(**entry).bounds()
    for end, expected in zip(found, (low, high), strict=True):
        np.testing.assert_allclose(end, np.array(expected, float), rtol=0, atol=1e-12)


@settings(max_examples=300, deadline=None)
@given(st.data(), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_no_point_inside_is_beyond_the_bounds(data, dimensions, seed):
    found = region(**data.draw(entries(dimensions, 3)))
    low, high = found.bounds()
    points = around(found, 5000, seed)
    points = points[found.contains(points)]
    assert ((low <= points) & (points <= high)).all()


@st.composite
def regions_and_points(draw, n):
    """A region of any kind in any dimension, and points in and around it."""
    found = region(**draw(entries(draw(st.integers(1, 3)))))
    return found, around(found, n, draw(st.integers(0, 2**32 - 1)))


@settings(max_examples=150, deadline=None)
@given(regions_and_points(60))
def test_no_surface_is_nearer_than_the_distance(data):
    found, points = data
    distance, inside = found.distance(points), found.contains(points)
    assert (inside == (distance < 0)).all()
    for p, d, within in zip(points, distance, inside, strict=True):
        way = np.sqrt(((points - p) ** 2).sum(axis=1))
        assert (np.abs(found.distance(points) - d) <= way * (1 + 1e-12) + 1e-12).all()
        assert (inside[way < abs(d)] == within).all()


@settings(max_examples=150, deadline=None)
@given(regions_and_points(20), st.integers(0, 2))
def test_lines_enter_and_leave_at_crossings_only(data, axis):
    found, points = data
    axis %= points.shape[1]
    crossings = found.crossings(points, axis)
    for p, at in zip(points, crossings, strict=True):
        line = np.tile(p, (200, 1))
        line[:, axis] = np.linspace(p[axis] - 12, p[axis] + 12, 200)
        inside = found.contains(line)
        for i in np.flatnonzero(inside[1:] != inside[:-1]):
            a, b = line[i : i + 2, axis]
            assert ((a - 1e-9 <= at) & (at <= b + 1e-9)).any()


@settings(max_examples=150, deadline=None)
@given(regions_and_points(40), st.floats(0.05, 3.0))
def test_a_box_that_neither_planes_nor_curves_meet_is_uniform(data, size):
    found, points = data
    D = points.shape[1]
    rng = np.random.default_rng(1)
    clear = found.curved(points) >= 0.5 * size * math.sqrt(D)
    for p in points[clear]:
        low, high = p - size / 2, p + size / 2
        met = any(
            (low <= plane.high).all() and (plane.low <= high).all() for plane in found.planes()
        )
        if not met:
            inside = found.contains(rng.uniform(low, high, (50, D)))
            assert (inside == inside[0]).all()
