"""``pgimp export``: frames of earlier versions for VTK, tables and VTU."""

import csv
import os
import shutil

import h5py
import meshio
import numpy as np
import pytest
from processes import PROGRAMS
from scenes import box, scene, write_case
from vtk_reference import save

import pgimp
from pgimp.cli import main
from pgimp.io.results.frame import Frame
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import Serial
from pgimp.physics.fields import FROM_STRESS


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run in 2D with a grid and a rigid body, three frames."""
    folder = tmp_path_factory.mktemp("exported")
    bodies = {
        "soft": box([1.0] * 2, [2.0] * 2),
        "hard": {
            "rigid": {"velocity": [0.5, 0.0]},
            "region": {"box": {"min": [4.0, 4.0], "max": [6.0, 6.0]}},
        },
    }
    output = {"every": 0.1, "grid": ["mass", "velocity"], "fields": ["stress"]}
    write_case(folder / "case.yaml", scene(2, bodies, end=0.2, output=output))
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return folder / "out"


@pytest.fixture
def run(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(made, tmp_path / "run.out")
    return tmp_path / "run.out"


@pytest.fixture
def old(run):
    """The run as earlier versions left it."""
    for path in run.glob("*.vtkhdf"):
        path.unlink()
    for path in (run / "frames").iterdir():
        with h5py.File(path, "r+") as file:
            del file["VTKHDF"]
        os.chmod(path, 0o640)
    return run


def content(run):
    return {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}


def test_frames_of_earlier_versions(old, python, tmp_path, capsys):
    before = {path: Frame(path)["stress"] for path in (old / "frames").glob("particles-*")}
    assert main(["export", "vtkhdf", str(old)]) == 0
    assert "run.out/particles.vtkhdf: 3 frames, 3 of them new to VTK" in capsys.readouterr().out
    save(old, tmp_path / "reference.npz")
    job = python([PROGRAMS / "vtk_probe.py", old, tmp_path / "reference.npz"])
    assert job.returncode == 0 and "9 frames, 0 differences" in job.stdout, job.stdout + job.stderr
    for path, stress in before.items():
        assert Frame(path)["stress"].tobytes() == stress.tobytes()
        assert path.stat().st_mode & 0o777 == 0o640
    assert not [*old.rglob("*.part"), *old.glob(".lock")]
    after = content(old)
    assert main(["export", "vtkhdf", str(old)]) == 0
    assert "3 frames, none of them new to VTK" in capsys.readouterr().out
    assert content(old) == after


def test_fields_that_follow_from_the_stress_are_computed(run):
    """As by `pgimp plot`; the frames have neither."""
    words = ["--field", "lode-angle,von-mises,principal-stress", "--frame=-1"]
    assert main(["export", "csv", str(run), *words, "-o", "tables"]) == 0
    frame = pgimp.open(run).frames[-1]
    names = ["lode-angle", "von-mises", "principal-stress"]
    expected = {name: FROM_STRESS[name](frame["stress"]) for name in names}
    table = np.genfromtxt(
        f"tables/{frame.path.stem}.csv", delimiter=",", names=True, deletechars=""
    )
    assert table.dtype.names == (
        "id", "von-mises", "principal-stress-1", "principal-stress-2", "principal-stress-3",
        "lode-angle",
    )  # fmt: skip
    assert not set(names) & set(frame.fields)
    np.testing.assert_array_equal(table["lode-angle"], expected["lode-angle"])
    np.testing.assert_array_equal(table["principal-stress-2"], expected["principal-stress"][:, 1])
    assert main(["export", "vtu", str(run), *words, "-o", "files"]) == 0
    data = meshio.read(f"files/{frame.path.stem}.vtu").point_data
    assert set(data) == set(names)
    for name in names:
        np.testing.assert_array_equal(data[name], expected[name])


def test_a_damaged_frame_is_named_and_the_others_are_there(old, capsys):
    damaged = old / "frames" / "particles-000001.h5"
    damaged.write_bytes(b"no frame")
    assert main(["export", "vtkhdf", str(old)]) == 1
    out = capsys.readouterr().out
    assert f"note: cannot read {damaged}" in out and "particles.vtkhdf: 2 frames" in out
    with h5py.File(old / "particles.vtkhdf") as file:
        np.testing.assert_allclose(file["VTKHDF/Steps/Values"][:], [0.0, 0.2])


def test_not_while_the_run_goes_on(old, capsys):
    before = content(old)
    directory = RunDirectory(old, Serial(), resume=True)
    try:
        assert main(["export", "vtkhdf", str(old)]) == 2
    finally:
        directory.release()
    assert "a run is writing to" in capsys.readouterr().err
    assert content(old) == before


def test_a_full_disk_leaves_the_frames_as_they_are(old, capsys, monkeypatch):
    before = content(old)

    def full(source, target):
        target.write_bytes(b"half")
        raise OSError(28, "the text does not matter")

    monkeypatch.setattr(shutil, "copyfile", full)
    assert main(["export", "vtkhdf", str(old)]) == 1
    assert "cannot write to" in capsys.readouterr().err
    assert content(old) == before


def test_tables_have_all_digits(run, capsys):
    assert main(["export", "csv", str(run)]) == 0
    assert "wrote 3 files to run-csv" in capsys.readouterr().out
    for frame in pgimp.open(run):
        with open(f"run-csv/particles-{frame.number:06d}.csv", newline="") as stream:
            head, *lines = csv.reader(stream)
        assert head[0] == "id" and len(lines) == len(frame)
        table = dict(zip(head, zip(*lines, strict=True), strict=True))
        for name, column in (("stress-xy", frame["stress"][:, 3]), ("volume", frame["volume"])):
            assert [float(value) for value in table[name]] == column.tolist()
        assert [int(value) for value in table["id"]] == frame["id"].tolist()


def test_some_frames_and_fields(run, capsys):
    words = ["--frame=-1,0", "--field", "stress,id", "-o", "there/csv"]
    assert main(["export", "csv", str(run), *words]) == 0
    with open("there/csv/particles-000002.csv") as stream:
        assert stream.readline() == (
            "id,stress-xx,stress-yy,stress-zz,stress-xy,stress-yz,stress-xz\n"
        )
    assert sorted(os.listdir("there/csv")) == ["particles-000000.csv", "particles-000002.csv"]
    assert main(["export", "vtu", str(run), "--time", "0.11", "-o", "vtu"]) == 0
    assert sorted(os.listdir("vtu")) == [
        "grid-000001.vtu", "grid.pvd", "particles-000001.vtu", "particles.pvd",
        "rigid-000001.vtu", "rigid.pvd",
    ]  # fmt: skip


def test_vtu_has_the_same_values(run, capsys):
    assert main(["export", "vtu", str(run)]) == 0
    assert "wrote 9 files to run-vtu; open run-vtu/particles.pvd or" in capsys.readouterr().out
    for path in (run / "frames").iterdir():
        mesh = meshio.read(f"run-vtu/{path.stem}.vtu")
        with h5py.File(path) as file:
            np.testing.assert_array_equal(mesh.points, file["position"])
            np.testing.assert_array_equal(
                mesh.cells[0].data.ravel(), file["connectivity"][()].ravel()
            )
            for name, values in mesh.point_data.items():
                assert values.dtype == file[name].dtype
                np.testing.assert_array_equal(values, file[name])
            assert len(mesh.point_data) == len(file) - 3
    with open("run-vtu/particles.pvd") as stream:
        assert '<DataSet timestep="0.0" file="particles-000000.vtu"/>' in stream.read()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["vtu", "nix.out"], "there is no run directory nix.out"),
        (["vtx", "run.out"], "invalid choice: 'vtx'"),
        (["vtkhdf", "run.out", "--frame", "1"], "--frame is for csv and vtu"),
        (["csv", "run.out", "--frame", "1", "--time", "0"], "--frame and --time do not go"),
        (["csv", "run.out", "--frame", "3"], "run.out has no frame 3: it has 3, 0 to 2"),
        (["csv", "run.out", "--frame", "x"], "--frame x: whole numbers"),
        (["csv", "run.out", "--time", "9"], "has no frame at time 9"),
        (["vtu", "run.out", "--field", "stres"], "did you mean 'stress'?"),
        (["csv", "run.out", "-o", "run.out/case.yaml"], "cannot write to run.out/case.yaml"),
    ],
)
def test_what_is_wrong_is_said(run, capsys, words, said):
    before = content(run.parent)
    assert main(["export", *words]) == 2
    assert said in capsys.readouterr().err
    assert content(run.parent) == before


def test_a_run_without_frames(run, capsys):
    for path in (run / "frames").iterdir():
        path.unlink()
    for kind in ("vtkhdf", "csv", "vtu"):
        assert main(["export", kind, str(run)]) == 2
        assert "has no frames" in capsys.readouterr().err


@pytest.fixture(scope="module")
def rings(tmp_path_factory):
    """A run of a ring and a cylinder on the axis, two frames."""
    folder = tmp_path_factory.mktemp("rings")
    bodies = {"bar": box([0.0, 1.0], [2.0, 3.0], [0.0, -1.0]), "ring": box([3.0, 1.0], [5.0, 2.0])}
    output = {"every": 0.1, "fields": ["stress", "velocity", "deformation"]}
    case = scene(2, bodies, end=0.1, output=output, gravity=[0.0, -1.0])
    case["geometry"] = "axisymmetric"
    write_case(folder / "case.yaml", case)
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return folder / "out"


def volumes(mesh):
    """Volumes of hexahedra, exact with plane faces: six pyramids from their middles."""
    corners = mesh.points[mesh.cells_dict["hexahedron"]]
    middle, total = corners.mean(axis=1), 0.0
    for face in (
        (0, 3, 2, 1),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ):
        a, b, c, d = (corners[:, k] - middle for k in face)
        for one, other in ((b, c), (c, d)):
            total += np.einsum("ni,ni->n", a, np.cross(one, other)) / 6.0
    return total


def test_rings_are_revolved_with_their_exact_volumes(rings, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "vtu", str(rings), "--revolve", "24"]) == 0
    assert "open out-vtu/revolved.pvd" in capsys.readouterr().out
    frame = pgimp.open(rings).frames[0]
    mesh = meshio.read("out-vtu/revolved-000000.vtu")
    found = volumes(mesh).reshape(24, len(frame))
    a = 2.0 * np.pi / 24
    np.testing.assert_allclose(found.sum(axis=0), frame["volume"] * np.sin(a) / a, rtol=1e-12)
    exact = np.pi * (2.0**2 * 2.0 + (5.0**2 - 3.0**2) * 1.0)  # of the cylinder and the ring
    assert found.sum() * a / np.sin(a) == pytest.approx(exact, rel=1e-12)
    assert mesh.cell_data["volume"][0].reshape(24, -1)[7].tolist() == frame["volume"].tolist()


def test_vectors_and_tensors_of_revolved_rings_are_those_of_space(rings, tmp_path):
    assert main(["export", "vtu", str(rings), "--revolve", "8", "-o", str(tmp_path)]) == 0
    frame, mesh = pgimp.open(rings).frames[-1], meshio.read(tmp_path / "revolved-000001.vtu")
    middle = mesh.points[mesh.cells_dict["hexahedron"]].mean(axis=1).reshape(8, -1, 3)
    out = middle * [1.0, 0.0, 1.0]
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    velocity = mesh.cell_data["velocity"][0].reshape(8, -1, 3)
    np.testing.assert_allclose(
        (velocity * out).sum(axis=-1), np.tile(frame["velocity"][:, 0], (8, 1)), atol=1e-14
    )
    S = mesh.cell_data["stress"][0].reshape(8, -1, 6)[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    S = S.reshape(8, -1, 3, 3)
    round_it = np.cross(out, [0.0, 1.0, 0.0])
    for one, other, column in ((out, out, 0), (round_it, round_it, 2), (out, [0.0, 1.0, 0.0], 3)):
        normal = np.einsum("kni,knij,knj->kn", one, S, np.broadcast_to(other, one.shape))
        np.testing.assert_allclose(normal, np.tile(frame["stress"][:, column], (8, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["csv", "RINGS", "--revolve", "8"], "--revolve is for vtu"),
        (["vtu", "PLANE", "--revolve", "8"], "--revolve is for axisymmetric scenes"),
        (["vtu", "RINGS", "--revolve", "2"], "expected one number from 3 to 3600"),
        (["vtu", "RINGS", "--revolve", "many"], "--revolve"),
        (["vtkhdf", "RINGS", "--revolve", "8"], "--revolve is for csv and vtu"),
    ],
)
def test_what_cannot_be_revolved_is_refused(rings, made, words, told, capsys):
    places = {"RINGS": str(rings), "PLANE": str(made)}
    assert main(["export", *(places.get(word, word) for word in words)]) == 2
    assert told in capsys.readouterr().err
