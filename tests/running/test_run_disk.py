"""Disks that fill up, folders without permission or deleted while a run goes on: whole runs."""

import json
import re
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest
from particle_source import small_disk
from processes import clean_env
from tiers import wide
from two_blocks import CASE

import pgimp
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.physics.derived import DERIVED, FITTED
from pgimp.physics.fields import BY_RANKS, OPTIONAL
from pgimp.running.checkpoints import present

ALL = [name for name in OPTIONAL if name not in {*BY_RANKS, *DERIVED, *FITTED, "unwrapped"}]
#: What fills the disk, and the file that the message must name.
FILLED_BY = {
    "frames": (
        f"output={{every: {{steps: 1}}, at: [], fields: [{', '.join(ALL)}]}}",
        "checkpoint={every: {steps: 4}, keep: 3}",
        "time.end=0.6",
        r"frames/particles-\d{6}\.h5",
    ),
    "checkpoints": (
        "output={every: {steps: 60}, at: []}",
        "checkpoint={every: {steps: 1}, keep: 1000}",
        "time.end=0.6",
        r"checkpoints/step-\d{9}\.h5",
    ),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """``whole[kind]`` is the run on a disk with room."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "blocks.yaml").write_text(CASE)
    return {
        kind: pgimp.run(
            folder / "blocks.yaml", output=folder / kind, overrides=[*settings], quiet=True
        )
        for kind, (*settings, _) in FILLED_BY.items()
    }


@pytest.mark.parametrize("kind", FILLED_BY)
@pytest.mark.parametrize("ranks", [wide(1), 3])
def test_a_full_disk_ends_the_run_and_room_lets_it_go_on(
    tmp_path, mpirun, python, whole, kind, ranks
):
    *settings, name = FILLED_BY[kind]
    case = tmp_path / "blocks.yaml"
    case.write_text(CASE)

    def start(*more):
        words = ["-m", "pgimp", case, "-o", disk / "out", "--quiet", *more]
        words += [f"--set={setting}" for setting in settings]
        return python(words) if ranks == 1 else mpirun(ranks, words)

    with small_disk(tmp_path / "disk") as disk:
        job = start()
        assert job.returncode == 1, job.stderr
        assert len(re.findall("No space left on device", job.stderr)) == 1
        assert re.search(name, job.stderr) and "Traceback" not in job.stderr
        assert not list((disk / "out").rglob("*.part"))
        run = pgimp.open(disk / "out")
        assert run.state == "failed" and "No space left" in run.info["message"]
        assert len(run) > (5 if kind == "frames" else 0)
        for frame, same in zip(run, whole[kind], strict=False):
            assert frame.path.read_bytes() == same.path.read_bytes()
        paths = present(disk / "out" / "checkpoints")
        assert len(paths) == 3 if kind == "frames" else len(paths) > 10
        for path in paths:
            CheckpointFile(path).verify(0, 1)
        latest = int(re.search(r"the checkpoint of step (\d+) is intact", job.stderr)[1])
        assert paths[0].name == f"step-{latest:09d}.h5"

        subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
        job = start("--resume")
        assert job.returncode == 0, job.stderr
        assert pgimp.open(disk / "out").info["resumed_from"] == latest
        assert len(run) == len(whole[kind])
        for frame, same in zip(run, whole[kind], strict=True):
            assert frame.path.read_bytes() == same.path.read_bytes()
        history = (disk / "out" / "history.csv").read_bytes()
        assert history == (whole[kind].path / "history.csv").read_bytes()


#: pgimp by a user without rights, once all is read that only root may read.
AS_NOBODY = """\
import os, sys
import numba, h5py, pgimp.commands.run, pgimp.running.running, pgimp.running.resume
os.setgroups([]), os.setgid(65534), os.setuid(65534)
from pgimp.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("words", [[], ["--resume"], ["--overwrite"]])
def test_a_folder_without_permission_is_named(tmp_path_factory, whole, python, words):
    folder = tmp_path_factory.mktemp("closed")
    for parent in (folder, *folder.parents[:2]):
        parent.chmod(0o755)
    (folder / "blocks.yaml").write_text(CASE)
    (folder / "as_nobody.py").write_text(AS_NOBODY)
    output = folder / "out"
    if words:
        shutil.copytree(whole["frames"].path, output)
    else:
        output.mkdir()
    before = {path: path.read_bytes() for path in output.rglob("*") if path.is_file()}
    job = python(["as_nobody.py", "blocks.yaml", "-o", output, *words], cwd=folder)
    assert job.returncode == 1, job.stdout + job.stderr
    assert f"cannot use the run directory {output}: Permission denied" in job.stderr
    assert "change the permissions" in job.stderr and "Traceback" not in job.stderr
    assert {path: path.read_bytes() for path in output.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("ranks", [wide(1), 2])
def test_a_run_directory_deleted_under_way_ends_the_run(tmp_path, ranks):
    (tmp_path / "blocks.yaml").write_text(CASE)
    settings = ["time.end=200000.0", "output={every: {steps: 200}}"]
    words = [sys.executable, "-m", "pgimp", "blocks.yaml", "-o", "out", "--quiet"]
    words += [f"--set={setting}" for setting in settings]
    if ranks > 1:
        words = ["mpirun", "-q", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *words]
    process = subprocess.Popen(
        words, cwd=tmp_path, env=clean_env(), stderr=subprocess.PIPE, text=True
    )
    try:
        patience = time.monotonic() + 60.0
        while not (tmp_path / "out" / "frames" / "particles-000001.h5").exists():
            assert process.poll() is None and time.monotonic() < patience
            time.sleep(0.02)
        (tmp_path / "out").rename(tmp_path / "gone")
        _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 1 and said.count("No such file or directory") == 1, said
    assert re.search(r"out/(frames|checkpoints|history)", said) and "Traceback" not in said
    assert not (tmp_path / "out").exists()
    for frame in pgimp.open(tmp_path / "gone"):
        assert np.isfinite(frame["stress"]).all()


def test_what_run_json_says_of_a_start_that_a_disk_ended(tmp_path):
    (tmp_path / "blocks.yaml").write_text(CASE)
    with small_disk(tmp_path / "disk") as disk:
        (disk / "ballast").write_bytes(bytes(2**20 - 2**16))
        with pytest.raises(pgimp.errors.RunError, match="No space left"):
            pgimp.run(tmp_path / "blocks.yaml", output=disk / "out", quiet=True)
        starts = json.loads((disk / "out" / "run.json").read_text())["starts"]
        assert [start["state"] for start in starts] == ["failed"]
