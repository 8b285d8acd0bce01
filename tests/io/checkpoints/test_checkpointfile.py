"""Checkpoint files: what is written comes back, and nothing that is damaged is taken for whole."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from checkpoint_source import check_content, write_on
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import HERE
from tiers import wide

from pgimp.io.checkpoints import checkpointwriter
from pgimp.io.checkpoints.checkpointfile import CheckpointFile, DamagedError
from pgimp.mpi.comm import Serial, world
from pgimp.storage import framefile

COUNTS = (0, 1, 2, 777)


@pytest.mark.parametrize("ranks", [wide(2), 3])
def test_what_ranks_write_any_number_of_them_reads(tmp_path, mpirun, ranks):
    job = mpirun(ranks, [__file__, tmp_path], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    for count in COUNTS:
        check_content(tmp_path / f"{count}.h5", count, parts=ranks % 3 + 1)
    assert len(list(tmp_path.iterdir())) == len(COUNTS)


@pytest.mark.parametrize("count", [*COUNTS, 100_000])
def test_one_rank_writes_without_mpi(tmp_path, count, monkeypatch):
    monkeypatch.setattr(checkpointwriter, "_PIECE", 1 << 18)
    monkeypatch.setattr(framefile, "_ROWS", 1 << 11)
    write_on(Serial(), tmp_path / "file.h5", count)
    for parts in (1, 2, 3, 40):
        check_content(tmp_path / "file.h5", count, parts)
    assert [path.name for path in tmp_path.iterdir()] == ["file.h5"]


def test_parts_are_of_about_equal_size(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpointwriter, "_PIECE", 1 << 16)
    monkeypatch.setattr(framefile, "_ROWS", 1 << 9)
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
    bits[data.index(b"\x89HDF") + 20] = 1  # 0 is that of a file open for writing elsewhere
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


if __name__ == "__main__":
    comm = world()
    for count in COUNTS:
        framefile._ROWS, checkpointwriter._PIECE = (1 << 14, 4 << 20) if count < 3 else (40, 1000)
        write_on(comm, Path(sys.argv[1]) / f"{count}.h5", count)
