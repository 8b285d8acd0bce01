"""Frames, history and the files of a run directory, read back independently of what wrote them."""

import hashlib
import os
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from pgimp.case import fields as case_fields
from pgimp.errors import RunError, UsageError
from pgimp.output.fields import ALWAYS, FIELDS, OPTIONAL, Source
from pgimp.output.framefile import FrameFile
from pgimp.output.frames import Frames
from pgimp.output.history import History
from pgimp.output.log import Log, timing_table
from pgimp.output.progress import Progress, duration
from pgimp.output.reader import Frame
from pgimp.output.rows import Rows
from pgimp.output.rundir import RunDirectory
from pgimp.output.schedule import Schedule
from pgimp.parallel.comm import Serial, world

LATERAL = {1: 3, 2: 4, 3: 6}


def make_case(fields=tuple(OPTIONAL)):
    return SimpleNamespace(
        title="a test", units="none", output=SimpleNamespace(fields=list(fields))
    )


def make_sim(comm, count, dimension, empty=()):
    """Spread particles of random values over the ranks, in storage with holes and no order.

    Returns the fake simulation and the values of all particles by id. Ranks in `empty` get none.
    """
    random = np.random.default_rng(7)
    values = {
        "id": np.arange(count),
        "body": (2 * np.arange(count) // count).astype(np.int32),
        "x": random.normal(size=(count, dimension)),
        "v": random.normal(size=(count, dimension)),
        "F": random.normal(size=(count, dimension**2)),
        "sigma": random.normal(size=(count, LATERAL[dimension])),
        "V": random.uniform(0.5, 2.0, size=count),
        "origin": random.normal(size=(count, dimension)),
    }
    owner = random.integers(comm.size, size=count)
    owner[np.isin(owner, empty)] = 0
    mine = np.flatnonzero(owner == comm.rank)
    storage = random.permutation(2 * len(mine) + 3)[: len(mine)]
    particles = SimpleNamespace()
    for name, of_all in values.items():
        stored = np.full((2 * len(mine) + 3, *of_all.shape[1:]), -99, of_all.dtype)
        stored[storage] = of_all[mine]
        setattr(particles, name, stored)
    scene = SimpleNamespace(
        dimension=dimension,
        body_names=("left", "right"),
        material_names=("soft", "hard"),
        body_material=(1, 0),
    )
    sim = SimpleNamespace(
        comm=comm,
        count=count,
        time=0.1,
        step=3,
        dt=0.1,
        scene=scene,
        particles=particles,
        live=lambda: storage,
    )
    return sim, values


def expected(values, dimension):
    """What a frame must hold, from the values by id and the definitions of the fields."""
    count = len(values["id"])

    def padded(array, columns):
        return np.hstack([array, np.zeros((count, columns - array.shape[1]))])

    deformation = np.tile(np.eye(3), (count, 1, 1))
    gradient = values["F"].reshape(count, dimension, dimension)
    deformation[:, :dimension, :dimension] = gradient
    stress = padded(values["sigma"], 6)
    tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(count, 3, 3)
    mean = np.trace(tensor, axis1=1, axis2=2) / 3
    deviator = tensor - mean[:, None, None] * np.eye(3)
    return {
        "id": values["id"],
        "body": values["body"],
        "material": np.array([1, 0])[values["body"]],
        "position": padded(values["x"], 3),
        "volume": values["V"],
        "radius": values["V"] ** (1 / dimension) / 2,
        "velocity": padded(values["v"], 3),
        "stress": stress,
        "displacement": padded(values["x"] - values["origin"], 3),
        "deformation": deformation.reshape(count, 9),
        "pressure": -mean,
        "von-mises": np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2))),
        "connectivity": np.arange(count),
    }


def write_frames(directory, comm, count, dimension, empty=(), streamed=False, number=2):
    (directory / "frames").mkdir(parents=True, exist_ok=True)
    comm.Barrier()
    sim, values = make_sim(comm, count, dimension, empty)
    frames = Frames(directory, make_case(), sim)
    if streamed:
        frames.parallel = False
    for _ in range(number):
        frames.write(sim)
    return frames, values


@pytest.fixture
def ranks_do(mpirun):
    """Let a number of ranks do a task of `work` in this file; returns what they print."""

    def start(ranks, *arguments):
        path = {"PYTHONPATH": str(Path(__file__).parents[1])}
        job = mpirun(ranks, [__file__, *arguments], env=path)
        assert job.returncode == 0, job.stdout + job.stderr
        return job.stdout

    return start


