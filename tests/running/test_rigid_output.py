"""The frames of rigid bodies: whole surfaces where the bodies are, also to ParaView's readers."""

import h5py
import numpy as np
import pytest
from paraview_reader import READERS, probe
from scenes import box, scene, write_case

from pgimp.cli import main


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run in 3D with a ball that moves and a box that turns; four frames."""
    folder = tmp_path_factory.mktemp("rigid")
    bodies = {
        "soft": box([1.0] * 3, [2.0] * 3),
        "ball": {
            "rigid": {"velocity": [0.5, 0.0, 0.0]},
            "region": {"ball": {"centre": [4.0, 4.0, 4.0], "radius": 1.5}},
        },
        "block": {
            "rigid": {"rotation": {"about": [6.0, 1.5, 1.5], "rate": 0.3}},
            "region": {"box": {"min": [5.0, 0.5, 0.5], "max": [7.0, 2.5, 2.5]}},
        },
    }
    case = scene(3, bodies, end=0.3, output={"every": 0.1})
    write_case(folder / "rigid.yaml", case)
    assert main([str(folder / "rigid.yaml"), "-o", str(folder / "out")]) == 0
    return folder / "out"


def test_surfaces_are_where_the_bodies_are(run):
    for number in range(4):
        with h5py.File(run / "frames" / f"rigid-{number:06d}.h5") as file:
            x, body, cells = file["position"][:], file["body"][:], file["connectivity"][:]
            time = float(file.attrs["time"])
            assert list(file["body"].attrs["names"]) == ["ball", "block"]
        centre = np.array([4.0 + 0.5 * time, 4.0, 4.0])
        distance = np.linalg.norm(x[body == 0] - centre, axis=1)
        assert np.abs(distance - 1.5).max() < 1e-8
        own = x[body == 1] - np.array([6.0, 1.5, 1.5])
        c, s = np.cos(0.3 * time), np.sin(0.3 * time)
        own[:, :2] = own[:, :2] @ np.array([[c, -s], [s, c]])
        assert np.abs(own).max() == pytest.approx(1.0, abs=1e-9)
        corners = np.abs(np.abs(own) - 1.0).max(axis=1) < 1e-9
        assert len(np.unique(np.sign(own[corners]), axis=0)) == 8
        assert (np.bincount(cells.ravel(), minlength=len(x)) >= 3).all()  # closed


def test_paraview_reads_them(pvpython, run):
    seen = probe(pvpython, run / "rigid.xdmf", 1)
    for reader in READERS:
        result = seen[reader]
        assert result["times"] == pytest.approx([0.0, 0.1, 0.2, 0.3])
        with h5py.File(run / "frames" / "rigid-000003.h5") as file:
            x, cells = file["position"][:], file["connectivity"][:]
        shown = result["shown"][-1]
        assert shown["cells"] == len(cells)
        assert np.array(shown["arrays"]["points"]) == pytest.approx(x, abs=1e-6)
        assert {value for (value,) in shown["arrays"]["body"]} == {0.0, 1.0}
