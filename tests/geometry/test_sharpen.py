"""Outlines of rigid bodies for pictures: corners, edges and areas of regions, by hand."""

import numpy as np
import pytest

from pgimp.geometry.distancefield import distance_field
from pgimp.geometry.outline import outline
from pgimp.geometry.regions import Ball, Box, Cylinder, Difference, Intersection, Mesh, Union
from pgimp.geometry.sharpen import sharpened

CELL = 0.1


def drawn(region, D):
    """Vertices and cells of the outline on cells of a tenth."""
    field = distance_field(region, (CELL,) * D)
    points, cells = outline(field, D)
    return sharpened(points, field, region)[:, :D], cells


def area(points, cells):
    """Area within closed lines, which may be joined in any order and direction."""
    total, left = 0.0, {tuple(sorted(cell)) for cell in cells.tolist()}
    while left:
        a, b = left.pop()
        path = [a, b]
        while path[-1] != path[0]:
            edge = next(edge for edge in left if path[-1] in edge)
            left.remove(edge)
            path.append(sum(edge) - path[-1])
        x, y = points[path].T
        total += abs(0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum())
    return total


def half(point, normal):
    return {"half-space": {"point": point, "normal": normal}}


def box(low, high):
    return {"box": {"min": low, "max": high}}


#: A wedge whose point is narrower than the lattice, 1 high and 0.5 wide.
WEDGE = [half([0.0, 0.0], [1.0, -0.25]), half([0.0, 0.0], [-1.0, -0.25]),
         half([0.0, 1.0], [0.0, 1.0])]  # fmt: skip
BALL = {"ball": {"centre": [0.5, 1.0], "radius": 0.3}}


@pytest.mark.parametrize(
    ("region", "exact", "corners"),
    [
        (Box(min=(0.13, 0.2), max=(1.0, 0.7)), 0.87 * 0.5, [(0.13, 0.2), (1.0, 0.7)]),
        (
            Box(min=(0.1, 0.2), max=(1.0, 0.7)),
            0.9 * 0.5,
            [(0.1, 0.7), (1.0, 0.2)],
        ),  # on the lattice
        (Intersection.model_validate(WEDGE), 0.25, [(0.0, 0.0), (0.25, 1.0), (-0.25, 1.0)]),
        (
            Union.model_validate([box([0.0, 0.0], [1.0, 0.3]), box([0.0, 0.0], [0.33, 1.0])]),
            0.3 + 0.33 * 0.7,
            [(0.33, 0.3), (0.0, 1.0)],
        ),
    ],
)
def test_flat_bodies_have_their_corners_and_their_area(region, exact, corners):
    points, cells = drawn(region, 2)
    assert area(points, cells) == pytest.approx(exact, rel=1e-7)
    for corner in corners:
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-8


def test_round_bodies_have_their_edges():
    """Chords of half a cell; a hole's edges are where its circle meets the side."""
    region = Difference.model_validate([box([0.0, 0.0], [1.0, 1.0]), BALL])
    points, cells = drawn(region, 2)
    assert area(points, cells) == pytest.approx(1.0 - 0.5 * np.pi * 0.09, rel=1e-3)
    assert np.abs(region.signed_distance(points)).max() < 1e-8
    for corner in ((0.2, 1.0), (0.8, 1.0), (0.0, 0.0)):
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-6
    points, cells = drawn(Ball(centre=(0.5, 0.5), radius=0.4), 2)
    assert area(points, cells) == pytest.approx(np.pi * 0.16, rel=3e-3)
    ends = {"from": [0.5, 0.5, 0.0], "to": [0.5, 0.5, 1.0]}
    region = Cylinder.model_validate(ends | {"radius": 0.4})
    points, _ = drawn(region, 3)
    radius = np.hypot(*(points[:, :2] - 0.5).T)
    assert radius.max() == pytest.approx(0.4, abs=1e-8)
    rim = (points[:, 2] < 1e-6) & (radius > 0.4 - 1e-6)
    assert rim.sum() > 40  # along 2.5


def test_meshes_have_their_corners(tmp_path):
    """A tetrahedron from a file, whose edges are at no angle of the lattice."""
    corners = np.array([[0.0, 0.0, 0.0], [1.1, 0.1, 0.0], [0.2, 1.0, 0.1], [0.3, 0.2, 1.2]])
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    text = ["solid t"]
    for face in faces:
        rows = [f"vertex {x} {y} {z}" for x, y, z in corners[face]]
        text += ["facet normal 0 0 0", "outer loop", *rows, "endloop", "endfacet"]
    (tmp_path / "t.stl").write_text("\n".join([*text, "endsolid t", ""]))
    region = Mesh(file=str(tmp_path / "t.stl"))
    region.belong(3)
    points, _ = drawn(region, 3)
    for corner in corners:
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-6
    assert np.abs(region.signed_distance(points)).max() < 1e-8
