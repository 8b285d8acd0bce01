"""Regions: which points are inside, and the boxes around them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from region_entries import ball, box, cylinder, entries, half_space, region


def cloud(dimensions, n, half):
    """A regular lattice of n points a direction that fills a cube around the origin."""
    x = (np.arange(n) + 0.5) / n * 2 * half - half
    return np.stack(np.meshgrid(*[x] * dimensions, indexing="ij"), axis=-1).reshape(-1, dimensions)


def volume(entry, dimensions, n, half=1.5):
    inside = region(**entry).contains(cloud(dimensions, n, half))
    assert inside.dtype == bool
    return inside.mean() * (2 * half) ** dimensions


@pytest.mark.parametrize(
    ("entry", "dimensions", "expected"),
    [
        (box([-0.5], [1.0]), 1, 1.5),
        (box([-0.5, -1.2], [1.0, 0.3]), 2, 2.25),
        (box([-0.5, -1.0, 0.0], [1.0, 0.5, 1.2]), 3, 2.7),
        (ball([0.1], 0.9), 1, 1.8),
        (ball([0.1, -0.2], 1.2), 2, math.pi * 1.44),
        (ball([0.1, -0.2, 0.05], 1.2), 3, 4 / 3 * math.pi * 1.728),
        (cylinder([0, 0, -1], [0, 0, 1], 0.8), 3, math.pi * 0.64 * 2),
        (cylinder([-0.7, -0.6, -0.5], [0.6, 0.7, 0.4], 0.5), 3, math.pi * 0.25 * math.sqrt(4.19)),
        # Two overlapping disks: the lens of radius 1 and distance 1 is counted once.
        (
            {"union": [ball([-0.5, 0], 0.9), ball([0.5, 0], 0.9)]},
            2,
            2 * math.pi * 0.81 - (2 * 0.81 * math.acos(1 / 1.8) - 0.5 * math.sqrt(4 * 0.81 - 1)),
        ),
        ({"difference": [ball([0, 0], 1.2), ball([0, 0], 0.7)]}, 2, math.pi * (1.44 - 0.49)),
        (
            {"difference": [box([-1, -1, -1], [1, 1, 1]), cylinder([0, 0, -2], [0, 0, 2], 0.5)]},
            3,
            8 - 2 * math.pi * 0.25,
        ),
        (
            {"difference": [box([-1, -1], [1, 1]), box([-1, -1], [0, 0]), box([0, 0], [1, 1])]},
            2,
            2.0,
        ),
    ],
)
def test_volumes(entry, dimensions, expected):
    # The planes between the points of these lattices hold all faces of the boxes above.
    n = 3000 if dimensions < 3 else 150
    assert volume(entry, dimensions, n) == pytest.approx(expected, rel=2e-3)


COORDINATE = st.floats(-1e6, 1e6)


@given(st.data(), st.integers(1, 3))
def test_touching_boxes_share_no_point_and_leave_none_out(data, dimensions):
    edges = [
        sorted(data.draw(st.lists(COORDINATE, min_size=3, max_size=3, unique=True)))
        for _ in range(dimensions)
    ]
    points = np.array(np.meshgrid(*edges)).reshape(dimensions, -1).T
    parts = np.zeros(len(points), dtype=int)
    for corner in np.ndindex(*(2,) * dimensions):
        low = [edges[d][i] for d, i in enumerate(corner)]
        high = [edges[d][i + 1] for d, i in enumerate(corner)]
        parts += region(**box(low, high)).contains(points)
    whole = region(**box([e[0] for e in edges], [e[2] for e in edges])).contains(points)
    assert (parts == whole).all()
    assert whole.sum() == 2**dimensions


@given(st.lists(COORDINATE, min_size=3, max_size=3, unique=True), st.integers(0, 2))
def test_stacked_cylinders_share_no_point(ends, axis):
    bottom, middle, top = (np.eye(3)[axis] * end for end in sorted(ends))
    points = np.array([bottom, middle, top, 0.5 * (bottom + middle)])
    lower = region(**cylinder(list(bottom), list(middle), 1.0)).contains(points)
    upper = region(**cylinder(list(middle), list(top), 1.0)).contains(points)
    assert not (lower & upper).any()
    assert lower[0] and upper[1] and not upper[2]


def test_surfaces():
    points = np.array([[1.0, 0.0], [0.0, -1.0], [np.nextafter(1.0, 0.0), 0.0]])
    assert region(**ball([0, 0], 1)).contains(points).tolist() == [False, False, True]
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0.5], [0, 0, -1e-9]])
    inside = region(**cylinder([0, 0, 0], [0, 0, 1], 1)).contains(points)
    assert inside.tolist() == [True, False, False, False]


def around(found, n, seed):
    """Points in and around a region, also one without an end or without a point, (n, D)."""
    low, high = (np.clip(end, -20.0, 20.0) for end in found.bounds())
    low, high = np.minimum(low, high) - 1, np.maximum(low, high) + 1
    return np.random.default_rng(seed).uniform(low, high, (n, len(low)))


def inside_plainly(entry, point):
    """Whether a point lies in a region, written down a second time, point by point."""
    ((kind, value),) = entry.items()
    if kind == "box":
        return all(a <= x < b for a, x, b in zip(value["min"], point, value["max"], strict=True))
    if kind == "ball":
        return math.dist(value["centre"], point) < value["radius"]
    if kind == "cylinder":
        a, b, p = (np.array(v) for v in (value["from"], value["to"], point))
        along = (p - a) @ (b - a) / ((b - a) @ (b - a))
        return 0 <= along < 1 and np.linalg.norm(p - a - along * (b - a)) < value["radius"]
    if kind == "half-space":
        return (np.array(point) - value["point"]) @ value["normal"] < 0
    if kind == "intersection":
        return all(inside_plainly(part, point) for part in value)
    if kind == "union":
        return any(inside_plainly(part, point) for part in value)
    return inside_plainly(value[0], point) and not any(inside_plainly(p, point) for p in value[1:])


@settings(max_examples=150, deadline=None)
@given(st.data(), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_points_inside_are_those_of_the_definition_and_within_the_bounds(data, dimensions, seed):
    entry = data.draw(entries(dimensions))
    found = region(**entry)
    low, high = found.bounds()
    points = around(found, 60, seed)
    inside = found.contains(points)
    # A random point that rounding puts on the other side of a surface is as good as impossible.
    assert inside.tolist() == [inside_plainly(entry, point) for point in points]
    assert (points[inside] >= np.array(low)).all()
    assert (points[inside] <= np.array(high)).all()
    for start, stop in ((0, 1), (7, 24), (59, 60), (0, 0)):
        assert (found.contains(points[start:stop]) == inside[start:stop]).all()


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
        (
            {"difference": [cylinder([0, 0, 0], [0, 0, 5], 1), *QUARTER[:1]]},
            [-1, -1, 0],
            [0, 1, 5],
        ),
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


def test_touching_half_spaces_share_no_point_and_leave_none_out():
    """As boxes: the low face belongs to the material."""
    rng = np.random.default_rng(5)
    for normal in (*np.eye(3), *rng.uniform(-1, 1, (20, 3))):
        foot = rng.uniform(-1, 1, 3)
        points = np.concatenate([[foot], rng.uniform(-2, 2, (50, 3))])
        one, other = (
            region(**half_space(foot.tolist(), n.tolist())).contains(points)
            for n in (normal, -normal)
        )
        assert (one != other).all()
        assert one[0] == (next(n for n in normal if n) < 0)
    unit = region(**box([0, 0], [1, 1]))
    sides = region(
        intersection=[
            half_space(p, n)
            for p, n in (([0, 0], [-1, 0]), ([0, 0], [0, -1]), ([1, 1], [1, 0]), ([1, 1], [0, 1]))
        ]
    )
    points = np.stack(np.meshgrid(*[[-0.5, 0.0, 0.5, 1.0, 1.5]] * 2), axis=-1).reshape(-1, 2)
    assert (unit.contains(points) == sides.contains(points)).all()


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


def test_the_centre_of_a_ball_may_be_its_center():
    one, other = ({"ball": {name: [0.5, 1.0], "radius": 2.0}} for name in ("centre", "center"))
    assert region(**one) == region(**other)
    both = {"ball": {"centre": [0.5, 1.0], "center": [0.5, 1.0], "radius": 2.0}}
    with pytest.raises(ValidationError, match="unknown key"):
        region(**both)
