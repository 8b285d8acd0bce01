"""Mesh files without an inside, damaged or hostile: refused, with what is wrong."""

import os
import struct

import h5py
import numpy as np
import pytest
from mesh_bodies import BALL, mesh
from meshes import ball, filled, stl

from pgimp.errors import CaseError
from pgimp.geometry.mesh import closed as meshclosed


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
