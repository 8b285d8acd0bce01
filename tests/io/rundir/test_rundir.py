"""The run directory: what is replaced, what is not, and who may write."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from mentioned import mentions
from particle_source import fill_up, small_disk

from pgimp.errors import RunError, UsageError
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import Serial

START = {"state": "running", "began": "now", "steps": 0}


def make(path):
    """Make a directory with all that a failed run leaves."""
    directory = RunDirectory(path, Serial())
    directory.prepare({"case.yaml": b"resolved", "input.yaml": b"verbatim"}, START)
    (path / "history.csv").write_text("time\n")
    (path / "log.txt").write_text("log\n")
    (path / "frames" / "particles-000000.h5").write_text("frame")
    (path / "frames" / ".particles-000001.h5.part").write_text("half a frame")
    (path / "checkpoints" / "step-000000005.h5").write_text("checkpoint")
    (path / "checkpoints" / "step-000000006.h5.damaged").write_text("found damaged")
    (path / "checkpoints" / ".step-000000007.h5.part").write_text("half a checkpoint")
    (path / "failure").mkdir()
    (path / "failure" / "report.txt").write_text("report")
    directory.record_failure("failed", 7, 0.5, "it broke")
    directory.release()


def test_overwrite_deletes_only_what_a_run_made(tmp_path):
    path = tmp_path / "out"
    make(path)
    foreign = ["notes.txt", "frames/mine.h5", "frames/particles-1.h5", "case.yaml.bak"]
    foreign += ["checkpoints/step-5.h5", "failure/notes.txt"]
    for name in foreign:
        (path / name).write_text("mine")
    with pytest.raises(UsageError, match=r"holds a run \(failed.*7 steps(.|\n)*--overwrite"):
        RunDirectory(path, Serial())
    directory = RunDirectory(path, Serial(), overwrite=True)
    assert (path / "frames" / "particles-000000.h5").exists()  # until the new run is sure to start
    directory.prepare({"case.yaml": b"new"}, START)
    directory.release()
    there = {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}
    assert there == {*foreign, "run.json", "case.yaml"}
    assert {(path / name).read_text() for name in foreign} == {"mine"}


def test_resuming_deletes_only_what_was_half_written(tmp_path):
    path = tmp_path / "out"
    make(path)
    before = {file for file in path.rglob("*") if file.is_file()}
    directory = RunDirectory(path, Serial(), resume=True)
    assert (directory.before["state"], directory.before["steps"]) == ("failed", 7)
    directory.prepare({"case.yaml": b"new"}, START, resume=True)
    directory.release()
    gone = before - {file for file in path.rglob("*") if file.is_file()}
    names = {".failed", ".particles-000001.h5.part", ".step-000000007.h5.part", "report.txt"}
    assert {file.name for file in gone} == names
    first, second = json.loads((path / "run.json").read_text())["starts"]
    assert (first["state"], first["message"]) == ("failed", "it broke")
    assert second["state"] == "running"


@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("name", ["case.yaml", "run.json", "frames", "log.txt"])
def test_files_that_are_no_runs_are_left_alone(tmp_path, name, overwrite):
    (tmp_path / name).write_text("mine")
    with pytest.raises(UsageError, match=f"has a {name}, but no run"):
        RunDirectory(tmp_path, Serial(), overwrite)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "is_folder"),
    [
        ("frames/grid-000004.h5", True),
        ("checkpoints/.step-000000007.h5.part", True),
        ("failure/particles.h5", True),
        ("grid.xdmf", True),
        ("grid.vtkhdf", True),
        ("history.csv", True),
        (".failed", True),
        ("frames", False),
        ("checkpoints", False),
    ],
)
def test_what_is_in_the_way_is_found_before_anything_is_deleted(tmp_path, name, is_folder):
    path = tmp_path / "out"
    make(path)
    odd = path / name
    if is_folder:
        odd.unlink(missing_ok=True)
        odd.mkdir()
        (odd / "mine").write_text("mine")
    else:
        shutil.rmtree(odd)
        odd.write_text("mine")
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    with pytest.raises(
        UsageError, match=rf"{re.escape(str(odd))} is in the way .*\n.*move it away"
    ):
        RunDirectory(path, Serial(), overwrite=True)
    assert {file: file.read_bytes() for file in path.rglob("*") if file.is_file()} == before
    shutil.move(odd, tmp_path / "moved")
    directory = RunDirectory(path, Serial(), overwrite=True)
    # What gets in the way while the simulation is set up is found as well.
    (path / "log.txt").unlink()
    (path / "log.txt").mkdir()
    with pytest.raises(UsageError, match=r"log\.txt is in the way"):
        directory.prepare({"case.yaml": b"new"}, START)
    assert (path / "case.yaml").read_bytes() == b"resolved"
    directory.release()


def test_a_failure_is_noted_once(tmp_path):
    make(tmp_path / "out")
    directory = RunDirectory(tmp_path / "out", Serial(), overwrite=True)
    directory.prepare({}, START)
    directory.record_failure("failed", 8, 0.25, "particle 5 left the domain")
    directory.record_failure("failed", 9, 0.75, "another rank")
    directory.release()
    start = json.loads((tmp_path / "out" / "run.json").read_text())["starts"][-1]
    assert (start["state"], start["steps"], start["time"]) == ("failed", 8, 0.25)
    log = (tmp_path / "out" / "log.txt").read_text()
    (line,) = log.splitlines()
    mentions(line, "failed", "step 8", "0.25", "particle 5 left the domain")


def test_one_run_at_a_time(tmp_path):
    holder = RunDirectory(tmp_path / "out", Serial())
    code = (
        "import sys, pathlib; from pgimp.io.rundir.rundir import RunDirectory\n"
        "from pgimp.mpi.comm import Serial\n"
        "RunDirectory(pathlib.Path(sys.argv[1]), Serial(), True)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "out")]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}

    def attempt():
        return subprocess.run(command, env=environment, capture_output=True, text=True).stderr

    assert f"process {os.getpid()} on " in attempt()
    holder.release()
    assert not (tmp_path / "out").exists()  # made, and left empty
    assert attempt() == ""
    # That process went without a release, as if killed: its lock is gone, its file is not.
    assert (tmp_path / "out" / ".lock").exists()
    RunDirectory(tmp_path / "out", Serial()).release()


def test_places_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="is a file"):
        RunDirectory(tmp_path / "file", Serial())
    with pytest.raises(UsageError, match="Not a directory"):
        RunDirectory(tmp_path / "file" / "out", Serial())
    with small_disk(tmp_path / "disk") as disk:
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        place = re.escape("Read-only file system. Choose another place with -o")
        with pytest.raises(RunError, match=place):
            RunDirectory(disk / "out", Serial())
        subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
        fill_up(disk)
        with pytest.raises(RunError, match="No space left"):
            RunDirectory(disk / "out", Serial())
        assert not (disk / "out").exists()
