"""Batch scripts on a real Slurm of two nodes, both this machine: stopped, requeued, finished."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from processes import clean_env, run
from two_blocks import CASE

pytestmark = pytest.mark.slow(255)

ROOT = Path(__file__).resolve().parents[3]

# Particles and steps for about six seconds, and how long before the early signal the job comes.
FINE = ["--set=grid.cell=[0.05, 0.05]", f"--set=time.step={2.0 / 5000}"]
BEFORE = 5.0
# Other tests want the cores too.
SHARED = {"OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_mpi_yield_when_idle": "1"}

# In place of a run: waits for a signal the first time, is done the second.
STAND_IN = """#!/usr/bin/env python3
import os, signal, sys, time

[folder] = [word[len("--output="):] for word in sys.argv if word.startswith("--output=")]
came = []
signal.signal(signal.SIGUSR1, lambda *_: came.append(1))
rank = os.environ.get("OMPI_COMM_WORLD_RANK") or os.environ["SLURM_PROCID"]
if os.path.exists(f"{folder}/checkpoints/{rank}"):
    print("rank", rank, "is done", flush=True)
    os._exit(0)
print("rank", rank, "is up", flush=True)
while not came:
    time.sleep(0.01)
os.makedirs(f"{folder}/checkpoints", exist_ok=True)
open(f"{folder}/checkpoints/{rank}", "w").close()
os._exit(75)
"""


class Cluster:
    """A Slurm of this machine's own, with a folder to work in."""

    # slurmctld looks for jobs near their limit as often as this, from its start on.
    LOOKS = 30.1

    def __init__(self, folder):
        self.folder = folder
        self.began = time.monotonic()
        started = run([str(ROOT / "scripts" / "slurm"), "start", str(folder / "slurm"), "2"], 60)
        if started.returncode != 0:
            pytest.fail(f"scripts/slurm start: {started.stderr}")
        self.env = dict(re.findall(r"^export (\w+)=(.*)$", started.stdout, re.MULTILINE))

    def call(self, *words, **env):
        done = run(list(words), 30, self.folder, self.env | env)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def write(self, name, *words):
        """Write the script of a job of that name."""
        words = [f"--job-name={name}", "-o", name, "--ranks=2", "--nodes=2", *words]
        words.append("--wall-time=0:01:00")
        self.call(sys.executable, "-m", "pgimp", "batch", "blocks.yaml", *words)

    def submit(self, name, **env):
        """Submit it: the job's number."""
        return self.call("sbatch", "--parsable", f"{name}.sh", **env).strip()

    def job(self, number):
        text = self.call("scontrol", "show", "job", "--oneliner", number)
        return dict(word.split("=", 1) for word in text.split() if "=" in word)

    def wait(self, seconds, what, done):
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                logs = "\n".join(path.read_text()[-3000:] for path in self.folder.glob("*.log"))
                pytest.fail(f"no {what} in {seconds} s\n{self.call('squeue')}\n{logs}")
            time.sleep(0.1)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slurm")
    (folder / "blocks.yaml").write_text(CASE)
    stand_in = folder / "stand-in"
    stand_in.write_text(STAND_IN)
    stand_in.chmod(0o755)
    try:
        yield Cluster(folder)
    finally:
        run([str(ROOT / "scripts" / "slurm"), "stop", str(folder / "slurm")], 60)


@pytest.fixture(scope="module")
def uninterrupted(cluster):
    """The same run without any stop, begun already; calling it waits for its end."""
    words = [sys.executable, "-m", "pgimp", "blocks.yaml", *FINE, "--quiet", "-o", "one"]
    process = subprocess.Popen(words, cwd=cluster.folder, env=clean_env())
    try:
        yield lambda: process.wait(timeout=120)
    finally:
        process.kill()
        process.wait()


def test_srun_passes_the_signal_on_and_scancel_ends_for_good(cluster, uninterrupted):
    def says(name, number, text, times):
        log = cluster.folder / f"{name}-{number}.log"
        return lambda: log.exists() and log.read_text().count(text) == times

    def state_is(number, state):
        return lambda: cluster.job(number)["JobState"] == state

    env = {"PGIMP_PYTHON": str(cluster.folder / "stand-in")}
    cluster.write("a", "--launcher=srun")
    cluster.write("b")
    tasks = cluster.submit("a", **env)
    cluster.wait(30, "srun", says("a", tasks, "is up", 2))
    cluster.call("scancel", "--batch", "--signal=USR1", tasks)
    cluster.wait(20, "requeue", state_is(tasks, "PENDING"))

    lost = cluster.submit("b", **env)
    cluster.wait(30, "mpirun", says("b", lost, "is up", 2))
    cluster.call("scancel", lost)
    cluster.wait(20, "end of a cancelled job", state_is(lost, "CANCELLED"))

    cluster.wait(40, "end", state_is(tasks, "COMPLETED"))
    assert says("a", tasks, "is done", 2)()
    assert says("a", tasks, "is up", 2)()  # the second job appended
    assert cluster.job(tasks)["Restarts"] == "1"
    assert cluster.job(lost)["Restarts"] == "0"


def test_limit_checkpoint_requeue_same_bits(cluster, uninterrupted):
    cluster.write("two", *FINE, "--extra=--signal=B:USR1@55")
    # Submitted so that the signal ahead of the limit comes in the middle of the run.
    into = (time.monotonic() - cluster.began) % cluster.LOOKS
    time.sleep((cluster.LOOKS - BEFORE - into) % cluster.LOOKS)
    number = cluster.submit("two", **SHARED)
    cluster.wait(90, "requeue", lambda: cluster.job(number)["Restarts"] == "1")
    # One stop is enough, also on a slow machine.
    cluster.call("scontrol", "update", f"JobId={number}", "TimeLimit=60")
    cluster.wait(120, "end", lambda: cluster.job(number)["JobState"] == "COMPLETED")

    said = (cluster.folder / f"two-{number}.log").read_text()
    starts = json.loads((cluster.folder / "two" / "run.json").read_text())["starts"]
    assert [start["state"] for start in starts] == ["stopped", "done"], said
    assert "SIGUSR1" in said
    assert uninterrupted() == 0
    compared = run([sys.executable, "-m", "pgimp", "compare", "one", "two"], 60, cluster.folder)
    assert compared.returncode == 0, compared.stdout