def digests(directory):
    files = sorted((directory / "frames").iterdir())
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_frame_holds_the_particles_by_id(tmp_path, dimension):
    _, values = write_frames(tmp_path, Serial(), 57, dimension)
    wanted = expected(values, dimension)
    with h5py.File(tmp_path / "frames" / "particles-000001.h5") as file:
        assert set(file) == set(wanted) == {"connectivity", *FIELDS}
        for name, array in wanted.items():
            exact = name not in ("radius", "pressure", "von-mises")
            assert file[name].shape == array.shape
            np.testing.assert_allclose(
                file[name][:], array, rtol=0 if exact else 1e-13, err_msg=name
            )
        for name in ("body", "material"):
            assert file[name].dtype == np.int32
        assert file["id"].dtype == np.int64
        assert file.attrs["time"] == 0.1 and file.attrs["step"] == 3
        assert file.attrs["title"] == "a test" and file.attrs["units"] == "none"
        assert list(file.attrs["bodies"]) == list(file["body"].attrs["names"]) == ["left", "right"]
        assert list(file["material"].attrs["names"]) == ["soft", "hard"]


def test_the_case_offers_the_fields_that_there_are():
    assert list(case_fields.ALWAYS) == list(ALWAYS)
    assert list(case_fields.FIELDS) == list(OPTIONAL)


def test_only_what_is_asked_for_is_written(tmp_path):
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 5, 2)
    Frames(tmp_path, make_case(["stress"]), sim).write(sim)
    frame = Frame(tmp_path / "frames" / "particles-000000.h5")
    assert set(frame.fields) == {*ALWAYS, "stress"}
    attributes = xml.etree.ElementTree.parse(tmp_path / "particles.xdmf").iter("Attribute")
    shown = {attribute.get("Name") for attribute in attributes}
    assert shown == {*ALWAYS, "stress"} - {"position"}


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_field_values_do_not_depend_on_the_neighbours(name, dimension):
    """The bits of a particle may not change with where in an array it is processed."""
    sim, _ = make_sim(Serial(), 40, dimension)
    rows = sim.live()

    def values(some):
        return FIELDS[name].values(Source(sim.particles, some, dimension, (1, 0)))

    whole = values(rows)
    for start in range(9):
        for length in (1, 2, 3, 4, 5, 8, 13, 31):
            part = values(rows[start : start + length])
            assert part.tobytes() == whole[start : start + length].tobytes()


# Two particles on four ranks: two ranks have no rows. Rank 1 has no particles in any case.
@pytest.mark.parametrize("count", [2, 3001])
def test_every_number_of_ranks_writes_the_same_file(tmp_path, ranks_do, count):
    _, values = write_frames(tmp_path / "serial", Serial(), count, 3)
    wanted = digests(tmp_path / "serial")
    assert set(wanted) == {"particles-000000.h5", "particles-000001.h5"}
    xdmf = (tmp_path / "serial" / "particles.xdmf").read_bytes()
    for ranks in (1, 2, 3, 4):
        out = ranks_do(ranks, "frames", tmp_path, count)
        ways = ("parallel", "streamed") if ranks > 1 else ("streamed",)
        assert out.split() == [f"{way}-{ranks}" for way in ways]
        for way in ways:
            directory = tmp_path / f"{way}-{ranks}"
            assert digests(directory) == wanted, (ranks, way)
            assert (directory / "particles.xdmf").read_bytes() == xdmf
            with h5py.File(directory / "frames" / "particles-000001.h5") as file:
                np.testing.assert_array_equal(file["stress"][:], expected(values, 3)["stress"])


def test_large_fields_stream_in_several_blocks(tmp_path, ranks_do):
    write_frames(tmp_path / "serial", Serial(), 3001, 3)
    ranks_do(3, "small-blocks", tmp_path, 3001)
    assert digests(tmp_path / "streamed-3") == digests(tmp_path / "serial")


def test_a_lost_particle_is_noticed():
    ids = np.array([0, 1, 3, 3])
    with pytest.raises(RunError, match="an id is missing or there twice"):
        Rows(Serial(), ids, np.arange(4), 4)


def test_reading_back_notices_a_changed_byte(tmp_path):
    write_frames(tmp_path, Serial(), 10, 1, number=1)
    path = tmp_path / "frames" / "particles-000000.h5"
    with h5py.File(path) as file:
        offset = file["volume"].id.get_offset()
        volumes = file["volume"][:]
    rows = Rows(Serial(), np.arange(10), np.arange(10), 10)
    frame = FrameFile(path, rows, False, {"volume": offset})
    frame.write("volume", volumes)
    frame.close()
    assert frame.error is None and frame.check() is None
    data = bytearray(path.read_bytes())
    data[offset + 17] ^= 1
    path.write_bytes(data)
    assert "reads back different" in frame.check()
    path.write_bytes(data[: offset + 17])
    assert "reads back different" in frame.check()


