"""Frames of surfaces: ParaView's readers, comparisons, plots, wrong requests."""

import shutil

import h5py
import numpy as np
import pytest
from paraview_reader import READERS, probe
from pressed_blocks import resting_block
from scenes import box, scene, write_case

from pgimp.cli import main


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A block on a plate; three frames."""
    folder = tmp_path_factory.mktemp("surfaces")
    write_case(folder / "case.yaml", resting_block(end=0.2))
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return folder / "out"


def frame_of(run, number):
    with h5py.File(run / "frames" / f"surface-{number:06d}.h5") as file:
        return {name: file[name][()] for name in file if name != "VTKHDF"}


def test_paraview_reads_them(pvpython, run):
    seen = probe(pvpython, run / "surface.xdmf", 1)
    for reader in READERS:
        result = seen[reader]
        assert result["times"] == pytest.approx([0.0, 0.1, 0.2], abs=0.02)
        assert result["shown"][-1]["cells"] == len(frame_of(run, 2)["connectivity"])


def test_runs_are_compared_by_them(run, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(run, other)
    assert main(["compare", str(run), str(other)]) == 0
    assert "3 frames of surfaces" in capsys.readouterr().out
    with h5py.File(other / "frames" / "surface-000001.h5", "r+") as file:
        file["slip"][7] += 1.0
    assert main(["compare", str(run), str(other)]) == 1
    assert "surface frame 1" in (said := capsys.readouterr().out)
    assert "slip: 1 of" in said


def test_plots_have_the_pressure_along_the_outline(run, tmp_path):
    words = ["plot", str(run), "--surface", "contact-pressure", "-o", str(tmp_path / "p.png")]
    table = tmp_path / "p.csv"
    assert main([*words, "--body", "block", "--csv", str(table)]) == 0
    lines = [line.split(",") for line in table.read_text().splitlines()]
    assert lines[0][4:] == ["x", "y", "length", "contact-pressure"]
    found = np.array([[float(value) for value in line[4:]] for line in lines[1:]])
    frame = frame_of(run, 2)
    own = frame["body"] == 0
    middle = frame["position"][frame["connectivity"][own]].mean(axis=1)
    wanted = np.column_stack([middle[:, :2], frame["contact-pressure"][own]])
    order = np.lexsort(found.T[:2]), np.lexsort(wanted.T[:2])
    np.testing.assert_allclose(found[order[0]][:, [0, 1, 3]], wanted[order[1]], rtol=1e-12)
    assert found[-1, 2] == pytest.approx(16.0, abs=0.1)  # around the block
    assert (np.diff(found[:, 2]) > 0.0).all()
    along = [*words, "--along", "x", "--csv", str(table)]
    assert main(along) == 0
    assert table.read_text().splitlines()[0].endswith("x,y,contact-pressure")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--surface", "presure"], "did you mean 'contact-pressure'"),
        (["--surface", "traction.a"], "traction has no component a"),
        (["--surface", "gap", "--body", "blok"], "block"),
        (["--surface", "gap", "--field", "stress"], "--field is for particles"),
    ],
)
def test_wrong_plots_say_what_is_wrong(run, tmp_path, capsys, words, says):
    assert main(["plot", str(run), *words, "-o", str(tmp_path / "p.png")]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "p.png").exists()


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({}, "takes bodies that meet by their surfaces"),
        ({"formulation": "total-lagrangian", "surface": "exact"}, "no bodies meet"),
    ],
)
def test_scenes_without_surfaces_that_meet_are_refused(tmp_path, capsys, more, says):
    case = scene(2, box([1.0] * 2, [3.0] * 2) | more, output={"surface": ["gap"]})
    write_case(tmp_path / "case.yaml", case)
    assert main([str(tmp_path / "case.yaml"), "-o", str(tmp_path / "out")]) == 2
    assert says in " ".join(capsys.readouterr().err.split())
