"""Bodies from mesh files: exact volumes, holes, orientation, refusals; the same bits on ranks."""

import os
import struct
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
from meshes import ball, case, filled, stl, torus, volume
from scenes import write_case

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.geometry.mesh import closed as meshclosed

ROOT = Path(__file__).resolve().parents[3]
BALL = ball(3, 1.3, (0.1, 0.05, -0.2))


def mesh(path, **more):
    return {"mesh": {"file": str(path), **more}}


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


def broken_surfaces():
    near = ball(2, 1.0, (0.5, 0.0, 0.0))
    fin = np.array([[BALL[0, 0], BALL[0, 1], [1.9, 1.9, 1.9]]])
    corners = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, 1, 0]], float)
    tetra = corners[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    nan = BALL.copy()
    nan[5, 1, 2] = np.nan
    return {
        "open": (BALL[:-1], r"3 open edges, the first from \(.*\), of triangle \d+ \(from 0\): "),
        "fin": (np.concatenate([BALL, fin]), "2 open edges"),
        "book": (np.concatenate([BALL, fin, fin + 1e-3 * (fin == 1.9)]), "open edges"),
        "overlap": (
            np.concatenate([BALL, near]),
            r"overlaps or cuts itself, for example at \(.*\), in line with a point, of triangle \d",
        ),
        "edge": (
            np.concatenate([tetra, -tetra]),
            r"1 edges with more than two triangles, .* of triangles 0, 1, 4, 5 \(from 0\)",
        ),
        "nan": (nan, "1 points that are not finite"),
        "flat": (BALL * [1, 1, 0], "flat, or too large or small"),
        "beyond": (2.0 * BALL, "reaches 0.8 beyond the domain at x-max"),
    }


@pytest.mark.parametrize("name", broken_surfaces())
def test_broken_surfaces_are_refused(tmp_path, name):
    T, text = broken_surfaces()[name]
    stl(tmp_path / "bad.stl", T)
    with pytest.raises(CaseError, match=text):
        filled(mesh(tmp_path / "bad.stl"))


def test_an_overlap_that_is_found_while_filling_names_the_body(tmp_path, monkeypatch):
    """Few lines are looked along in a large mesh, so that they may miss it."""
    monkeypatch.setattr(meshclosed, "_check_lines", lambda *_: None)
    stl(tmp_path / "bad.stl", np.concatenate([BALL, ball(2, 1.0, (0.5, 0.0, 0.0))]))
    message = r"^bodies\.body\.region: the mesh .*bad\.stl overlaps or cuts itself in the box of"
    with pytest.raises(CaseError, match=message):
        filled(mesh(tmp_path / "bad.stl"))


@pytest.mark.parametrize(
    ("factor", "scale", "hint"),
    [
        (2.0, 1.0, ""),
        (70.0, 1.0, ""),  # 182, less than 50 times 4
        (1000.0, 1.0, "scale: 0.001 would make it fit"),
        (1000.0, 0.5, "scale: 0.0005 would make it fit"),
        (3000.0, 1.0, ""),  # too large in any case
    ],
)
def test_another_unit_is_proposed_where_it_would_help(tmp_path, factor, scale, hint):
    stl(tmp_path / "far.stl", factor * BALL)
    with pytest.raises(CaseError, match="beyond the domain at x-max") as error:
        filled(mesh(tmp_path / "far.stl", scale=scale, translate=[0.5, 0.0, 0.0]))
    assert ("scale" in str(error.value)) == bool(hint) and hint in str(error.value)


def hostile_files():
    ply = (
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty double x\n"
        b"property double y\nproperty double z\nelement face 4000000000\n"
        b"property list uchar int vertex_indices\nend_header\nxxxxxxxx"
    )
    msh = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9000000000\n1 0 0 0\n$EndNodes\n"
    noise = np.random.default_rng(1).bytes(5000)
    return {
        "missing.stl": (None, "No such file"),
        "folder.stl": (None, "it is a folder"),
        "pipe.stl": (None, "no regular file"),
        "empty.stl": (b"", "it is empty"),
        "noise.stl": (noise, "truncated, or no STL file"),
        "noise.vtu": (noise, "cannot read the mesh"),
        "noise.msh": (noise, "cannot read the mesh"),
        "huge.stl": (b"x" * 80 + struct.pack("<I", 4_000_000_000) + b"y" * 50, "4,000,000,000"),
        "huge.ply": (ply, "promises more than the file can hold"),
        "huge.msh": (msh, "promises more than the file can hold"),
        "none.stl": (b"x" * 80 + b"\0" * 4, "nothing in it encloses"),
        "corner.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a corner that is none of its 3"),
        "number.obj": (b"v 0 0 0\nv 1 0 0\nf 1 2 1\nf 1 2 9\n", r"the first is triangle 1 \("),
        "what.xyz": (b"hello", "meshio knows no format '.xyz'"),
        "escape.ply": (b"ply\nformat \x1b[31mred 1.0\n", r"cannot read the mesh [^\x1b]*$"),
        "pipe.xdmf": (XDMF.replace(b"FILE", b"fifo"), "leads to .*fifo, which is no regular file"),
        "linked.xdmf": (XDMF.replace(b"FILE", b"linked.h5"), "a link into another file"),
        "raw.xdmf": (XDMF.replace(b"FILE", b"raw.h5"), "the data of its 'x' are in another file"),
    }


#: A mesh whose points are in another file.
XDMF = b"""<Xdmf Version="3.0"><Domain><Grid Name="Grid">
<Geometry GeometryType="XYZ"><DataItem DataType="Float" Dimensions="4 3" Format="HDF" Precision="8">
FILE:/x</DataItem></Geometry></Grid></Domain></Xdmf>"""


@pytest.mark.parametrize("name", hostile_files())
def test_hostile_files_are_refused(tmp_path, name):
    data, text = hostile_files()[name]
    if name.endswith(".xdmf"):
        os.mkfifo(tmp_path / "fifo")
        with h5py.File(tmp_path / "linked.h5", "w") as file:
            file["x"] = h5py.ExternalLink("fifo", "x")
        with h5py.File(tmp_path / "raw.h5", "w") as file:
            file.create_dataset("x", (4, 3), "f8", external=[(str(tmp_path / "fifo"), 0, 96)])
    if name == "folder.stl":
        (tmp_path / name).mkdir()
    elif name == "pipe.stl":
        os.mkfifo(tmp_path / name)
    elif data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(CaseError, match=text) as failure:
        filled(mesh(tmp_path / name))
    assert str(tmp_path / name) in str(failure.value)


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
