"""Bodies from mesh files: exact volumes, holes, orientation; the same bits on ranks."""

from pathlib import Path

import meshio
import numpy as np
import pytest
from mesh_bodies import BALL, mesh
from meshes import ball, case, filled, stl, torus, volume
from scenes import write_case

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError

pytestmark = pytest.mark.slow(120)

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("cell", [0.5, 0.31])
@pytest.mark.parametrize("shape", ["ball", "torus", "cavity"])
def test_volume_is_that_of_the_mesh(tmp_path, shape, cell):
    """Whatever the lattice; the volume of round bodies follows as the triangles become small."""
    inner = ball(2, 0.7, (0.1, 0.05, -0.2))
    parts = {"ball": [BALL], "torus": [torus(40, 20)], "cavity": [BALL, inner]}[shape]
    found = [stl(tmp_path / f"{i}.stl", T) for i, T in enumerate(parts)]
    exact = volume(found[0]) - sum(volume(T) for T in found[1:])
    stl(tmp_path / "body.stl", np.concatenate(parts))
    total, _, number, notes, region = filled(mesh(tmp_path / "body.stl"), cell=cell)
    assert total == pytest.approx(exact, rel=1e-12)
    assert number > 100
    assert any("inner surface" in note for note in notes) == (shape == "cavity")
    assert f"{sum(map(len, parts)):,} triangles" in region.facts()[0]


def test_converges_to_the_ball():
    errors = []
    for depth in (2, 3, 4):
        errors.append(1.0 - volume(ball(depth)) / (4.0 / 3.0 * np.pi))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_centre_of_mass_and_placement(tmp_path):
    stl(tmp_path / "torus.stl", 1000.0 * torus(40, 20))
    region = mesh(
        tmp_path / "torus.stl", scale=0.001, rotate=[90, 0, 0], translate=[0.1, 0.2, -0.3]
    )
    _, centre, _, _, found = filled(region)
    np.testing.assert_allclose(centre, [0.1, 0.2, -0.3], atol=1e-7)
    low, high = found.bounds()
    np.testing.assert_allclose(np.subtract(high, low), [2.8, 0.8, 2.8], rtol=1e-2)


def test_inside_is_that_of_the_exact_ball(tmp_path):
    """Points, distances and crossings against the sphere that the triangles touch within."""
    stl(tmp_path / "ball.stl", ball(4))
    region = Case.model_validate(case(mesh(tmp_path / "ball.stl"))).bodies["body"].region
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (2000, 3))
    r = np.linalg.norm(points, axis=1)
    clear = np.abs(r - 1.0) > 0.01
    assert (region.contains(points) == (r < 1.0))[clear].all()
    np.testing.assert_allclose(region.distance(points), r - 1.0, atol=0.01)
    vertices = ball(4).reshape(-1, 3)[:500]  # lines through corners and edges
    for axis in range(3):
        ways = np.isfinite(region.crossings(0.5 * vertices, axis)).sum(axis=1)
        assert set(ways.tolist()) <= {0, 2}


@pytest.mark.parametrize("turn", ["one", "all", "cavity"])
def test_orientation_is_repaired(tmp_path, turn):
    T = BALL.copy()
    if turn == "one":
        T[7] = T[7, ::-1]
    elif turn == "all":
        T = T[:, ::-1]
    else:
        T = np.concatenate([T, ball(1, 0.5)])
    corners = stl(tmp_path / "ball.stl", T)
    total, _, _, notes, _ = filled(mesh(tmp_path / "ball.stl"))
    exact = abs(volume(corners)) if turn == "all" else volume(stl(tmp_path / "b.stl", BALL))
    if turn == "cavity":
        exact -= volume(ball(1, 0.5))
    assert total == pytest.approx(exact, rel=1e-6)
    assert any("turned over" in note for note in notes)


