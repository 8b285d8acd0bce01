"""Meshes as other programs write them: the same body, whatever the form; groups; near corners."""

import itertools
import struct

import numpy as np
import pytest
from mesh_bodies import BALL, mesh
from meshes import case, volume

from pgimp.case.schema import Case
from pgimp.errors import CaseError

#: A cube of side 1, and its faces anticlockwise from outside.
POINTS = np.array([*itertools.product((0, 1), repeat=3)], float)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def surface(path, dimension=3, **more):
    """The surface of a body's mesh."""
    model = Case.model_validate(case(mesh(path, **more), dimension))
    region = model.bodies["body"].region
    region.belong(dimension)
    return region.surface


def obj(corner):
    lines = [
        "# made by a test",
        "mtllib a.mtl",
        "o cube",
        *(f"v {x} {y} {z}" for x, y, z in POINTS),
    ]
    lines += ["vt 0 0", *(f"vn {k} 0 0" for k in range(6)), "usemtl m", "s off"]
    for k, quad in enumerate(QUADS):
        lines.append("f " + " ".join(corner(i, k) for i in quad))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "corner",
    [
        lambda i, k: f"{i + 1}",
        lambda i, k: f"{i + 1}//{k + 1}",
        lambda i, k: f"{i + 1}/1/{k + 1}",
        lambda i, k: f"{i + 1}/1",
        lambda i, k: f"{i - 8}//{k - 6}",
    ],
    ids=["plain", "normals", "textures and normals", "textures", "from the end"],
)
def test_obj_with_normals_and_textures(tmp_path, corner):
    (tmp_path / "cube.obj").write_text(obj(corner))
    found = surface(tmp_path / "cube.obj")
    assert found.volume == pytest.approx(1.0, rel=1e-14)
    assert found.facets == 12 and not found.notes


def test_lines_of_obj_are_an_outline(tmp_path):
    text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nl 1 2 3\nl 3 4 1\n"
    (tmp_path / "box.obj").write_text(text)
    assert surface(tmp_path / "box.obj", 2).volume == pytest.approx(2.0, rel=1e-14)


NAMES = {
    "old": {"f4": "float", "f8": "double", "u1": "uchar", "i4": "int", "u2": "ushort"},
    "new": {"f4": "float32", "f8": "float64", "u1": "uint8", "i4": "int32", "u2": "uint16"},
}


