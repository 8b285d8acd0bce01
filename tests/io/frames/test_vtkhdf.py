"""Frames and series as VTK's own reader sees them, in a process of its own: values bit for bit.

Several versions of VTK: scripts/vtk.
"""

import shutil

import h5py
import numpy as np
import pytest
from particle_source import make_case, make_sim, write_frames
from pressed_blocks import on_a_plate, resting_block
from processes import PROGRAMS
from scenes import box, scene, write_case
from tiers import wide
from vtk_reference import save

from pgimp.cli import main
from pgimp.errors import RunError
from pgimp.io.frames import vtkhdf, vtkseries
from pgimp.io.frames.mesh import described
from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial
from pgimp.running.frames import Frames

pytestmark = pytest.mark.slow(25)

COUNT = 23


@pytest.fixture
def same(python, tmp_path):
    """``same(run)`` lets VTK read a run, and returns how it differs from what pgimp reads."""

    def compare(run):
        save(run, tmp_path / "reference.npz")
        job = python([PROGRAMS / "vtk_probe.py", run, tmp_path / "reference.npz"])
        assert "VTK 9." in job.stdout, job.stdout + job.stderr
        return job.stdout.splitlines()[:-1]

    return compare


def frames_of(directory, dimension, gone, fields=("stress", "velocity"), **output):
    """Frames of particles, in each of which others are gone."""
    (directory / "frames").mkdir(parents=True, exist_ok=True)
    sim, _ = make_sim(Serial(), COUNT, dimension)
    frames = Frames(directory, make_case(fields, **output), sim)
    for number, missing in enumerate(gone):
        sim, _ = make_sim(Serial(), COUNT, dimension, gone=missing)
        sim.step, sim.time = number, 0.1 * number
        sim.particles.sigma *= 1.5**number
        frames.write(sim)
    frames.finish()
    return frames


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("small", [False, True])
@pytest.mark.parametrize("part", [5, COUNT, 1 << 17])
def test_vtk_reads_what_pgimp_reads(monkeypatch, tmp_path, same, dimension, small, part):
    """Particles that leave and come, none at all, in several parts, on several processes."""
    monkeypatch.setattr(vtkhdf, "PART", part)
    output = {"precision": "float32", "compression": "gzip"} if small else {}
    everyone = range(COUNT)
    gone = [everyone, range(3, COUNT), (), range(9, 14), range(7), (), everyone]
    frames_of(tmp_path / "run", dimension, gone, **output).close()
    assert same(tmp_path / "run") == []


@pytest.mark.parametrize("gone", [[range(COUNT)], [range(COUNT)] * 3, [()]])
def test_runs_without_particles_and_of_one_frame(tmp_path, same, gone):
    frames_of(tmp_path / "run", 2, gone).close()
    assert same(tmp_path / "run") == []


def test_one_bit_is_seen(tmp_path, same):
    """That the comparison of these tests finds what differs."""
    frames_of(tmp_path / "run", 2, [(), ()]).close()
    shutil.copytree(tmp_path / "run", tmp_path / "other")
    with h5py.File(tmp_path / "run" / "frames" / "particles-000001.h5", "r+") as file:
        del file["VTKHDF/PointData/stress"]
        file["VTKHDF/PointData/stress"] = file["stress"][()]
        file["VTKHDF/PointData/stress"][3, 4] = np.nextafter(file["stress"][3, 4], 9.0)
    assert same(tmp_path / "run") == ["particles-000001: stress has other values"]
    with h5py.File(tmp_path / "other" / "particles.vtkhdf", "r+") as file:
        file["VTKHDF/Steps/PointOffsets"][1] -= 1
    assert any("position has other values" in line for line in same(tmp_path / "other"))


def test_stages_may_have_other_fields_and_precision(tmp_path, same):
    """Where a frame does not have a field the series has nan, or -1; the wider type is exact."""
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), COUNT, 3)
    frames = Frames(tmp_path, make_case(["stress", "rank"]), sim)
    frames.write(sim)
    sim.time = 0.2
    frames.finish()
    frames.enter(make_case(["strain", "velocity"], precision="float32"), sim)
    frames.write(sim)
    frames.finish()
    frames.close()
    assert same(tmp_path) == []
    with h5py.File(tmp_path / "particles.vtkhdf") as file:
        data = file["VTKHDF/PointData"]
        assert data["stress"].dtype == np.float64 and data["strain"].dtype == np.float32
        assert np.isnan(data["stress"][COUNT:]).all() and np.isnan(data["strain"][:COUNT]).all()
        assert (data["rank"][COUNT:] == -1).all() and (data["rank"][:COUNT] == 0).all()
        assert data["volume"].dtype == np.float64