@pytest.fixture
def small_disk(tmp_path):
    """A file system of one megabyte; only root may mount one, which CI is."""
    if os.geteuid() != 0:
        pytest.skip("needs root to mount a small file system")
    place = tmp_path / "disk"
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", place], check=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", place], check=True)


def check_full_disk(directory, before):
    """On a disk that filled up, the frames that are there are whole and the series lists them."""
    names = sorted(path.name for path in (directory / "frames").iterdir())
    assert names == [f"particles-{number:06d}.h5" for number in range(before)]
    for name in names:
        frame = Frame(directory / "frames" / name)
        np.testing.assert_array_equal(frame["id"], np.arange(len(frame)))
        assert np.isfinite(frame["stress"]).all() and frame["stress"].all()
    document = xml.etree.ElementTree.parse(directory / "particles.xdmf")
    items = {item.text.split(":")[0] for item in document.iter("DataItem")}
    assert items == {f"frames/{name}" for name in names}


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_a_full_disk_stops_the_run_and_spoils_nothing(small_disk, ranks_do, ranks):
    # A frame takes about 250 bytes a particle, so that the fourth does not fit.
    out = ranks_do(ranks, "fill", small_disk, 1100)
    messages = out.splitlines()
    assert len(messages) == ranks and len(set(messages)) == 1
    assert "particles-000003.h5" in messages[0] and "No space left on device" in messages[0]
    check_full_disk(small_disk, 3)


def test_any_amount_of_free_space_is_handled(small_disk):
    """From no free block to all but enough: always an error, never a file or a crash."""
    (small_disk / "frames").mkdir()
    sim, _ = make_sim(Serial(), 400, 3)
    frames = Frames(small_disk, make_case(), sim)
    frames.write(sim)
    size = (small_disk / "frames" / "particles-000000.h5").stat().st_size
    for free in range(0, size, 8192):
        room = os.statvfs(small_disk)
        ballast = small_disk / "ballast"
        ballast.write_bytes(bytes(room.f_bavail * room.f_frsize - free))
        with pytest.raises(RunError, match="No space left"):
            frames.write(sim)
        ballast.unlink()
        check_full_disk(small_disk, 1)
    frames.write(sim)
    check_full_disk(small_disk, 2)


class Lines:
    """A simulation of which only the history matters."""

    def __init__(self):
        self.comm, self.step, self.time = Serial(), 0, 0.0
        self.values = np.random.default_rng(3).normal(size=4) * 10.0 ** np.array([0, 200, -300, 17])

    def diagnostics(self):
        return {"time": self.time, "step": self.step, "dt": 0.1 + 0.2} | {
            f"value_{i}": value for i, value in enumerate([*self.values, float("nan"), -0.0])
        }


def test_history_lines_hold_every_bit(tmp_path):
    from pgimp.output.history import read

    sim, history = Lines(), History(tmp_path / "history.csv")
    for step in range(3):
        sim.step, sim.time = step, step * 0.1
        history.write(sim)
        history.write(sim)  # a second line for the same step is not wanted
        assert len((tmp_path / "history.csv").read_text().splitlines()) == step + 2
    history.close()
    with open(tmp_path / "history.csv", "a") as stream:
        stream.write("0.30000000000000004,3,0.3")  # a line that is just being written
    table = read(tmp_path / "history.csv")
    assert table.dtype.names == tuple(sim.diagnostics())
    assert len(table) == 3
    for name, value in sim.diagnostics().items():
        assert table[name][-1].tobytes() == np.float64(value).tobytes()
    assert "0.30000000000000004" in (tmp_path / "history.csv").read_text()


def test_history_on_a_full_disk_keeps_whole_lines(small_disk):
    sim, history = Lines(), History(small_disk / "history.csv")
    history.write(sim)
    room = os.statvfs(small_disk)
    (small_disk / "ballast").write_bytes(bytes(room.f_bavail * room.f_frsize))
    with pytest.raises(RunError, match=r"history\.csv: No space left"):
        for step in range(1, 100):
            sim.step = step
            history.write(sim)
    history.close()
    lines = (small_disk / "history.csv").read_text().splitlines(keepends=True)
    assert len(lines) > 10
    assert {(line.count(","), line[-1]) for line in lines} == {(8, "\n")}


