"""Frames of the grid: against the particles, by hand, in ParaView.

On any ranks: test_balance.py, test_ranks.py.
"""

import json

import h5py
import numpy as np
import pytest
from rank_scenes import GRID as EVERYTHING
from rank_scenes import line_gimp, plane_leaves, plane_mpm, space_gimp
from run_files import go_back
from scenes import box, scene, start, write_case

import pgimp
from pgimp.errors import RunError
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import Serial
from pgimp.running.recorder import Recorder
from pgimp.solver.reduction import Request
from pgimp.solver.state import grid_state

pytestmark = pytest.mark.slow(30)

FIELDS = ["velocity", "mass"]
SCENES = {
    "line": line_gimp(),
    "points": plane_mpm(),
    "leaves": plane_leaves(),
    "space": space_gimp(),
}
for each in SCENES.values():
    each["output"] |= {"fields": FIELDS, "grid": EVERYTHING}
PROBE = """
import json, sys
from paraview import servermanager, simple
found = {}
for name in ("XDMFReader", "Xdmf3ReaderS", "Xdmf3ReaderT"):
    key = "FileNames" if name == "XDMFReader" else "FileName"
    reader = getattr(simple, name)(**{key: [sys.argv[1]]})
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    reader.UpdatePipeline(times[-1])
    grid = servermanager.Fetch(reader)
    cell = grid.GetCell(0)
    sizes = simple.CellSize(Input=reader)
    sizes.UpdatePipeline(times[-1])
    data = servermanager.Fetch(sizes).GetCellData()
    part = {1: "Length", 2: "Area", 3: "Volume"}[cell.GetCellDimension()]
    array = data.GetArray(part)
    mass = grid.GetPointData().GetArray("mass")
    velocity = grid.GetPointData().GetArray("velocity")
    found[name] = {
        "times": times,
        "points": grid.GetNumberOfPoints(),
        "cells": grid.GetNumberOfCells(),
        "dimension": cell.GetCellDimension(),
        "sizes": [array.GetValue(i) for i in range(array.GetNumberOfTuples())],
        "mass": [mass.GetValue(i) for i in range(mass.GetNumberOfTuples())],
        "velocity": [velocity.GetTuple(i) for i in range(velocity.GetNumberOfTuples())],
    }
print("PROBE" + json.dumps(found))
"""


def run(folder, case, **options):
    """Run a case in this process and return its results."""
    folder.mkdir(exist_ok=True)
    write_case(folder / "case.yaml", case)
    return pgimp.run(folder / "case.yaml", output=folder / "out", quiet=True, **options)


