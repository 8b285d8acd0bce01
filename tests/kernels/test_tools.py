"""What rigid bodies fill of a vertex's neighbourhood, against sums over many points."""

import numpy as np
import pytest
from scenes import box, scene

from pgimp.case.schema import Case
from pgimp.geometry.distancefield import distance_field
from pgimp.geometry.outline import outline
from pgimp.geometry.regions import Ball, Box
from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.fill import fill
from pgimp.mpi.comm import Serial
from pgimp.scene.scene import Scene

pytestmark = pytest.mark.slow(20)


@kernel
def filled(rigid_bodies, frame, numbers, sides, out):
    """What the first body fills of vertices, and its surface."""
    for i in range(len(numbers)):
        number = (numbers[i, 0], numbers[i, 1], numbers[i, 2])
        side = (sides[0], sides[1], sides[2])
        if fill(rigid_bodies, 0, frame, number, side):
            out[i, 0] = rigid_bodies.point[0].filled
            for d in range(3):
                out[i, 1 + d] = rigid_bodies.point[0].surface[d]


@kernel
def bends(rigid_bodies, frame, numbers, out):
    """What curvature of the first body adds to the gap at vertices near it."""
    for i in range(len(numbers)):
        if fill(rigid_bodies, 0, frame, (numbers[i, 0], numbers[i, 1], numbers[i, 2]), (0, 0, 0)):
            out[i] = rigid_bodies.point[0].curvature_gap


def rigid_body_of(D, region, cell, motion=None):
    """The frame of a scene with a rigid body, and the body for kernels, as the run begins."""
    size = [12.0 * h for h in cell]
    low = [0.1 * h for h in cell]
    bodies = {
        "soft": box(low, [1.1 * h for h in cell]),
        "tool": {"rigid": motion or {}, "region": region},
    }
    case = scene(D, bodies, cells=[12] * D, cell=cell)
    case["grid"]["size"] = size
    made = Scene(Case.model_validate(case))
    made.interaction.rigid_bodies.measure(Serial())
    return made, made.interaction.rigid_bodies.at(0.5, 0.75)


def expected(scene_, region, place, sides):
    """Part of the tent round a place that lies in a region, by sums over many points."""
    h = np.array(scene_.domain.frame.cell)
    n = (4000, 200, 40)[len(h) - 1]
    t = (np.arange(2 * n) + 0.5) / n - 1.0
    grid = np.stack(np.meshgrid(*[t] * len(h), indexing="ij"), axis=-1).reshape(-1, len(h))
    weight = np.prod(1.0 - np.abs(grid), axis=1)
    for d, side in enumerate(sides[: len(h)]):
        weight[grid[:, d] * side > 0.0] = 0.0
    points = np.array(place) + grid * h
    return float(weight[region.signed_distance(points) < 0.0].sum() / weight.sum())


def random_plane(rng, D):
    n = rng.normal(size=D)
    return n / np.linalg.norm(n)


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("walls", [False, True])
def test_parts_below_planes_at_any_angle(D, walls):
    """To what sums over many points leave; the normal is the plane's."""
    rng = np.random.default_rng(5 + D)
    cell = [1.0, 0.7, 1.3][:D]
    for _ in range(3):
        n, middle = random_plane(rng, D), np.array([6.0 * h for h in cell])
        whole = {"box": {"min": [-3.0] * D, "max": [20.0] * D}}
        region = {
            "intersection": [whole, {"half-space": {"point": list(middle), "normal": list(n)}}]
        }
        scene_, rigid_bodies = rigid_body_of(D, region, cell)
        exact = scene_.interaction.rigid_bodies.entries[0].region
        ghost, near = scene_.domain.frame.ghost, rng.integers(5, 8, size=(8, 3))
        sides = np.zeros(3, np.int64)
        if walls and D > 1:  # on which the plane stands, else what is beyond them counts
            n[-1], sides[D - 1] = 0.0, -1
            n /= np.linalg.norm(n)
            region["intersection"][1]["half-space"]["normal"] = list(n)
            scene_, rigid_bodies = rigid_body_of(D, region, cell)
            exact = scene_.interaction.rigid_bodies.entries[0].region
        out = np.zeros((len(near), 4))
        filled(rigid_bodies, scene_.domain.frame, near + ghost, sides, out)
        for number, found in zip(near, out, strict=True):
            place = number[:D] * np.array(cell)
            part = expected(scene_, exact, place, sides)
            assert found[0] == pytest.approx(part, abs=(2e-4, 2e-3, 4e-3)[D - 1])  # of the sums
            area = np.linalg.norm(found[1:])
            if 0.05 < part < 0.95:
                assert found[1 : 1 + D] / area == pytest.approx(n, abs=1e-9)


