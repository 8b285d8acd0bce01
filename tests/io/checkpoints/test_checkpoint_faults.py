"""A disk that fills up, ranks that fail alone: an error on every rank, the older file as it was."""

import os
import shutil
import subprocess
import sys
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from checkpoint_source import ABOUT, check_content, content, write_on
from mentioned import mentions
from particle_source import fill_up, small_disk
from processes import HERE
from tiers import wide

from pgimp.errors import RunError
from pgimp.io.checkpoints.checkpointfile import CheckpointFile, DamagedError, write
from pgimp.mpi.comm import Serial, world
from pgimp.storage import framefile
from pgimp.storage.framefile import FrameFile


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


@pytest.mark.parametrize("ranks", [wide(2), 3])
def test_ranks_agree_on_what_goes_wrong(disk, mpirun, ranks):
    """A full disk, and failures of one rank alone; the older file stays, and nothing else."""
    job = mpirun(ranks, [__file__, "fail", disk], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    lines = sorted(job.stdout.splitlines())
    causes = ["No space left on device", *FAULTS.values()]
    for number, cause in enumerate(causes):
        told = [line for line in lines if line.startswith(f"{number}:")]
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
    mentions(second, "cannot be read", "Permission denied")
    assert not list(place.iterdir())
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    with pytest.raises(RunError, match=r"file\.h5: Read-only file system"):
        write_on(Serial(), disk / "file.h5", 10)


class Rows(dict):
    """Rows that do something when it is their turn."""

    def __init__(self, rows, action):
        super().__init__(rows)
        self.action = action

    def __getitem__(self, name):
        if name == "x":
            self.action()
        return super().__getitem__(name)


# What goes wrong on one rank alone, and what all then say.
FAULTS = {
    "shape": "do not fit each other",
    "put": "Input/output error",
    "lost": "are not those that were written there",
    "sync": "Input/output error",
    "about": "not JSON compliant",
    "type": "holds numbers of type <f4",
    "gone": "No such file or directory",
    "header": "its checksums do not cover it",
}


def fail(comm, disk, fault):
    """Write a file while one rank, the last where that can be, has a fault."""
    # Only a file of several blocks is written by several ranks.
    rows, whole = content((2000 if fault in ("put", "lost") else 30) if comm.rank else 0)
    path, about = disk / f"{fault}.h5", dict(ABOUT)
    alone = comm.rank == comm.size - 1
    patch = nullcontext()

    def broken(*_):
        raise OSError(5, "the text does not matter")

    if fault == "shape" and alone:
        rows["x"] = rows["x"][:, :2]
    elif fault == "put" and alone:
        patch = mock.patch.object(framefile, "put", broken)
    elif fault == "lost" and alone:
        patch = mock.patch.object(framefile, "put", lambda *_: None)
    elif fault == "sync" and alone:
        patch = mock.patch.object(os, "fdatasync", broken)
    elif fault == "header" and alone:
        twice = [framefile.Written(9000, 80, 0)] * 2

        def lying(self, *args):
            put_in(self, *args)
            self.written.extend(twice)

        put_in = FrameFile.write
        patch = mock.patch.object(FrameFile, "write", lying)
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
        write(path, comm, about, rows, whole if comm.rank == 0 else {})


def main(command, folder):
    comm = world()
    if command == "fail":
        write_on(comm, folder / "file.h5", 300)
        tries = [lambda: write_on(comm, folder / "file.h5", 20_000)]
        tries += [partial(fail, comm, folder, fault) for fault in FAULTS]
        for number, attempt in enumerate(tries):
            try:
                attempt()
            except RunError as error:
                print(f"{number}: {error}\n", end="", flush=True)
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
