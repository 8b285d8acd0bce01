"""``pgimp compare`` on pairs of runs that differ in probes or frames of the grid."""

import shutil

import h5py
import numpy as np
import pytest
from compared import call
from mentioned import mentions
from scenes import box, scene, write_case

import pgimp
from pgimp.errors import RunError


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """A run with two probes and frames of the grid, in 2D."""
    case = scene(2, box([1.0, 1.0], [3.0, 3.0], [1.0, 0.5]), end=0.2, history={"every": 0.05})
    case |= {"output": {"every": 0.1, "grid": ["mass", "velocity"]}}
    case |= {"probes": {"a": {"place": [2.0, 2.0]}, "b": {"body": "body", "at": [2.0, 2.0]}}}
    path = tmp_path_factory.mktemp("full")
    write_case(path / "case.yaml", case)
    return pgimp.run(path / "case.yaml", output=path / "out", quiet=True).path


@pytest.fixture
def copies(full, tmp_path):
    for name in ("one", "two"):
        shutil.copytree(full, tmp_path / name)
    return tmp_path / "one", tmp_path / "two"


def test_probes_are_compared(copies, capsys):
    status, out = call(capsys, *copies)
    assert status == 0 and "5 lines of history, 2 probes, 3 frames of the grid\n" in out
    path = copies[1] / "probes" / "b.csv"
    lines = path.read_text().splitlines()
    column = lines[0].split(",").index("velocity-y")
    cells = lines[3].split(",")
    before = float(cells[column])
    cells[column] = repr(before + 0.25)
    path.write_text("\n".join([*lines[:3], ",".join(cells), *lines[4:]]) + "\n")
    status, out = call(capsys, *copies)
    assert status == 1
    told, _ = out.splitlines()
    mentions(told, "probes/b.csv", "velocity-y", "1 of 5 lines", "line 4", "difference 0.25")
    mentions(told, f"{before!r} and {before + 0.25!r}")
    assert call(capsys, *copies, "--atol", "0.3")[0] == 0
    path.write_text("\n".join(lines[:4]) + "\n")
    assert "probes/b.csv: 5 and 3 lines\n" in call(capsys, *copies)[1]


def test_what_only_one_run_has_is_said(copies, capsys):
    """The particles are the same all the same."""
    path = copies[1] / "case.yaml"
    path.write_text(path.read_text().replace("probes:", "others:"))
    for frame in (copies[1] / "frames").glob("grid-*.h5"):
        frame.unlink()
    for pair in (copies, copies[::-1]):
        status, out = call(capsys, *pair)
        assert status == 0
        first, second, _ = out.splitlines()
        mentions(first, "note:", f"only {copies[0]}", "probes a, b")
        mentions(second, "note:", f"only {copies[0]}", "frames of the grid")
        assert out.endswith("5 lines of history\n")


def change_grid(directory, number, change):
    with h5py.File(directory / "frames" / f"grid-{number:06d}.h5", "r+") as file:
        return change(file)


def test_frames_of_the_grid_are_compared(copies, capsys):
    def kick(file):
        row = int(np.argmax(file["mass"][:]))
        before = file["velocity"][row, 1]
        file["velocity"][row, 1] = before + 0.5
        return ", ".join(f"{x:.6g}" for x in file["position"][row]), before.item()

    at, before = change_grid(copies[1], 1, kick)
    status, out = call(capsys, *copies)
    assert status == 1
    (line,) = out.splitlines()[:-1]
    assert line.startswith("grid frame 1 (t = 0.1), velocity: 1 of ")
    assert f"vertices differ, worst is that at ({at}) y: {before!r} and {before + 0.5!r}" in line
    assert call(capsys, *copies, "--atol", "0.6")[0] == 0

    def move(file):
        file["position"][3, 0] += 1.0
        file.attrs["step"] = 77

    change_grid(copies[1], 1, move)
    status, out = call(capsys, *copies)
    assert status == 1 and "grid frame 1 (t = 0.1): step 10 and 77\n" in out
    assert "vertices are in other places\n" in out and "velocity" not in out

    def fewer(file):
        values = file["connectivity"][:-1]
        del file["connectivity"]
        file["connectivity"] = values

    change_grid(copies[1], 1, fewer)
    assert " cells\n" in call(capsys, *copies)[1]
    (copies[1] / "frames" / "grid-000001.h5").unlink()
    assert f"1 of 3 frames of the grid are only in {copies[0]}: 1\n" in call(capsys, *copies)[1]
    path = copies[1] / "frames" / "grid-000002.h5"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(RunError, match=r"cannot read .*grid-000002\.h5"):
        call(capsys, *copies)


def test_frames_of_the_grid_of_another_precision(copies, capsys):
    def single(file):
        for name in ("position", "mass", "velocity"):
            values = file[name][:].astype("f4")
            del file[name]
            file[name] = values

    def odd(file):
        values = file["mass"][:].astype("i4")
        del file["mass"]
        file["mass"] = values

    change_grid(copies[1], 0, odd)
    message = "grid frame 0 (t = 0), mass: of another shape or type\n"
    assert message in call(capsys, *copies, "--rtol", "1e-6")[1]
    change_grid(copies[0], 0, odd)
    for number in range(3):
        change_grid(copies[1], number, single)
    change_grid(copies[0], 0, single)
    status, out = call(capsys, *copies)
    assert status == 1 and out.count("float64 and of float32") == 2
    assert call(capsys, *copies, "--rtol", "1e-6")[0] == 0
