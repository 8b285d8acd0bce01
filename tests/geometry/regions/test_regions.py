"""Regions: which points are inside."""

import math

import numpy as np
import pytest
from around_regions import around
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


def test_the_centre_of_a_ball_may_be_its_center():
    one, other = ({"ball": {name: [0.5, 1.0], "radius": 2.0}} for name in ("centre", "center"))
    assert region(**one) == region(**other)
    both = {"ball": {"centre": [0.5, 1.0], "center": [0.5, 1.0], "radius": 2.0}}
    with pytest.raises(ValidationError, match="unknown key"):
        region(**both)