def test_round_bodies_and_edges():
    """Balls of five cells within a fiftieth, the edges of boxes within an eighth."""
    cell = [1.0, 1.0]
    for entry, near in (
        ({"ball": {"centre": [6.2, 6.4], "radius": 5.0}}, 0.02),
        ({"box": {"min": [2.3, 2.6], "max": [6.3, 6.1]}}, 0.125),
    ):
        scene_, rigid_bodies = rigid_body_of(2, entry, cell)
        region = scene_.interaction.rigid_bodies.entries[0].region
        numbers = np.array([[i, j, 0] for i in range(13) for j in range(13)])
        out = np.zeros((len(numbers), 4))
        filled(
            rigid_bodies,
            scene_.domain.frame,
            numbers + scene_.domain.frame.ghost,
            np.zeros(3, np.int64),
            out,
        )
        for number, found in zip(numbers, out, strict=True):
            part = expected(scene_, region, number[:2] * 1.0, (0, 0))
            assert found[0] == pytest.approx(part, abs=near)
        total, volume = out[:, 0].sum(), expected_volume(region)
        assert total == pytest.approx(volume, rel=0.02)


def expected_volume(region):
    low, high = region.bounds()
    if isinstance(region, Ball):
        return np.pi * region.radius**2
    return float(np.prod(np.subtract(high, low)))


def test_a_body_that_moves_is_where_its_motion_says():
    """Parts of a turned and moved box are those of the box in its new place."""
    motion = {"velocity": [0.8, -0.4], "rotation": {"about": [6.0, 6.0], "rate": 0.6}}
    region = {"box": {"min": [3.0, 4.0], "max": [8.0, 7.0]}}
    scene_, rigid_bodies = rigid_body_of(2, region, [1.0, 1.0], motion)
    pose = scene_.interaction.rigid_bodies.entries[0].rigid.pose(0.5)
    turn = np.array(pose.turn).reshape(3, 3)[:2, :2]
    numbers = np.array([[i, j, 0] for i in range(2, 11) for j in range(2, 11)])
    out = np.zeros((len(numbers), 4))
    filled(
        rigid_bodies,
        scene_.domain.frame,
        numbers + scene_.domain.frame.ghost,
        np.zeros(3, np.int64),
        out,
    )

    class Moved:
        @staticmethod
        def signed_distance(points):
            own = (points - np.array(pose.centre)[:2]) @ turn + 6.0
            return Box(min=(3.0, 4.0), max=(8.0, 7.0)).signed_distance(own)

    assert pose.centre == pytest.approx((6.4, 5.8, 0.0))
    for number, found in zip(numbers, out, strict=True):
        part = expected(scene_, Moved, number[:2] * 1.0, (0, 0))
        assert found[0] == pytest.approx(part, abs=0.125)


@pytest.mark.parametrize("D", [1, 2, 3])
def test_outlines_are_closed_and_on_the_surface(D):
    region = Ball(centre=(0.5, 0.4, 0.3)[:D], radius=0.35)
    points, cells = outline(distance_field(region, (0.1,) * D), D)
    assert np.abs(region.signed_distance(points[:, :D])).max() < 0.004
    assert cells.shape[1] == 2 ** (D - 1)
    faces = {1: 2, 2: 0, 3: 2}[D]  # of a sphere: vertices, less edges, plus faces
    edges = 0 if D < 3 else 2 * len(cells)
    count = len(points) - edges + len(cells) if D == 3 else len(points) - len(cells) * (D == 2)
    assert count == faces


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("radius", [6.0, 9.0])
@pytest.mark.parametrize("hollow", [False, True])
def test_curvature_of_balls_and_hollows(D, radius, hollow):
    """What it adds to the gap, (1/12 + 1/16)/R of a cell a direction; less in hollows, as it bends.

    To what the lattice of half cells leaves: at vertices within a cell of the surface.
    """
    centre = np.full(D, 6.3) + (radius - 2.0 if hollow else -radius + 1.0) * np.eye(D)[0]
    region = {"ball": {"centre": centre.tolist(), "radius": radius}}
    if hollow:
        whole = {"box": {"min": [-4.0] * D, "max": [20.0] * D}}
        region = {"difference": [whole, region]}
    scene_, rigid_bodies = rigid_body_of(D, region, [1.0] * D)
    numbers = np.stack(np.meshgrid(*[np.arange(3, 10)] * D, indexing="ij"), axis=-1).reshape(-1, D)
    away = np.linalg.norm(numbers - centre, axis=1)
    near = np.abs(away - radius) < 1.0
    numbers = np.pad(numbers[near], ((0, 0), (0, 3 - D)))
    out = np.zeros(len(numbers))
    bends(rigid_bodies, scene_.domain.frame, numbers + scene_.domain.frame.ghost, out)
    exact = (1.0 / 12.0 + 1.0 / 16.0) * (D - 1) / away[near] * (-1.0 if hollow else 1.0)
    assert len(out) > 4
    assert out == pytest.approx(exact, rel=0.1)


def test_edges_and_flat_faces_have_no_curvature():
    scene_, rigid_bodies = rigid_body_of(
        2, {"box": {"min": [3.3, 2.6], "max": [8.4, 8.1]}}, [1.0, 1.0]
    )
    numbers = np.array([[3, 5, 0], [8, 6, 0], [5, 8, 0], [6, 3, 0], [3, 3, 0], [8, 8, 0]])
    out = np.ones(len(numbers))
    bends(rigid_bodies, scene_.domain.frame, numbers + scene_.domain.frame.ghost, out)
    assert np.abs(out).max() < 1e-9
