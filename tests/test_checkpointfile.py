"""Checkpoint files: what is written comes back, and nothing that is damaged is taken for whole."""

import os
import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from particle_source import fill_up, small_disk

from pgimp.errors import RunError
from pgimp.output import checkpointwriter, framefile
from pgimp.output.checkpointfile import CheckpointFile, DamagedError, write
from pgimp.output.framefile import FrameFile
from pgimp.parallel.comm import Serial, world

ABOUT = {"time": 0.1 + 0.2, "zero": -0.0, "step": 7, "title": 'Fülle "\\ud83d"\n', "none": [None]}
HERE = {"PYTHONPATH": str(Path(__file__).parents[1])}


def content(count, seed=5):
    random = np.random.default_rng(seed)
    rows = {
        "id": random.permutation(count),
        "x": random.normal(size=(count, 3)),
        "body": random.integers(9, size=count).astype(np.int32),
        "F": random.normal(size=(count, 2, 2)),
        "none": np.zeros((count, 0)),
    }
    if count:
        rows["x"][0] = [np.nan, -0.0, np.inf]
    whole = {"layers": np.arange(6), "work": random.normal(size=(3, 2)), "s": np.array(2.5)}
    return rows, whole | {"empty": np.zeros((0, 3))}


def write_on(comm, path, count, parallel=True, empty=(1,), seed=5):
    """Write with the rows spread over the ranks; those in `empty` get none."""
    rows, whole = content(count, seed)
    shares = np.array([0 if rank in empty else rank + 1 for rank in range(comm.size)])
    bounds = [0, *(np.cumsum(shares) * count // max(1, shares.sum()))]
    mine = {name: a[bounds[comm.rank] : bounds[comm.rank + 1]] for name, a in rows.items()}
    about, whole = (ABOUT, whole) if comm.rank == 0 else ({}, {})
    write(path, comm, parallel, about, mine, whole)


def check_content(path, count, parts=2, seed=5):
    """The file holds the rows, read in as many parts, and h5py sees the same."""
    rows, whole = content(count, seed)
    file = CheckpointFile(path)
    assert file.about == ABOUT and file.count == count and np.signbit(file.about["zero"])
    assert file.rows == {name: (a.dtype, a.shape[1:]) for name, a in rows.items()}
    assert file.whole == {name: (a.dtype, a.shape) for name, a in whole.items()}
    bounds = [part * count // parts for part in range(parts + 1)]
    for part in range(parts):
        file.verify(part, parts)
        for name, array in rows.items():
            wanted = array[bounds[part] : bounds[part + 1]]
            found = file.read(name, *bounds[part : part + 2])
            assert (found.dtype, found.shape) == (wanted.dtype, wanted.shape)
            assert found.tobytes() == wanted.tobytes()
    for name, array in whole.items():
        assert file.read_whole(name).tobytes() == array.tobytes()
        assert file.read_whole(name).shape == array.shape
    with h5py.File(path) as hdf5:
        assert set(hdf5) == {*rows, *whole} and hdf5.userblock_size >= 512
        for name, array in (rows | whole).items():
            assert hdf5[name].shape == array.shape and hdf5[name].dtype == array.dtype
            assert hdf5[name][()].tobytes() == array.tobytes()


COUNTS = (0, 1, 2, 777)


@pytest.mark.parametrize("ranks", [2, 3])
def test_what_ranks_write_any_number_of_them_reads(tmp_path, mpirun, ranks):
    job = mpirun(ranks, [__file__, "write", tmp_path], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    for count in COUNTS:
        for way in ("parallel", "streamed"):
            check_content(tmp_path / f"{way}-{count}.h5", count, parts=ranks % 3 + 1)
    assert len(list(tmp_path.iterdir())) == 2 * len(COUNTS)


@pytest.mark.parametrize("count", [*COUNTS, 100_000])
def test_one_rank_writes_without_mpi(tmp_path, count, monkeypatch):
    monkeypatch.setattr(checkpointwriter, "_PIECE", 1 << 18)
    monkeypatch.setattr(framefile, "_BLOCK", 1 << 16)
    write_on(Serial(), tmp_path / "file.h5", count)
    for parts in (1, 2, 3, 40):
        check_content(tmp_path / "file.h5", count, parts)
    assert [path.name for path in tmp_path.iterdir()] == ["file.h5"]


def test_parts_are_of_about_equal_size(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpointwriter, "_PIECE", 1 << 16)
    monkeypatch.setattr(framefile, "_BLOCK", 1 << 14)
    write_on(Serial(), tmp_path / "file.h5", 50_000)
    file, read = CheckpointFile(tmp_path / "file.h5"), []
    preadv = os.preadv
    monkeypatch.setattr(os, "preadv", lambda *args: read.append(preadv(*args)) or read[-1])
    sums = []
    for part in range(7):
        read.clear()
        file.verify(part, 7)
        sums.append(sum(read))
    assert sum(sums) == file.size - file._header.begin
    assert max(sums) - min(sums) < 1 << 17


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A small file, its bytes, and where to put a changed one."""
    folder = tmp_path_factory.mktemp("small")
    write_on(Serial(), folder / "file.h5", 12)
    return (folder / "file.h5").read_bytes(), folder / "changed.h5"


def refused(small, data):
    """Whether the file is refused with these bytes; anything but a refusal is an error."""
    path = small[1]
    path.unlink(missing_ok=True)  # faster than to write over it
    path.write_bytes(data)
    return is_refused(path)


def is_refused(path):
    try:
        file = CheckpointFile(path)
        for part in range(3):
            file.verify(part, 3)
    except DamagedError as error:
        assert len(str(error)) < 200 and str(error).isprintable(), str(error)
        return True
    return False


def test_every_byte_counts(small):
    data, path = small
    assert not refused(small, data)
    bits = np.random.default_rng(2).integers(8, size=len(data))
    with open(path, "r+b", buffering=0) as stream:
        for place, bit in enumerate(bits):
            os.pwrite(stream.fileno(), bytes([data[place] ^ 1 << bit]), place)
            assert is_refused(path), (place, bit)
            os.pwrite(stream.fileno(), data[place : place + 1], place)
    assert not is_refused(path)


@settings(derandomize=True, max_examples=150, deadline=None, database=None)
@given(st.data())
def test_any_damage_is_found(small, data):
    whole = small[0]
    at = data.draw(st.integers(0, len(whole)), "at")
    kind = data.draw(st.sampled_from(["flip", "cut", "insert", "delete", "zero", "swap"]), "kind")
    length = data.draw(st.integers(1, 2000), "length")
    changed = bytearray(whole)
    if kind == "flip":
        bit = data.draw(st.integers(0, 8 * len(whole) - 1))
        changed[bit // 8] ^= 1 << bit % 8
    elif kind == "cut":
        del changed[at:]
    elif kind == "insert":
        changed[at:at] = data.draw(st.binary(min_size=1, max_size=50))
    elif kind == "delete":
        del changed[at : at + length]
    elif kind == "zero":
        changed[at : at + length] = bytes(len(changed[at : at + length]))
    else:
        other = data.draw(st.integers(0, len(whole)), "other")
        changed[at : at + 16], changed[other : other + 16] = (
            changed[other : other + 16],
            changed[at : at + 16],
        )
    assert refused(small, changed) == (changed != whole)


def test_300_damaged_files(small):
    """Random stretches overwritten, several at once, and cut: refused, and never anything else."""
    random = np.random.default_rng(4)
    for _ in range(300):
        changed = bytearray(small[0])
        for _ in range(random.integers(1, 4)):
            # Half of them where the header is.
            at = random.integers(len(changed) if random.integers(2) else 2048)
            stretch = random.bytes(random.integers(1, 300))
            changed[at : at + len(stretch)] = stretch
        if random.integers(3) == 0:
            del changed[random.integers(len(changed)) :]
        assert refused(small, changed) == (changed != small[0])


def test_rows_that_are_not_there(tmp_path):
    write_on(Serial(), tmp_path / "file.h5", 5)
    file = CheckpointFile(tmp_path / "file.h5")
    for name, first, last in [("x", 0, 6), ("x", -1, 2), ("x", 3, 2), ("y", 0, 1), ("work", 0, 1)]:
        with pytest.raises(DamagedError, match=f"no rows {first} to {last} of {name}"):
            file.read(name, first, last)
    with pytest.raises(DamagedError, match="has no x"):
        file.read_whole("x")
    assert file.read("x", 5, 5).shape == (0, 3)
    os.truncate(tmp_path / "file.h5", 4096)  # under an open file, as a full quota may do
    with pytest.raises(DamagedError, match="ends before its data"):
        file.read("F", 0, 5)
    with pytest.raises(DamagedError):
        file.verify(0, 1)


def test_what_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "link").symlink_to(tmp_path / "nothing")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "empty").touch()
    (tmp_path / "text").write_text("a: 1\n" * 100)
    for name, why in {
        ".": "a folder",
        "fifo": "no regular file",
        "link": "No such file",
        "loop": "Too many levels",
        "empty": "empty",
        "text": "does not begin like",
        "/dev/zero": "no regular file",
        "x\0": "no name of a file",
        "x" * 999: "name too long",
        "text/x": "Not a directory",
    }.items():
        with pytest.raises(DamagedError, match=why):
            CheckpointFile(tmp_path / name)


@pytest.fixture
def disk(tmp_path):
    with small_disk(tmp_path / "disk") as place:
        yield place


def test_any_amount_of_free_space_is_handled(disk):
    path = disk / "file.h5"
    write_on(Serial(), path, 400)
    before = path.read_bytes()
    for free in range(0, len(before), 8192):
        ballast = fill_up(disk, but=free)
        with pytest.raises(RunError, match=r"file\.h5: No space left on device"):
            write_on(Serial(), path, 400, seed=6)
        ballast.unlink()
        assert path.read_bytes() == before and len(list(disk.iterdir())) == 1
    write_on(Serial(), path, 400, seed=6)
    check_content(path, 400, seed=6)


@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks_agree_on_what_goes_wrong(disk, mpirun, ranks):
    """A full disk, and failures of one rank alone; the older file stays, and nothing else."""
    job = mpirun(ranks, [__file__, "fail", disk], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    lines = sorted(job.stdout.splitlines())
    causes = ["No space left on device", *FAULTS.values()]
    for way in ("parallel", "streamed"):
        for number, cause in enumerate(causes):
            told = [line for line in lines if line.startswith(f"{way} {number}:")]
            assert len(told) == ranks and len(set(told)) == 1, told
            assert cause in told[0] and ".h5" in told[0], told[0]
    check_content(disk / "file.h5", 300)
    assert [path.name for path in disk.iterdir()] == ["file.h5"]


def test_a_read_only_file_system_and_a_folder_without_permission(disk):
    place = disk / "closed"
    place.mkdir(mode=0o500)
    (disk / "shut.h5").touch(mode=0o000)
    # Root may do all that root is not asked to do without.
    drop = ["--inh-caps=-all", "--bounding-set=-dac_override,-dac_read_search"]
    words = ["setpriv", *drop, sys.executable, __file__, "permission", disk]
    job = subprocess.run(words, capture_output=True, text=True, env=os.environ | HERE, timeout=60)
    assert job.returncode == 0, job.stderr
    first, second = job.stdout.splitlines()
    assert "closed/file.h5: Permission denied" in first
    assert second == "it cannot be read: Permission denied"
    assert not list(place.iterdir())
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    with pytest.raises(RunError, match=r"file\.h5: Read-only file system"):
        write_on(Serial(), disk / "file.h5", 10)


class Rows(dict):
    """Rows that do something when they are asked for the second time, when it is their turn."""

    def __init__(self, rows, action):
        super().__init__(rows)
        self.action, self.asked = action, 0

    def __getitem__(self, name):
        self.asked += name == "x"
        if name == "x" and self.asked == 2:
            self.action()
        return super().__getitem__(name)


# What goes wrong on one rank alone, and what all then say.
FAULTS = {
    "memory": "out of memory",
    "shape": "do not fit each other",
    "put": "Input/output error",
    "check": "reads back different",
    "about": "not JSON compliant",
    "type": "holds numbers of type <f4",
    "gone": "No such file or directory",
    "header": "its checksums do not cover it",
}


def fail(comm, disk, way, fault):
    """Write a file while one rank, the last where that can be, has a fault."""
    rows, whole = content(30 if comm.rank else 0)
    path, about = disk / f"{fault}.h5", dict(ABOUT)
    alone = comm.rank == (0 if fault == "put" and way == "streamed" else comm.size - 1)
    put, patch = FrameFile._put, nullcontext()

    def broken_put(self, *args):
        put(self, *args)
        self._keep(OSError(5, "the text does not matter"))

    if fault == "memory" and alone:
        rows = Rows(rows, mock.Mock(side_effect=MemoryError))
    elif fault == "shape" and alone:
        rows["x"] = rows["x"][:, :2]
    elif fault == "put" and alone:
        patch = mock.patch.object(FrameFile, "_put", broken_put)
    elif fault == "check" and alone:
        patch = mock.patch.object(FrameFile, "check", lambda self: "it reads back different")
    elif fault == "header" and alone:
        twice = [framefile.Written(9000, 80, 0)] * 2
        patch = mock.patch.object(FrameFile, "check", lambda self: self.written.extend(twice))
    elif fault == "about":
        about["time"] = float("nan")
    elif fault == "type":
        rows["x"] = rows["x"].astype(np.float32)
    elif fault == "gone":
        path = disk / "sub" / "file.h5"
        if comm.rank == 0:
            path.parent.mkdir()
            rows = Rows(rows, lambda: shutil.rmtree(path.parent))
    with patch:
        write(path, comm, way == "parallel", about, rows, whole if comm.rank == 0 else {})


def main(command, folder):
    comm = world()
    if command == "write":
        for count in COUNTS:
            for way in ("parallel", "streamed"):
                framefile._BLOCK = checkpointwriter._PIECE = 4 << 20 if count < 3 else 1000
                write_on(comm, folder / f"{way}-{count}.h5", count, way == "parallel")
    elif command == "fail":
        for way in ("parallel", "streamed"):
            write_on(comm, folder / "file.h5", 300, way == "parallel")
            tries = [lambda way=way: write_on(comm, folder / "file.h5", 20_000, way == "parallel")]
            tries += [lambda way=way, fault=f: fail(comm, folder, way, fault) for f in FAULTS]
            for number, attempt in enumerate(tries):
                try:
                    attempt()
                except RunError as error:
                    print(f"{way} {number}: {error}\n", end="", flush=True)
    else:
        try:
            write_on(comm, folder / "closed" / "file.h5", 10)
        except RunError as error:
            print(error)
        try:
            CheckpointFile(folder / "shut.h5")
        except DamagedError as error:
            print(error)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