def fixed_steps(schedule, step, number):
    return [n for n in range(1, number + 1) if schedule.due(n * step, n, step)]


def test_schedule_with_a_fixed_step():
    assert fixed_steps(Schedule(0.1), 1e-4, 20000) == list(range(1000, 20001, 1000))
    assert fixed_steps(Schedule(SimpleNamespace(steps=7)), 1e-4, 30) == [7, 14, 21, 28]
    assert fixed_steps(Schedule(0.25), 0.1, 12) == [3, 5, 8, 10]
    assert fixed_steps(Schedule(1e-6), 0.1, 4) == [1, 2, 3, 4]
    assert fixed_steps(Schedule(0.5, [0.72, 0.3, 0.31]), 0.1, 12) == [3, 4, 5, 8, 10]
    assert fixed_steps(Schedule(), 0.1, 100) == []
    # However the product rounds, multiples of a third of a day fall on every 25,000th step.
    assert fixed_steps(Schedule(28800.0 / 7), 28800.0 / 7 / 25000, 100_000) == [
        25000,
        50000,
        75000,
        100000,
    ]


def test_schedule_with_steps_of_any_size():
    random = np.random.default_rng(5)
    schedule, time, hits = Schedule(0.1), 0.0, []
    for step in range(1, 400):
        dt = random.uniform(0.001, 0.3)
        before, time = time, time + dt
        if schedule.due(time, step, dt):
            hits.append(step)
        crossed = int(np.floor(time / 0.1)) > int(np.floor(before / 0.1))
        assert crossed == (hits[-1:] == [step])
    assert hits


class Claims:
    """Run directories whose files a test looks at."""

    @staticmethod
    def make(path, overwrite=False):
        directory = RunDirectory(path, Serial(), overwrite)
        directory.prepare(
            {"case.yaml": "resolved", "input.yaml": "verbatim"},
            {"state": "running", "began": "now", "steps": 0},
        )
        (path / "history.csv").write_text("time\n")
        (path / "log.txt").write_text("log\n")
        (path / "frames" / "particles-000000.h5").write_text("frame")
        (path / "frames" / ".particles-000001.h5.part").write_text("half a frame")
        directory.record_failure("failed", 7, 0.5, "it broke")
        directory.release()


def test_overwrite_deletes_only_what_a_run_made(tmp_path):
    path = tmp_path / "out"
    Claims.make(path)
    foreign = ["notes.txt", "frames/mine.h5", "frames/particles-1.h5", "case.yaml.bak"]
    for name in foreign:
        (path / name).write_text("mine")
    with pytest.raises(UsageError, match=r"holds a run \(failed.*7 steps(.|\n)*--overwrite"):
        RunDirectory(path, Serial())
    directory = RunDirectory(path, Serial(), overwrite=True)
    assert (path / "frames" / "particles-000000.h5").exists()  # until the new run is sure to start
    directory.prepare({"case.yaml": "new"}, {"state": "running"})
    directory.release()
    there = {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}
    assert there == {*foreign, "run.json", "case.yaml"}
    assert {(path / name).read_text() for name in foreign} == {"mine"}


@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("name", ["case.yaml", "run.json", "frames", "log.txt"])
def test_files_that_are_no_runs_are_left_alone(tmp_path, name, overwrite):
    (tmp_path / name).write_text("mine")
    with pytest.raises(UsageError, match=f"has a {name}, but no run"):
        RunDirectory(tmp_path, Serial(), overwrite)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


def test_a_failure_is_noted_once(tmp_path):
    import json

    Claims.make(tmp_path / "out")
    directory = RunDirectory(tmp_path / "out", Serial(), overwrite=True)
    directory.prepare({}, {"state": "running"})
    directory.record_failure("failed", 8, 0.25, "particle 5 left the domain")
    directory.record_failure("failed", 9, 0.75, "another rank")
    directory.release()
    start = json.loads((tmp_path / "out" / "run.json").read_text())["starts"][-1]
    assert (start["state"], start["steps"], start["time"]) == ("failed", 8, 0.25)
    log = (tmp_path / "out" / "log.txt").read_text()
    assert log == "failed at step 8, t = 0.25: particle 5 left the domain\n"