def ply(order, names, triangles, listed, more=b""):
    """A cube, with colours at its points and a flag before the list of each face."""
    kind, number = (
        NAMES[names],
        {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"},
    )
    faces = [[q[0], *q[1 + k : 3 + k]] for q in QUADS for k in (0, 1)] if triangles else QUADS
    if triangles is None:  # both kinds, mixed
        faces = [[0, 1, 3], [0, 3, 2], *QUADS[1:]]
    head = f"ply\nformat {number[order]} 1.0\ncomment by a test\nelement material 2\n"
    head += f"property {kind['u2']} shine\nelement vertex 8\n"
    head += "".join(f"property {kind['f8']} {axis}\n" for axis in "xyz")
    head += f"property {kind['u1']} red\nelement face {len(faces)}\nproperty {kind['i4']} flag\n"
    head += f"property list {kind['u1']} {kind['i4']} {listed}\nend_header\n"
    if order == "":
        lines = ["1", "2", *(f"{x} {y} {z} 255" for x, y, z in POINTS)]
        lines += [f"7 {len(face)} {' '.join(map(str, face))}" for face in faces]
        return head.encode() + "\n".join(lines).encode() + b"\n"
    data = struct.pack(f"{order}2H", 1, 2)
    data += b"".join(struct.pack(f"{order}3dB", *point, 255) for point in POINTS)
    for face in faces:
        data += struct.pack(f"{order}iB{len(face)}i", 7, len(face), *face)
    return head.encode() + data


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize(
    ("names", "listed", "triangles"),
    [
        ("old", "vertex_indices", True),
        ("new", "vertex_index", None),
        ("new", "vertex_index", False),
    ],
)
def test_ply_with_all_names_of_types(tmp_path, order, names, listed, triangles):
    (tmp_path / "cube.ply").write_bytes(ply(order, names, triangles, listed))
    found = surface(tmp_path / "cube.ply")
    assert found.volume == pytest.approx(1.0, rel=1e-14)
    assert found.facets == 12 and not found.notes


@pytest.mark.parametrize("order", ["", "<"])
def test_ply_that_is_cut_short_is_refused(tmp_path, order):
    (tmp_path / "cube.ply").write_bytes(ply(order, "new", True, "vertex_index")[:-3])
    with pytest.raises(CaseError, match="promises more than the file can hold: 12 of 'face'"):
        surface(tmp_path / "cube.ply")


def stl_text(triangles, name="part", digits=".9g"):
    lines = [f"solid {name}"]
    for triangle in triangles:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += ["vertex " + " ".join(f"{x:{digits}}" for x in corner) for corner in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}"]) + "\n"


CUBE = POINTS[np.array([[q[0], *q[1 + k : 3 + k]] for q in QUADS for k in (0, 1)])]


@pytest.mark.parametrize("spelling", [str, str.upper, str.title])
def test_stl_text_in_any_capitals(tmp_path, spelling):
    (tmp_path / "cube.stl").write_text(spelling(stl_text(CUBE, "Würfel")), encoding="utf-8")
    assert surface(tmp_path / "cube.stl").volume == pytest.approx(1.0, rel=1e-14)
    (tmp_path / "bad.stl").write_text(spelling(stl_text(CUBE).replace("0 0 0", "0 0 o", 1)))
    with pytest.raises(CaseError, match=r"line 4: '.*' is no corner of three numbers"):
        surface(tmp_path / "bad.stl")


def test_corners_that_differ_by_rounding_are_one(tmp_path):
    """As single precision writes them, each triangle for itself; the tolerance is told."""
    rng = np.random.default_rng(1)
    path = tmp_path / "near.stl"
    for triangles in (CUBE, BALL):
        size = np.ptp(triangles)
        near = triangles + rng.uniform(-1.0, 1.0, triangles.shape) * 1e-7 * size
        path.write_text(stl_text(near, digits=".12g"))
        found = surface(path, translate=[0.1, 0.2, -0.1])
        assert found.volume == pytest.approx(volume(triangles), rel=1e-6)
        assert found.facets == len(triangles)
        (note,) = found.notes
        assert f"{3 * len(triangles):,} open edges closed: corners up to" in note
        assert "the tolerance is" in note and "1e-06 of its size" in note
        far = triangles + rng.uniform(-1.0, 1.0, triangles.shape) * 1e-4 * size
        path.write_text(stl_text(far, digits=".12g"))
        with pytest.raises(CaseError, match=r"open edges, .* if corners 1e-06 of its size apart"):
            surface(path)


def test_ends_of_an_outline_that_differ_by_rounding_are_one(tmp_path):
    ends = [(0, 0), (2, 0), (2, 1e-7), (2, 1), (2, 1.0000001), (0, 1), (1e-7, 1), (0, 1e-8)]
    lines = [f"v {x:.9g} {y:.9g} 0" for x, y in ends] + ["l 1 2", "l 3 4", "l 5 6", "l 7 8"]
    (tmp_path / "box.obj").write_text("\n".join(lines) + "\n")
    found = surface(tmp_path / "box.obj", 2)
    assert found.volume == pytest.approx(2.0, rel=1e-6)
    assert "8 open ends closed" in found.notes[0]


#: A cube and a wedge beside it, in entities 1 and 2; a quadrilateral of the cube in surface 1.
GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
{names}
$EndPhysicalNames
$Entities
0 0 1 2
1 0 0 0 1 1 1 {skin} 0
1 0 0 0 1 1 1 {cube} 0
2 1 0 0 2 1 1 {wedge} 0
$EndEntities
$Nodes
1 10 1 10
3 1 0 10
1
2
3
4
5
6
7
8
9
10
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
2 0 0
2 0 1
$EndNodes
$Elements
3 3 1 3
2 1 3 1
1 1 2 3 4
3 1 5 1
2 1 2 3 4 5 6 7 8
3 2 6 1
3 2 9 3 6 10 7
$EndElements
"""


def gmsh(path, names, skin="0", cube="0", wedge="0"):
    lines = [f"{len(names)}", *names]
    path.write_text(GMSH.format(names="\n".join(lines), skin=skin, cube=cube, wedge=wedge))


@pytest.mark.parametrize(
    ("groups", "note"),
    [
        ({"cube": "1 7", "wedge": "1 8"}, "'left part' (1), 'right' (1)"),
        ({"cube": "1 7"}, "'left part' (1), cells in none (1)"),
        ({"cube": "2 7 9", "wedge": "2 8 9", "skin": "1 3"}, "'left part' (1), 'both' (1)"),
    ],
)
def test_groups_of_gmsh(tmp_path, groups, note):
    """Where groups do not cover all, and where an entity is in several; each may be a body."""
    path = tmp_path / "two.msh"
    gmsh(path, ['3 7 "left part"', '3 8 "right"', '3 9 "both"', '2 3 "skin"'], **groups)
    found = surface(path)
    assert found.volume == pytest.approx(1.5, rel=1e-14)
    assert "its groups are taken together" in found.notes[0]
    volumes = {"left part": 1.0} | ({"right": 0.5} if "wedge" in groups else {})
    for name, expected in volumes.items():
        part = surface(path, group=name)
        assert part.volume == pytest.approx(expected, rel=1e-14) and not part.notes
    with pytest.raises(CaseError, match=r"unknown group 'rihgt'.* it has: .*left part"):
        surface(path, group="rihgt")
    if "skin" in groups:
        assert surface(path, group="both").volume == pytest.approx(1.5, rel=1e-14)
        with pytest.raises(CaseError, match="is 1 x 1 x 0 large: flat"):
            surface(path, group="skin")
    else:
        assert note in found.notes[0]


def test_groups_without_names_and_of_surfaces(tmp_path):
    gmsh(tmp_path / "two.msh", [], cube="1 7", wedge="1 8")
    assert surface(tmp_path / "two.msh", group=8).volume == pytest.approx(0.5, rel=1e-14)
    first, second = stl_text(CUBE, "one"), stl_text(0.5 * CUBE + 3.0, "other part")
    (tmp_path / "two.stl").write_text(first + second)
    found = surface(tmp_path / "two.stl")
    assert found.volume == pytest.approx(1.125, rel=1e-14)
    assert "'one' (12), 'other part' (12)" in found.notes[0]
    part = surface(tmp_path / "two.stl", group="other part")
    assert part.volume == pytest.approx(0.125, rel=1e-14)
    with pytest.raises(CaseError, match="has an unknown group 'x'; it has: none"):
        (tmp_path / "ball.stl").write_text(stl_text(BALL, ""))
        surface(tmp_path / "ball.stl", group="x")