def test_a_moved_run_opens_and_a_lost_frame_is_no_number(tmp_path, same):
    frames_of(tmp_path / "run", 2, [(), range(9, 14), ()]).close()
    (tmp_path / "elsewhere").mkdir()
    run = (tmp_path / "run").rename(tmp_path / "elsewhere" / "moved.out")
    assert same(run) == []
    lost = run / "frames" / "particles-000001.h5"
    kept = lost.rename(run / "kept.h5")
    with h5py.File(run / "particles.vtkhdf") as file:
        stress = file["VTKHDF/PointData/stress"][()]
        assert np.isnan(stress[COUNT : 2 * COUNT - 5]).all()
        first = Frame(run / "frames" / "particles-000000.h5")["stress"]
        np.testing.assert_array_equal(stress[:COUNT], first)
    kept.rename(lost)


def test_a_frame_has_its_data_once(tmp_path):
    """The group costs a few kB, and less where the frame is large."""
    for count in (100, 12_000):
        write_frames(tmp_path / str(count), Serial(), count, 3)
        path = tmp_path / str(count) / "frames" / "particles-000000.h5"
        fields = Frame(path).fields
        with h5py.File(path) as file:
            data = file["VTKHDF/PointData"]
            for name in fields:
                other = file["VTKHDF/Points"] if name == "position" else data[name]
                assert other.id.get_offset() == file[name].id.get_offset()
            rows = sum(file[name].nbytes for name in file if name != "VTKHDF")
        assert path.stat().st_size - rows < 24_000


def test_the_list_is_rewritten_only_where_that_costs_little(monkeypatch, tmp_path):
    """Frames at once are listed together at the end, those with time between them one by one."""
    now = [0.0]
    monkeypatch.setattr(vtkseries, "perf_counter", lambda: now[0])
    written, write = [], vtkseries.VtkSeries.write

    def slow(self, durable=False):
        written.append(len(self._meshes))
        now[0] += 1.0
        write(self, durable)

    monkeypatch.setattr(vtkseries.VtkSeries, "write", slow)
    frames = frames_of(tmp_path, 2, [()] * 5)
    assert written == [1]
    now[0] += 100.0
    frames.write(make_sim(Serial(), COUNT, 2)[0])
    frames.finish()
    assert written == [1, 6]
    frames.close()
    with h5py.File(tmp_path / "particles.vtkhdf") as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 6


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run in 3D with a grid, a ball that moves and a block; it ends later when resumed."""
    folder = tmp_path_factory.mktemp("vtk")
    bodies = {
        "soft": box([1.0] * 3, [2.0] * 3),
        "ball": {
            "rigid": {"velocity": [0.5, 0.0, 0.0]},
            "region": {"ball": {"centre": [4.0, 4.0, 4.0], "radius": 1.5}},
        },
    }
    output = {"every": 0.1, "grid": ["mass", "velocity"], "fields": ["stress"]}
    write_case(folder / "case.yaml", scene(3, bodies, end=0.3, output=output))
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return folder / "out"


def test_the_grid_and_rigid_bodies(run, same):
    assert same(run) == []


@pytest.mark.parametrize("dimension", [2, wide(3)])
def test_surfaces_that_meet(tmp_path, same, dimension):
    """Their fields are of cells, lines or quadrilaterals that share points."""
    case = resting_block(end=0.2)
    if dimension == 3:
        body = {"region": {"ball": {"centre": [4.1, 4.2, 4.9], "radius": 2.0}}}
        plate = [1.0, 1.0, 1.0], [7.0, 7.0, 2.9], [0.0] * 3
        case = on_a_plate(body, plate, [8, 8, 8], 0.2, 0.1, gravity=[0.0, 0.0, -10.0])
    write_case(tmp_path / "case.yaml", case)
    assert main([str(tmp_path / "case.yaml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    assert same(tmp_path / "out") == []
    with h5py.File(tmp_path / "out" / "surface.vtkhdf") as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 3
        assert (file["VTKHDF/CellData/contact-pressure"][:] > 0.0).any()


def test_a_resumed_run(run, tmp_path, same):
    shutil.copytree(run, tmp_path / "out")
    words = [str(run.parent / "case.yaml"), "-o", str(tmp_path / "out"), "--resume", "--quiet"]
    assert main([*words, "--set", "time.end=0.5", "--set", "output.fields=[velocity]"]) == 0
    assert same(tmp_path / "out") == []
    with h5py.File(tmp_path / "out" / "grid.vtkhdf") as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 6


def test_lists_go_on_without_frames_that_are_damaged(run, tmp_path):
    shutil.copytree(run, tmp_path / "out")
    (tmp_path / "out" / "frames" / "particles-000001.h5").write_bytes(b"no frame")
    words = [str(run.parent / "case.yaml"), "-o", str(tmp_path / "out"), "--resume", "--quiet"]
    assert main([*words, "--set", "time.end=0.4"]) == 0
    with h5py.File(tmp_path / "out" / "particles.vtkhdf") as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 4
        np.testing.assert_allclose(file["VTKHDF/Steps/Values"][:], [0.0, 0.2, 0.3, 0.4])


def test_what_is_no_frame_is_refused(tmp_path):
    with h5py.File(tmp_path / "particles-000000.h5", "w") as file:
        file["position"] = np.zeros((3, 3))
    with pytest.raises(RunError, match="it has no 'connectivity'"):
        described(tmp_path / "particles-000000.h5")
