"""The XDMF file in a real ParaView, through each of the three readers that people choose from."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from particle_source import make_case, make_sim

from pgimp.output.frames import Frames
from pgimp.output.reader import Frame
from pgimp.parallel.comm import Serial

READERS = ("XDMF Reader", "Xdmf3 Reader S", "Xdmf3 Reader T")
COUNT, GONE = 23, ((), (), range(9, 14))
COUNTS = [COUNT - len(gone) for gone in GONE]


def probe(path, body):
    """Let pvpython open an XDMF file; without pvpython this fails, for CI must install it."""
    program = shutil.which("pvpython")
    assert program, "ParaView is not installed: apt-get install paraview python3-paraview xvfb"
    environment = {
        key: value
        for key, value in os.environ.items()
        if not key.startswith(("OMPI_", "PMIX_", "PYTHON", "VIRTUAL_ENV"))
    }
    script = Path(__file__).with_name("paraview_probe.py")
    run = subprocess.run(
        ["xvfb-run", "-a", program, str(script), str(path), str(body)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    lines = [line for line in run.stdout.splitlines() if line.startswith("PROBE")]
    assert lines, run.stdout + run.stderr
    return json.loads(lines[0].removeprefix("PROBE"))


@pytest.fixture(scope="module", params=["as-usual", "small"])
def run(request, tmp_path_factory):
    """Three frames in 3D with every field; values change, and some particles leave at the end."""
    small = {"precision": "float32", "compression": "gzip"} if request.param == "small" else {}
    directory = tmp_path_factory.mktemp("paraview")
    (directory / "frames").mkdir()
    sim, _ = make_sim(Serial(), COUNT, 3)
    frames = Frames(directory, make_case(**small), sim)
    for number, gone in enumerate(GONE):
        sim, _ = make_sim(Serial(), COUNT, 3, gone=gone)
        sim.step, sim.time = 10 * number, 0.1 * number
        sim.particles.sigma *= 1.5**number
        sim.particles.x += 0.25 * number
        frames.write(sim)
    frames.finish()
    return directory


@pytest.fixture(scope="module")
def seen(run):
    return probe(run / "particles.xdmf", 1)


@pytest.mark.parametrize("reader", READERS)
def test_times_points_cells_and_ids(seen, reader):
    result = seen[reader]
    assert result["times"] == [0.0, 0.1, 0.2]
    for shown, count in zip(result["shown"], COUNTS, strict=True):
        assert shown["kind"] == "vtkUnstructuredGrid"
        assert len(shown["arrays"]["points"]) == count
        assert shown["cells"] == count
        assert shown["global ids"] == "id"


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("number", range(3))
def test_every_field_of_every_frame_arrives(run, seen, reader, number):
    frame = Frame(run / "frames" / f"particles-{number:06d}.h5")
    arrays = seen[reader]["shown"][number]["arrays"]
    assert set(arrays) == {"points", *frame.fields} - {"position"}
    for name in frame.fields:
        values = np.array(arrays["points" if name == "position" else name])
        np.testing.assert_array_equal(values, frame[name].reshape(len(frame), -1), err_msg=name)


@pytest.mark.parametrize("reader", READERS)
def test_the_six_stress_components_stay_apart(run, seen, reader):
    stress = np.array(seen[reader]["shown"][0]["arrays"]["stress"])
    assert stress.shape == (COUNT, 6)
    assert len(np.unique(stress)) == 6 * COUNT


@pytest.mark.parametrize("reader", READERS)
def test_threshold_by_body(run, seen, reader):
    bodies = Frame(run / "frames" / "particles-000002.h5")["body"]
    there = seen[reader]["threshold"]
    assert 0 < there["cells"] == np.count_nonzero(bodies == 1) < len(bodies) == COUNTS[2]
    assert np.unique(there["arrays"]["body"]) == [1]
