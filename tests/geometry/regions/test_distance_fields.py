"""Distances and normals of terrain and meshes against all triangles, and what they cost."""

from time import process_time

import numpy as np
import pytest
from meshes import ball, case, stl

from pgimp.case.schema import Case
from pgimp.geometry.distancefield import distance_field
from pgimp.geometry.regions import heights as heights_module
from pgimp.mpi.comm import Serial
from pgimp.scene.geometry import share
from pgimp.scene.rigid.checks import require_apart
from pgimp.scene.scene import Scene

pytestmark = pytest.mark.slow(30)


def to_segments(points, ends):
    """Distances of points, (n, D), from the nearest of segments, (m, 2, D)."""
    a, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    away = points[:, None] - a
    part = np.clip((away * along).sum(axis=2) / (along * along).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(away - part[..., None] * along, axis=2).min(axis=1)


def to_triangles(points, T):
    """Distances of points, (n, 3), from the nearest of triangles: feet within them, and edges."""
    found = np.min([to_segments(points, T[:, [k, (k + 1) % 3]]) for k in range(3)], axis=0)
    normal = np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.einsum("pti,ti->pt", points[:, None] - T[:, 0], normal)
    feet = points[:, None] - height[..., None] * normal
    within = np.ones(height.shape, bool)
    for k in range(3):
        across = np.cross(normal, T[:, (k + 1) % 3] - T[:, k])
        within &= np.einsum("pti,ti->pt", feet - T[:, k], across) >= 0.0
    return np.minimum(found, np.where(within, np.abs(height), np.inf).min(axis=1))


def region_of(written, dimension=3):
    return Case.model_validate(case(written, dimension)).bodies["body"].region


def terrain(path, z, step, dimension=3):
    np.save(path, z)
    horizontal = dimension - 1
    nodes = {"origin": [-1.5] * horizontal, "spacing": [step] * horizontal}
    return {"heights": {"file": str(path), "bottom": -1.5, "nodes": nodes}}


def compare(region, cell, distance):
    """Compare a field with distances, and with differences of them as wide as the field's."""
    field, D = distance_field(region, cell), len(cell)
    numbers = np.random.default_rng(2).choice(len(field.values), 400, replace=False)
    points, step = field.points(numbers, D), 1e-3 * field.spacing
    np.testing.assert_allclose(field.values[numbers, 0], distance(points), rtol=0, atol=1e-13)
    normals = np.zeros((len(points), 3))
    for d, ahead in enumerate(step * np.eye(D)):
        normals[:, d] = distance(points + ahead) - distance(points - ahead)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    np.testing.assert_allclose(field.values[numbers, 1:4], normals, rtol=0, atol=1e-8)


def signed(region, distance):
    return lambda points: np.where(region.contains(points), -1.0, 1.0) * distance(points)


@pytest.mark.parametrize("kind", ["terrain", "mesh", "profile", "union"])
def test_as_by_all_triangles(tmp_path, kind):
    """Points inside and outside, near and far, above edges and beyond corners."""
    z = np.random.default_rng(4).uniform(-0.6, 0.9, (9, 9))
    if kind == "profile":
        region = region_of(terrain(tmp_path / "z.npy", z[0], 0.375, 2), 2)
        x = -1.5 + 0.375 * np.arange(9)
        outline = np.array([*zip(x, z[0], strict=True), (x[-1], -1.5), (x[0], -1.5)])
        ends = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
        compare(region, (0.3, 0.3), signed(region, lambda x: to_segments(x, ends)))
        return
    if kind == "mesh":
        T = stl(tmp_path / "ball.stl", ball(2, 1.1, (0.1, 0.2, -0.1)))
        region = region_of({"mesh": {"file": str(tmp_path / "ball.stl")}})
    else:
        region = region_of(terrain(tmp_path / "z.npy", z, 0.375))
        T = region.surface.triangles
    alone = signed(region, lambda x: to_triangles(x, T))
    if kind != "union":
        compare(region, (0.4, 0.5, 0.45), alone)
        return
    box = {"box": {"min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 1.4]}}
    both = region_of({"union": [terrain(tmp_path / "z.npy", z, 0.375), box]})
    wall = region_of(box)
    compare(both, (0.4, 0.5, 0.45), lambda x: np.minimum(alone(x), wall.signed_distance(x)))


def test_as_many_triangles_as_are_equally_near(tmp_path):
    """In the middle of a ball every triangle is: the list of those that may be nearest grows."""
    stl(tmp_path / "ball.stl", ball(4))
    region = region_of({"mesh": {"file": str(tmp_path / "ball.stl")}})
    T, at = region.surface.triangles, np.array([[0.0, 0.0, 0.0], [1e-9, 2e-9, -1e-9]])
    assert len(T) == 2048
    found = region.distances_around(at, 0.01)
    for k, place in enumerate(np.concatenate([[[0.0] * 3], 0.01 * np.eye(3), -0.01 * np.eye(3)])):
        np.testing.assert_allclose(-found[:, k], to_triangles(at + place, T), rtol=0, atol=1e-14)


def on_terrain(path, n):
    """A body that lies on rigid terrain, cut by it, in a domain of the terrain's size."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    rough = 0.02 * np.random.default_rng(1).standard_normal((n, n))
    ground = terrain(path, 0.3 * np.sin(0.03 * x) * np.cos(0.02 * y) + rough, 3.0 / (n - 1))
    model = case({"difference": [{"box": {"min": [-1.0] * 3, "max": [1.0] * 3}}, ground]}, cell=0.1)
    model["bodies"]["hill"] = {"rigid": {}, "region": ground}
    model["contact"] = [{"bodies": ["body", "hill"]}]
    return Case.model_validate(model)


def set_up(made):
    """Do with a case's rigid bodies what a run does before its first step."""
    share(made, Serial())
    rigid = Scene(made).interaction.rigid_bodies
    rigid.measure(Serial(), keep=True)
    x = np.random.default_rng(3).uniform(-1.0, 1.0, (2000, 3))
    x = x[made.bodies["body"].region.contains(x)]
    require_apart(rigid, [(x, np.zeros(len(x), np.int32))], Serial())
    return rigid


def test_the_time_of_terrain_of_a_million_nodes_grows_with_their_number(tmp_path, monkeypatch):
    """It is read once, for the rigid body and for what lies on it, and no run keeps it."""
    read, reads = heights_module.Heights.__dict__["surface"].func, []
    monkeypatch.setattr(
        heights_module.Heights.__dict__["surface"],
        "func",
        lambda region: reads.append(region) or read(region),
    )
    set_up(on_terrain(tmp_path / "z.npy", 20))  # compiles
    assert len(reads) == 1
    times = []
    for nodes in (250, 1000):
        made = on_terrain(tmp_path / "z.npy", nodes)
        began = process_time()
        rigid = set_up(made)
        times.append(process_time() - began)
    assert len(rigid.fields[0].values) > 200_000
    assert len(reads) == 3
    assert "surface" not in made.rigid_bodies["hill"].region.__dict__
    # Sixteen times as many nodes; some 3 s on an idle core.
    assert times[1] < 32.0 * times[0], times