def grids(result):
    """The frames of the grid: each a dictionary of arrays, with time and step."""
    found = []
    for path in sorted((result.path / "frames").glob("grid-*.h5")):
        with h5py.File(path) as file:
            names = [name for name in file if name != "VTKHDF"]
            found.append({name: file[name][()] for name in names} | dict(file.attrs))
    return found


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The scenes on one rank, as they are asked for."""
    folder, results = tmp_path_factory.mktemp("grid"), {}

    def result(name):
        if name not in results:
            results[name] = run(folder / name, SCENES[name])
        return results[name]

    return result


@pytest.mark.parametrize("name", SCENES)
def test_the_grid_has_what_the_particles_have(alone, name):
    """Mass and momentum by sums; the cells by where the particles are, once more in NumPy."""
    result = alone(name)
    D, cells = result.case.dimensions, 0
    assert len(grids(result)) == len(result)
    for grid, frame in zip(grids(result), result, strict=True):
        assert (grid["time"], grid["step"]) == (frame.time, frame.step)
        momentum = frame["mass"] @ frame["velocity"]
        assert grid["mass"].sum() == pytest.approx(frame["mass"].sum(), rel=1e-13)
        scale = (frame["mass"] @ np.abs(frame["velocity"])).max()
        np.testing.assert_allclose(grid["momentum"].sum(axis=0), momentum, atol=1e-13 * scale)
        np.testing.assert_allclose(
            grid["velocity"] * grid["mass"][:, None], grid["momentum"], rtol=1e-13
        )
        # Cells are whole and of size 1: the lowest corner is the particle's rounded down.
        corners = grid["position"][grid["connectivity"]]
        low = corners.min(axis=1)[:, :D]
        wanted = np.unique(np.floor(frame["position"][:, :D]), axis=0)
        assert np.array_equal(low, wanted)  # also in the order of x, y, z
        assert np.array_equal(corners.max(axis=1)[:, :D], wanted + 1.0)
        assert (grid["position"][:, D:] == 0.0).all()
        order = np.lexsort(grid["position"].T[::-1])
        assert np.array_equal(order, np.arange(len(order)))
        assert len(np.unique(grid["position"], axis=0)) == len(order)
        unused = np.setdiff1d(np.arange(len(order)), grid["connectivity"])
        assert (grid["mass"][unused] > 0.0).all()
        cells += len(wanted)
    assert cells > 20


def test_the_forces_of_a_block_at_the_start_are_its_weight(tmp_path):
    """Without stress the force is that of gravity, m b at each vertex."""
    case = scene(2, box([1.0, 1.0], [3.0, 3.0]), end=0.01, gravity=[0.5, -2.0])
    case["output"] = {"grid": ["mass", "force"]}
    first = grids(run(tmp_path, case))[0]
    assert set(first) >= {"mass", "force", "position", "connectivity"}
    assert not {"momentum", "velocity"} & set(first)
    np.testing.assert_array_equal(first["force"], first["mass"][:, None] * [0.5, -2.0, 0.0])
    assert first["mass"].sum() == pytest.approx(4.0, rel=1e-14)
    # Of a box on the grid's lines, a vertex inside has a cell, one at a side half of it.
    inner = {tuple(x): m for x, m in zip(first["position"][:, :2], first["mass"], strict=True)}
    assert inner[(2.0, 2.0)] == pytest.approx(1.0, rel=1e-14)


def test_the_force_is_what_the_momentum_grows_by(tmp_path):
    """Away from faces: dt f over all vertices is the change of momentum in the next step."""
    body = box([3.0, 3.0], [5.0, 5.0], {"rotation": {"about": [4.0, 4.0], "rate": 1.0}})
    case = scene(2, body, end=0.1, gravity=[0.0, -1.0])
    case["output"] = {"every": {"steps": 1}, "grid": EVERYTHING, "fields": FIELDS}
    result = run(tmp_path, case)
    frames, found = list(result), grids(result)
    for now, after, grid in zip(frames, frames[1:], found, strict=False):
        change = (after["mass"] @ after["velocity"]) - (now["mass"] @ now["velocity"])
        np.testing.assert_allclose(0.01 * grid["force"].sum(axis=0), change, atol=1e-12)
        assert np.abs(grid["force"]).max() > 0.1


def test_in_single_precision(tmp_path, alone):
    case = SCENES["leaves"] | {"output": SCENES["leaves"]["output"] | {"precision": "float32"}}
    for one, other in zip(grids(run(tmp_path, case)), grids(alone("leaves")), strict=True):
        for name in ("position", *EVERYTHING):
            assert one[name].dtype == np.float32
            assert np.array_equal(one[name], other[name].astype(np.float32))
        assert np.array_equal(one["connectivity"], other["connectivity"])


def test_without_it_nothing_is_written(tmp_path):
    result = run(tmp_path, scene(2, box([1.0, 1.0], [3.0, 3.0]), end=0.1))
    assert not (result.path / "grid.xdmf").exists() and not grids(result)


def test_it_may_be_asked_for_in_the_middle(tmp_path):
    case = scene(2, box([1.0, 1.0], [3.0, 3.0], [1.0, 0.0]), end=0.4)
    case |= {"checkpoint": {"every": {"steps": 10}, "keep": 9}, "output": {"every": 0.1}}
    result = run(tmp_path, case)
    go_back(result.path, 0.5)
    case["output"]["grid"] = ["mass"]
    result = run(tmp_path, case, resume=True)
    numbers = [path.name for path in sorted((result.path / "frames").glob("grid-*.h5"))]
    assert numbers == ["grid-000003.h5", "grid-000004.h5"]
    assert (result.path / "grid.xdmf").read_text().count("<Time") == 2
    run(tmp_path, case | {"output": {}}, overwrite=True)
    assert not (result.path / "grid.xdmf").exists() and not grids(result)


@pytest.mark.parametrize("wanted", [["mass"], []])
def test_frames_of_a_later_time_go_at_a_resume(tmp_path, wanted):
    """Also where no further ones are wanted, and where the new ones come at other times."""
    case = scene(2, box([1.0, 1.0], [3.0, 3.0], [1.0, 0.0]), end=0.4)
    case |= {"checkpoint": {"every": {"steps": 10}, "keep": 9}}
    result = run(tmp_path, case | {"output": {"every": 0.05, "grid": ["mass"]}})
    assert len(grids(result)) == 9
    go_back(result.path, 0.5)
    result = run(tmp_path, case | {"output": {"every": 0.2, "grid": wanted}}, resume=True)
    assert result.info["resumed_from"] == 20
    kept = [0.0, 0.05, 0.1, 0.15, 0.2, *([0.4] if wanted else [])]
    assert [grid["time"] for grid in grids(result)] == pytest.approx(kept)
    assert (result.path / "grid.xdmf").read_text().count("<Time") == len(kept)
    assert result.times.tolist() == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2, 0.4])


@pytest.mark.parametrize("fails", ["history", "probes", "frames", "grid"])
def test_a_whole_frame_is_kept_when_the_next_one_or_a_line_fails(tmp_path, monkeypatch, fails):
    """What is on its way to the disk gets its name, though the run ends."""

    def broken(*_, **__):
        raise RunError("no room")

    case = scene(2, box([1.0, 1.0], [3.0, 3.0], [1.0, 0.0]), end=0.4)
    case |= {"history": {"every": {"steps": 1}}, "probes": {"a": {"place": [2.0, 2.0]}}}
    case |= {"output": {"every": {"steps": 2}, "grid": ["mass"]}}
    sim, comm = start(case), Serial()
    directory = RunDirectory(tmp_path / "out", comm, probes=["a"])
    directory.prepare({}, {"state": "running", "began": "now", "steps": 0})
    recorder = Recorder(directory, sim.case, sim)
    recorder.begin()
    assert not list((tmp_path / "out" / "frames").glob("*.h5"))
    if fails in ("history", "probes"):
        monkeypatch.setattr(getattr(recorder, fails), "write", broken)
    elif fails == "frames":
        monkeypatch.setattr(recorder.frames._file, "write", broken)
    else:
        monkeypatch.setattr(grid_state, "active_grid", broken)
    with pytest.raises(RunError, match="no room"):
        for _ in range(2):
            sim.request = Request.PENDING  # as if the disk were slow
            sim.advance()
            recorder.step()
    recorder.close()
    directory.release()
    kept = {"grid-000000.h5", "particles-000000.h5"}
    kept |= {"particles-000001.h5"} if fails == "grid" else set()
    assert {path.name for path in (tmp_path / "out" / "frames").iterdir()} == kept
    listed = [(tmp_path / "out" / f"{name}.xdmf").read_text() for name in ("particles", "grid")]
    assert {name for name in kept if name in "".join(listed)} == kept
    for path in (tmp_path / "out" / "frames").iterdir():
        with h5py.File(path) as file:
            assert len(file["position"]) > 0 and np.isfinite(file["position"][()]).all()


@pytest.mark.parametrize("name", ["line", "leaves", "space"])
def test_paraview_shows_the_cells(pvpython, alone, tmp_path, name):
    """Each of its readers: as many cells, each whole and of size 1, and the values."""
    result = alone(name)
    last = next(grid for grid in reversed(grids(result)) if len(grid["connectivity"]))
    script = tmp_path / "probe.py"
    script.write_text(PROBE)
    job = pvpython(script, result.path / "grid.xdmf")
    lines = [line for line in job.stdout.splitlines() if line.startswith("PROBE")]
    assert lines, job.stdout + job.stderr
    for reader, seen in json.loads(lines[0].removeprefix("PROBE")).items():
        assert seen["times"] == pytest.approx(result.times), reader
        assert seen["points"] == len(last["mass"]) and seen["dimension"] == result.case.dimensions
        assert seen["cells"] == len(last["connectivity"]) > 0
        assert seen["sizes"] == pytest.approx([1.0] * seen["cells"], rel=1e-12)
        assert seen["mass"] == last["mass"].tolist()
        np.testing.assert_array_equal(seen["velocity"], last["velocity"])