def test_one_run_at_a_time(tmp_path):
    holder = RunDirectory(tmp_path / "out", Serial())
    code = (
        "import sys, pathlib; from pgimp.output.rundir import RunDirectory\n"
        "from pgimp.parallel.comm import Serial\n"
        "RunDirectory(pathlib.Path(sys.argv[1]), Serial(), True)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "out")]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}

    def attempt():
        return subprocess.run(command, env=environment, capture_output=True, text=True).stderr

    assert f"process {os.getpid()} on " in attempt()
    holder.release()
    assert not (tmp_path / "out").exists()  # made, and left empty
    assert attempt() == ""
    # That process went without a release, as if killed: its lock is gone, its file is not.
    assert (tmp_path / "out" / ".lock").exists()
    RunDirectory(tmp_path / "out", Serial()).release()


def test_places_that_cannot_be_written(tmp_path, small_disk):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="is a file"):
        RunDirectory(tmp_path / "file", Serial())
    with pytest.raises(UsageError, match="Not a directory"):
        RunDirectory(tmp_path / "file" / "out", Serial())
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    with pytest.raises(UsageError, match=r"Read-only file system\. Choose another place with -o"):
        RunDirectory(small_disk / "out", Serial())
    subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)
    room = os.statvfs(small_disk)
    (small_disk / "ballast").write_bytes(bytes(room.f_bavail * room.f_frsize))
    with pytest.raises(RunError, match="No space left"):
        RunDirectory(small_disk / "out", Serial())
    assert not (small_disk / "out").exists()


def test_the_log_keeps_what_was_said(tmp_path, capsys):
    log = Log(speaks=True)
    log.say("before there is a directory")
    log.keep_in(tmp_path / "log.txt")
    log.say("after")
    log.note("only in the file")
    log.close()
    assert capsys.readouterr().out == "before there is a directory\nafter\n"
    text = (tmp_path / "log.txt").read_text()
    assert text == "before there is a directory\nafter\nonly in the file\n"
    quiet = Log(speaks=True, quiet=True)
    quiet.say("to the file only")
    assert capsys.readouterr().out == ""


def test_timing_table():
    table = timing_table(Serial(), {"P2G": 3.0, "frames": 1.0}, 5.0).splitlines()
    cells = {line.split()[0]: line.split()[1:] for line in table[2:]}
    assert cells["P2G"] == ["3.0000", "3.0000", "3.0000", "60.0", "%"]
    assert cells["other"][-2:] == ["20.0", "%"]
    assert cells["total"] == ["5.0000", "100.0", "%"]


def test_plain_progress_lines_grow_rare(monkeypatch, capsys):
    from pgimp.output import progress

    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress, "perf_counter", lambda: clock.now)
    sim = SimpleNamespace(time=0.0, step=0, dt=1e-4, count=1000)
    bar = Progress(Log(speaks=True), sim, 100.0, 0)
    lines, looks = [], 0
    for step in range(1, 1_000_000):
        sim.step, sim.time = step, step * 1e-4
        clock.now = step * 5e-4
        bar.step()
        if out := capsys.readouterr().out if bar._looked == clock.now else "":
            lines.append((clock.now, out))
        looks += bar._looked == clock.now
    assert looks < 6000
    pauses = np.diff([0.0, *(when for when, _ in lines)])
    assert 10.0 <= pauses[0] < 10.5
    assert (pauses[1:] > pauses[:-1] - 0.5).all() and 60.0 <= pauses[-1] < 60.5
    when, line = lines[3]
    assert f"/100  step {round(when / 5e-4)}  dt 0.0001  2e+06 particle-steps/s" in line
    assert line.endswith(f"{duration(500.0 - when)} left\n")


def test_durations():
    assert [duration(s) for s in (0.0123, 9.996, 65.4, 3725.0, float("inf"))] == [
        "0.0123 s",
        "10 s",
        "1:05 min",
        "1:02:05 h",
        "?",
    ]


def work(task, directory, count):
    """Be a rank of a test's job."""
    comm = world()
    if task in ("frames", "small-blocks"):
        if task == "small-blocks":
            from pgimp.output import framefile

            framefile._BLOCK = 1000
        for streamed in (False, True) if task == "frames" and comm.size > 1 else (True,):
            name = f"{'streamed' if streamed else 'parallel'}-{comm.size}"
            frames, _ = write_frames(directory / name, comm, count, 3, (1,), streamed)
            if comm.rank == 0:
                print(f"{'parallel' if frames.parallel else 'streamed'}-{comm.size}")
    if task == "fill":
        try:
            write_frames(directory, comm, count, 3, number=100)
        except RunError as error:
            print(f"{error}\n", end="", flush=True)


if __name__ == "__main__":
    work(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
