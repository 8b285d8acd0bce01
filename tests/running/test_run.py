"""Whole runs, as people start them: what they leave, how they end, how they are read again."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from processes import clean_env
from tiers import wide
from two_blocks import CASE

import pgimp
from pgimp.errors import RunError, UsageError

pytestmark = pytest.mark.slow(75)

TIMES = [0.0, 0.3, 0.5, 0.6, 0.9, 1.0, 1.2, 1.5, 1.8, 2.0]
PARTICLES = 72


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the case, in which runs are started."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "blocks.yaml").write_text(CASE)
    return folder


@pytest.fixture(scope="module")
def start(folder, mpirun, python):
    """``start(ranks, words)`` runs pgimp in that folder, on no launcher for one rank."""

    def start(ranks, *words):
        words = ["-m", "pgimp", *words]
        return python(words, cwd=folder) if ranks == 1 else mpirun(ranks, words, cwd=folder)

    return start


@pytest.fixture(scope="module")
def done(folder, start):
    """The run of the case on one rank."""
    job = start(1, "blocks.yaml")
    assert job.returncode == 0, job.stderr
    return folder / "blocks.out", job


def test_what_a_run_leaves(done, folder):
    directory, job = done
    files = "case.yaml history.csv input.yaml log.txt particles.xdmf run.json".split()
    left = {path.name for path in directory.iterdir()}
    assert left == {*files, "particles.vtkhdf", "checkpoints", "frames"}
    assert (directory / "input.yaml").read_bytes() == (folder / "blocks.yaml").read_bytes()
    log = (directory / "log.txt").read_text()
    assert log.startswith(job.stdout)
    assert "Two soft blocks" in job.stdout and "72 particles in 2D on 1 rank" in job.stdout
    assert "paraview blocks.out/particles.vtkhdf (before 5.12: particles.xdmf)" in job.stdout
    phases = [line.split()[0] for line in log.removeprefix(job.stdout).splitlines() if line]
    assert {"P2G", "G2P", "frames", "history", "other", "total"} <= set(phases)
    (entry,) = json.loads((directory / "run.json").read_text())["starts"]
    assert (entry["state"], entry["steps"], entry["time"]) == ("done", 200, 2.0)
    assert entry["ranks"] == 1 and list(entry["hosts"].values()) == [1]
    assert entry["versions"]["numpy"] == np.__version__
    assert "blocks.yaml" in entry["command"]


def test_reading_a_run(done):
    run = pgimp.open(done[0])
    np.testing.assert_allclose(run.times, TIMES, rtol=1e-12)
    assert run.state == "done" and run.case.title == "Two soft blocks"
    assert run.frame(-1).time == 2.0 and run.frame(-1).step == 200
    assert run.frame(0).bodies == ["left", "right"]
    assert run.frame(0)["stress"].shape == (PARTICLES, 6)
    history = run.history
    assert list(history["step"]) == [0, 30, 60, 90, 120, 150, 180, 200]
    np.testing.assert_allclose(history["mass"], 18.0, rtol=1e-13)
    path = run.follow(40)
    assert path["position"].shape == (len(TIMES), 3)
    for frame, position, moved in zip(run, path["position"], path["displacement"], strict=True):
        np.testing.assert_array_equal(frame["position"][40], position)
        np.testing.assert_allclose(position - path["position"][0], moved, atol=1e-14)
    for error, message, attempt in (
        (KeyError, "no particle 72", lambda: run.follow(PARTICLES)),
        (IndexError, "no frame 10: it has 10", lambda: run.frame(10)),
        (
            KeyError,
            "no field 'pressure' in particles-000000.h5; there are",
            lambda: run.frame(0)["pressure"],
        ),
        (UsageError, "no run directory", lambda: pgimp.open(done[0] / "frames")),
    ):
        with pytest.raises(error, match=message):
            attempt()


def test_frames_hold_the_state_of_the_simulation(done):
    """The same case, driven step by step from Python, has the same particles."""
    from pgimp.mpi.comm import Serial
    from pgimp.solver.simulation import Simulation

    run = pgimp.open(done[0])
    sim = Simulation(run.case, Serial())
    while not sim.finished:
        sim.advance()
    rows = sim.live()
    order = rows[np.argsort(sim.particles.id[rows])]
    last = run.frame(-1)
    np.testing.assert_array_equal(last["position"][:, :2], sim.particles.x[order])
    np.testing.assert_array_equal(last["stress"][:, :4], sim.particles.sigma[order])
    np.testing.assert_array_equal(last["volume"], sim.particles.V[order])


def test_the_frame_before_steps_become_too_short_is_kept(tmp_path, monkeypatch):
    """Also where it was still on its way to the disk, as that of the start is here."""
    from pgimp.solver.simulation import Simulation

    advance = Simulation.advance

    def disturbed(sim, complete=True):
        sim.rate = 1e300
        advance(sim, complete)

    monkeypatch.setattr(Simulation, "advance", disturbed)
    (tmp_path / "blocks.yaml").write_text(CASE)
    with pytest.raises(RunError, match=r"blown up\n.*\n.*holds 1 frame, to t = 0"):
        pgimp.run(
            tmp_path / "blocks.yaml", output=tmp_path / "out", quiet=True,
            overrides=["time.step={courant: 0.3}"],
        )  # fmt: skip
    run = pgimp.open(tmp_path / "out")
    assert (run.state, run.info["steps"], list(run.times)) == ("failed", 0, [0.0])
    assert not list((tmp_path / "out").rglob("*.part"))


@pytest.mark.parametrize("ranks", [wide(2), 3])
def test_other_numbers_of_ranks_leave_the_same(done, start, ranks):
    job = start(ranks, "blocks.yaml", "-o", f"ranks-{ranks}", "--quiet")
    assert (job.returncode, job.stdout, job.stderr) == (0, "", "")
    same = start(1, "compare", "blocks.out", f"ranks-{ranks}")
    assert same.returncode == 0 and "bit for bit: 10 frames of 72 particles" in same.stdout


def test_the_resolved_case_runs_to_the_same(done, start):
    assert start(1, "blocks.out/case.yaml", "-o", "again", "--quiet").returncode == 0
    same = start(1, "compare", "blocks.out", "again")
    assert same.returncode == 0, same.stdout


def test_output_does_not_change_the_particles(done, start, folder):
    settings = ["output={every: {steps: 7}, fields: [stress]}", "history={every: 0.011}"]
    words = [f"--set={setting}" for setting in settings]
    assert start(1, "blocks.yaml", "-o", "other-output", "--quiet", *words).returncode == 0
    run, other = pgimp.open(done[0]), pgimp.open(folder / "other-output")
    assert [frame.step for frame in other] == [*range(0, 200, 7), 200]
    assert len(other.history) == 1 + int(2.0 / 0.011)
    for field in ("position", "volume", "stress"):
        assert run.frame(-1)[field].tobytes() == other.frame(-1)[field].tobytes()


EVERY = ["--set", "output.at=[]"]
FAST = ["--set", "bodies.right.velocity=[9.0, 0.0]", "--set", "boundaries={}"]


@pytest.mark.parametrize("ranks", [wide(1), 3])
def test_a_failed_run_says_why_and_keeps_what_it_has(start, folder, ranks):
    name = f"fails-{ranks}"
    job = start(ranks, "blocks.yaml", "-o", name, *FAST)
    assert job.returncode == 1
    assert len(re.findall("left the domain through x-max", job.stderr)) == 1
    assert f"{name} holds 2 frames, to t = 0.3, and history.csv" in job.stderr
    run = pgimp.open(folder / name)
    assert run.state == "failed" and "left the domain" in run.info["message"]
    assert 30 <= run.info["steps"] < 50
    assert "failed at step" in (folder / name / "log.txt").read_text()
    np.testing.assert_allclose(run.times, [0.0, 0.3], rtol=1e-12)
    assert list(run.history["step"]) == [0, 30]


@pytest.mark.parametrize("ranks", [wide(1), 2])
def test_a_run_is_replaced_only_on_request(done, start, ranks):
    before = (done[0] / "run.json").read_bytes()
    job = start(ranks, "blocks.yaml")
    assert job.returncode == 2 and len(re.findall("holds a run [(]done", job.stderr)) == 1
    assert "--overwrite" in job.stderr
    assert (done[0] / "run.json").read_bytes() == before


@pytest.mark.parametrize("ranks", [1, wide(2)])
def test_a_wrong_case_leaves_no_directory(start, folder, ranks):
    job = start(ranks, "blocks.yaml", "-o", "wrong", "--set", "time={end: 10.0, step: 1.0}", *EVERY)
    assert job.returncode == 2 and "Courant number" in job.stderr
    assert "Traceback" not in job.stderr and not (folder / "wrong").exists()


def launch(folder, *words):
    """Start a run and go on."""
    return subprocess.Popen(
        [sys.executable, "-m", "pgimp", *words],
        cwd=folder,
        env=clean_env(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_run_outlives_its_reader(folder):
    """As in ``pgimp case.yaml | head``, or when a terminal is closed."""
    process = launch(folder, "blocks.yaml", "-o", "unheard")
    process.stdout.close()
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert pgimp.open(folder / "unheard").state == "done"
    assert "done: t = 2" in (folder / "unheard" / "log.txt").read_text()


@pytest.fixture
def endless(folder):
    """A run that would go on for hours, once its first frames are there."""
    settings = ["time.end=200000.0", "output.every={steps: 50}", "output.at=[]"]
    words = [f"--set={setting}" for setting in settings]
    shutil.rmtree(folder / "endless", ignore_errors=True)
    process = launch(folder, "blocks.yaml", "-o", "endless", *words)
    directory = folder / "endless"
    patience = time.monotonic() + 60.0
    while not (directory / "frames" / "particles-000004.h5").exists():
        assert process.poll() is None and time.monotonic() < patience
        time.sleep(0.05)
    yield process, directory
    process.kill()
    process.communicate()


def check_whole(run, count):
    frames = run.frames  # there may be more of them soon
    assert len(frames) >= count
    assert [frame.step for frame in frames] == list(range(0, 50 * len(frames), 50))
    assert all(np.isfinite(frame["stress"]).all() for frame in run)
    assert len(run.history) >= 50 * (len(run) - 1) // 30


def test_a_run_can_be_read_while_it_goes_on_and_after_it_was_killed(endless, start):
    process, directory = endless
    run = pgimp.open(directory)
    check_whole(run, 5)
    assert run.state == "running"
    seen = len(run)
    other = start(1, "blocks.yaml", "-o", "endless", "--overwrite")
    assert other.returncode == 2 and f"process {process.pid} on " in other.stderr
    process.kill()
    process.wait()
    check_whole(run, seen + 1)
    names = re.findall(r"particles-\d{6}\.h5", (directory / "particles.xdmf").read_text())
    assert len(run) - 1 <= len(set(names)) <= len(run)
    assert start(1, "compare", "endless", "endless").returncode == 0


def test_ctrl_c_leaves_valid_files_and_a_checkpoint(endless):
    process, directory = endless
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 75 and "Traceback" not in err
    run = pgimp.open(directory)
    assert run.state == "stopped"
    check_whole(run, 5)
    assert not list(directory.rglob("*.part"))


def test_running_from_python(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    run = pgimp.run("blocks.yaml", output="python", overrides=["time.end=0.1", "output.at=[]"])
    assert run.state == "done" and run.frame(-1).step == 10
    told = capsys.readouterr().out
    assert "done: t = 0.1 after 10 steps" in told
    size = sum(path.stat().st_size for path in (folder / "python").rglob("*.h5"))
    assert re.search(rf"; output took \d+ % \({size / 1e3:.3g} kB at \S+ [kM]B/s\)\n", told)
    case = run.case
    with pytest.raises(UsageError, match="needs output="):
        pgimp.run(case)
    with pytest.raises(UsageError, match="holds a run"):
        pgimp.run(case, output="python")
    again = pgimp.run(case, output="python", overwrite=True, quiet=True)
    assert again.frame(-1)["position"].shape == (PARTICLES, 3)
    assert not (folder / "python" / "input.yaml").exists()