def test_union_and_difference(tmp_path):
    """Measured as other regions are, not exactly: by lines through the triangles."""
    exact = volume(stl(tmp_path / "ball.stl", ball(3, 0.8)))
    box = {"box": {"min": [-1.5, -1.5, -1.5], "max": [1.5, 1.5, 1.5]}}
    total, *_ = filled({"difference": [box, mesh(tmp_path / "ball.stl")]})
    assert total == pytest.approx(27.0 - exact, rel=1e-3)
    far = {"box": {"min": [1.0, 1.0, 1.0], "max": [1.5, 1.5, 1.5]}}
    total, *_ = filled({"union": [far, mesh(tmp_path / "ball.stl")]})
    assert total == pytest.approx(0.125 + exact, rel=1e-3)


def two_cubes():
    """Hexahedron and wedge that share a face, as points and cells; volume 1.5."""
    points = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    points = np.vstack([points, [[2, 0, 0], [2, 0, 1]]]).astype(float) - 0.9
    return points, [("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]]), ("wedge", [[1, 8, 2, 5, 9, 6]])]


@pytest.mark.parametrize("ending", ["vtu", "msh", "vtk"])
def test_volume_cells(tmp_path, ending):
    points, cells = two_cubes()
    meshio.Mesh(points, cells).write(tmp_path / f"cells.{ending}")
    total, centre, *_ = filled(mesh(tmp_path / f"cells.{ending}"))
    assert total == pytest.approx(1.5, rel=1e-12)
    np.testing.assert_allclose(centre[2], -0.4, atol=1e-12)


@pytest.mark.parametrize("ending", ["obj", "ply", "stl"])
def test_other_surfaces(tmp_path, ending):
    corners = ball(2)
    cells = [("triangle", np.arange(corners.size // 3).reshape(-1, 3))]
    meshio.Mesh(corners.reshape(-1, 3), cells).write(tmp_path / f"ball.{ending}")
    total, *_ = filled(mesh(tmp_path / f"ball.{ending}"))
    assert total == pytest.approx(volume(corners), rel=1e-6)


def test_outline_and_cells_in_2d(tmp_path):
    """A square with a square hole, as lines; two triangles and a quadrilateral, as cells."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    points = np.vstack([square, 0.5 * square[::-1]])
    ring = [[0, 1], [1, 2], [2, 3], [3, 0]]
    lines = np.array(ring + [[a + 4, b + 4] for a, b in ring])
    flat = np.column_stack([points, np.zeros(8)])
    meshio.Mesh(flat, [("line", lines)]).write(tmp_path / "ring.vtu")
    total, centre, _, notes, region = filled(
        mesh(tmp_path / "ring.vtu", rotate=30.0, translate=[0.2, 0.1]), dimension=2
    )
    assert total == pytest.approx(3.0, rel=1e-12)
    np.testing.assert_allclose(centre, [0.2, 0.1], atol=1e-12)
    assert "8 segments" in region.facts()[0]
    assert "area 3" in region.facts()[0]
    assert any("holes, left empty" in note for note in notes)
    cells = [("triangle", [[0, 1, 2]]), ("quad", [[0, 2, 3, 4]])]
    bent = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-0.5, 0.5, 0]], float)
    meshio.Mesh(bent, cells).write(tmp_path / "cells.vtu")
    total, *_ = filled(mesh(tmp_path / "cells.vtu"), dimension=2)
    assert total == pytest.approx(1.25, rel=1e-12)
    meshio.Mesh(flat, [("line", lines[:-1])]).write(tmp_path / "open.vtu")
    with pytest.raises(CaseError, match="2 open ends, the first at"):
        filled(mesh(tmp_path / "open.vtu"), dimension=2)


@pytest.mark.wide
def test_same_bits_on_ranks_and_resumed_without_the_file(tmp_path, mpirun, python):
    """With probes and a constraint; the name counts from the case's folder; case.yaml is a case."""
    (tmp_path / "cases").mkdir()
    stl(tmp_path / "cases/ball.stl", ball(2, 1.3))
    text = case(mesh("ball.stl"), time={"end": 0.1, "step": 0.01}, gravity=[0.0, 0.0, -9.81])
    text |= {"checkpoint": {"every": {"steps": 5}, "keep": 5}}
    text |= {
        "probes": {"low": {"body": "body", "at": [0.0, 0.0, -1.2]}, "gauge": {"place": [0, 0, 0]}}
    }
    top = {"box": {"min": [-2.0, -2.0, 0.8], "max": [2.0, 2.0, 2.0]}}
    text |= {"constraints": {"top": {"body": "body", "region": top, "velocity": [0.5, None, 0.0]}}}
    write_case(tmp_path / "cases/ball.yaml", text)
    one = python(["-m", "pgimp", "cases/ball.yaml", "-o", "one"], cwd=tmp_path)
    assert one.returncode == 0, one.stderr
    again = mpirun(4, ["-m", "pgimp", "one/case.yaml", "-o", "four"], cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert main(["compare", str(tmp_path / "one"), str(tmp_path / "four")]) == 0
    for probe in ("low", "gauge"):
        files = [tmp_path / run / f"probes/{probe}.csv" for run in ("one", "four")]
        assert files[0].read_bytes() == files[1].read_bytes()
    (tmp_path / "cases/ball.stl").unlink()
    for name in ("one", "four"):
        longer = ["-m", "pgimp", "cases/ball.yaml", "-o", name, "--resume", "--set", "time.end=0.2"]
        done = python(longer, cwd=tmp_path) if name == "one" else mpirun(2, longer, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "resuming from" in done.stdout
    assert main(["compare", str(tmp_path / "one"), str(tmp_path / "four")]) == 0
    refused = mpirun(2, ["-m", "pgimp", "cases/ball.yaml", "-o", "new"], cwd=tmp_path)
    assert refused.returncode == 2
    assert "No such file" in refused.stderr
    assert "Traceback" not in refused.stderr


@pytest.mark.parametrize("rotate", [[30, 0, 0], [0, 30, 0], [90, 60, 0], [0, 0, 90]])
def test_faces_along_a_line_that_is_looked_along(rotate):
    """A hexagonal nut turned so that some faces are parallel to the grid but for rounding."""
    nut = meshio.read(ROOT / "cases/geometry/nut.obj")
    exact = 0.1**3 * volume(nut.points[nut.cells_dict["triangle"]])
    total, *_ = filled(mesh(ROOT / "cases/geometry/nut.obj", scale=0.1, rotate=rotate))
    assert total == pytest.approx(abs(exact), rel=1e-12)


def voxels(places, own_corners=False):
    """A mesh of unit hexahedra at these places; each with corners of its own, or shared ones."""
    unit = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    unit = np.concatenate([unit, np.add(unit, [0, 0, 1])])
    corners = (np.array(places)[:, None, :] + unit).reshape(-1, 3)
    cells = np.arange(len(corners)).reshape(-1, 8)
    if not own_corners:
        corners, group = np.unique(corners, axis=0, return_inverse=True)
        cells = group.reshape(-1, 8)
    return meshio.Mesh(0.3 * corners, [("hexahedron", cells)])


@pytest.mark.parametrize("own_corners", [False, True])
@pytest.mark.parametrize("rotate", [[0, 0, 0], [10, 20, 30]])
def test_cells_that_touch_in_edges_or_do_not_share_corners(tmp_path, own_corners, rotate):
    """What is inside is known of cells: neither a hole nor an overlap may be seen in them."""
    board = [(i, j, k) for i in range(3) for j in range(3) for k in range(2) if (i + j + k) % 2]
    for places in (board, [(i, j, k) for i in range(3) for j in range(3) for k in range(3)]):
        voxels(places, own_corners).write(tmp_path / "cells.vtu")
        total, *_ = filled(mesh(tmp_path / "cells.vtu", rotate=rotate))
        assert total == pytest.approx(len(places) * 0.3**3, rel=1e-12)


@pytest.mark.parametrize("angle", [15.0, 40.0, 75.0])
def test_faces_on_planes_of_the_lattice_but_for_rounding(tmp_path, angle):
    """A box that is turned back by `rotate`: its faces are almost on planes between particles."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    box = voxels([(0, 0, 0)])
    box.points = box.points / 0.3 * [0.9, 0.3, 0.7]
    box.points = box.points @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    box.write(tmp_path / "box.vtu")
    region = mesh(tmp_path / "box.vtu", rotate=[angle, 0, 0], translate=[0, -0.3, -0.3])
    for cell in (0.1, 0.2):
        total, *_ = filled(region, cell=cell)
        assert total == pytest.approx(0.9 * 0.3 * 0.7, rel=1e-12)
