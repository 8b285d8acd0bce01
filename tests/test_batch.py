"""Batch scripts: what they say, and what they do with stand-ins for scheduler, launcher and run."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from conftest import clean_env
from test_run import CASE

from pgimp.cli import main

ASKED = ["--ranks", "2", "--wall-time", "0:02:00"]

# Stand-ins: each notes its words in the file `calls`.
NOTE = """#!/usr/bin/env -S python3 -IS
import json, os, signal, sys, time
with open(os.environ["CALLS"], "a") as calls:
    print(json.dumps([os.path.basename(sys.argv[0]), *sys.argv[1:]]), file=calls)
"""
MPIRUN = """#!/bin/bash
[ "$1" != --version ] || { echo "mpirun (Open MPI) 4.1.4"; exit; }
while [ "$1" != -n ]; do shift; done
shift 2
exec "$@"
"""
# Ends as PLAN says: at once with a status, or after SIGUSR1 with a checkpoint, if it gets one.
PYTHON = (
    NOTE
    + """
came = []
signal.signal(signal.SIGUSR1, lambda *_: came.append(1))
plan = os.environ["PLAN"].split()
if "deaf" in plan:
    time.sleep(0.5)
    came.clear()
open(os.environ["CALLS"] + ".up", "w").close()
folder = [word for word in sys.argv if word.startswith("--output=")][0][len("--output="):]
while "waits" in plan and not came:
    time.sleep(0.01)
if "checkpoint" in plan:
    os.makedirs(folder + "/checkpoints", exist_ok=True)
    open(folder + f"/checkpoints/step-{time.time_ns()}.h5", "w").close()
if plan[-1] == "killed":
    signal.signal(signal.SIGUSR1, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGUSR1)
os._exit(int(plan[-1]))  # at the interpreter's own exit SIGUSR1 would kill it
"""
)
ASKS = NOTE + 'sys.exit(int(os.environ.get("REFUSED", "0")))\n'
MODULE = NOTE + 'open(os.environ["CALLS"] + ".up", "w").close()\ntime.sleep(0.3)\n'
SLEEP = "#!/bin/sh\nexec {sleep} 0.05\n"
STAND_INS = {
    "mpirun": MPIRUN,
    "python": PYTHON,
    "scontrol": ASKS,
    "qsub": ASKS,
    "module": MODULE,
    "sleep": SLEEP.format(sleep="/bin/sleep"),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working folder, with a case."""
    folder = tmp_path / "it's $HOME"
    folder.mkdir()
    (folder / "blocks.yaml").write_text(CASE)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def job(folder, tmp_path):
    """``job(*words)`` writes a script; ``job.run(plan)`` is one job of it, on stand-ins."""
    return Jobs(folder, tmp_path)


class Jobs:
    def __init__(self, folder, elsewhere):
        self.folder, self.elsewhere = folder, elsewhere
        self.log = elsewhere / "calls"
        bin = elsewhere / "bin"
        bin.mkdir()
        for name, text in STAND_INS.items():
            (bin / name).write_text(text)
            (bin / name).chmod(0o755)
        self.env = clean_env(
            {
                "PATH": f"{bin}:{os.environ['PATH']}",
                "CALLS": str(self.log),
                "PGIMP_PYTHON": str(bin / "python"),
                "SLURM_JOB_ID": "7",
                "PBS_JOBID": "7.here",
            }
        )

    def __call__(self, *words):
        assert main(["batch", "blocks.yaml", *ASKED, *words]) == 0
        return self

    def run(self, plan, send=None, **env):
        """Run the script, send it a signal as soon as the run is up; its status and messages."""
        up = Path(f"{self.log}.up")
        for path in self.log, up:
            path.unlink(missing_ok=True)
        process = subprocess.Popen(
            ["bash", str(self.folder / "blocks.sh")],
            env=self.env | {"PLAN": plan} | env,
            cwd=self.elsewhere,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            if send is not None:
                end = time.monotonic() + 20
                while not up.exists() and time.monotonic() < end:
                    time.sleep(0.01)
                process.send_signal(send)
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
        return process.returncode, err

    @property
    def calls(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    @property
    def requeued(self):
        return ["scontrol", "requeue", "7"] in self.calls


@pytest.fixture
def refused(folder, capsys):
    """``refused(*words)`` is what pgimp says to a command line that it must refuse."""

    def refused(*words):
        assert main(["batch", *words]) == 2
        assert not list(folder.glob("*.sh"))
        return capsys.readouterr().err

    return refused


def test_slurm_directives(folder, capsys):
    words = ["--nodes", "2", "--account", "me", "--partition", "long", "--module", "mpi/4"]
    words += ["--extra=--mem=0", "--extra", "#SBATCH --signal=B:USR1@900", "--job-name", "b1"]
    words += ["--launcher", "srun --mpi=pmix"]
    assert main(["batch", "blocks.yaml", "--ranks=64", "--wall-time=2:00:00", *words]) == 0
    out, err = capsys.readouterr()
    assert "sbatch b1.sh" in out
    assert "the others stand idle" in err
    text = (folder / "b1.sh").read_text()
    asked = [line.split()[1] for line in text.splitlines() if line.startswith("#SBATCH")]
    assert asked == [
        "--job-name=b1",
        "--ntasks=64",
        "--nodes=2",
        "--ntasks-per-node=32",
        "--time=2:00:00",
        "--signal=B:USR1@300",
        "--requeue",
        "--open-mode=append",
        "--output=%x-%j.log",
        "--account=me",
        "--partition=long",
        "--mem=0",
        "--signal=B:USR1@900",
    ]
    assert "launcher=(srun --mpi=pmix)\n" in text
    assert "module load mpi/4 ||" in text
    assert (folder / "b1.sh").stat().st_mode & 0o100


@pytest.mark.parametrize(
    "nodes, select",
    [
        ([], "select=7:ncpus=1:mpiprocs=1"),
        (["--nodes=2"], "select=1:ncpus=4:mpiprocs=4+1:ncpus=3:mpiprocs=3"),
        (["--nodes=7"], "select=7:ncpus=1:mpiprocs=1"),
    ],
)
def test_pbs_directives(folder, nodes, select):
    words = ["--ranks=7", "--wall-time=1-00:00:00", "--scheduler=pbs", "--partition=long", *nodes]
    assert main(["batch", "blocks.yaml", *words]) == 0
    lines = (folder / "blocks.sh").read_text().splitlines()
    for line in (f"#PBS -l {select}", "#PBS -l walltime=24:00:00", "#PBS -q long", "#PBS -j oe"):
        assert line in lines
    assert ("#PBS -l place=scatter" in lines) == bool(nodes)


def test_wrong_command_lines(refused, folder):
    (folder / "wrong.yaml").write_text(CASE.replace("young: 100.0", "young: -1.0"))
    assert "wrong.yaml:9" in refused("wrong.yaml", *ASKED)
    assert "cannot read the case none.yaml" in refused("none.yaml", *ASKED)
    assert "time.end" in refused("blocks.yaml", *ASKED, "--set", "time.end=soon")
    refused(
        "blocks.yaml", *ASKED, "--set", "bodies.left.region={box: {min: [90, 90], max: [91, 91]}}"
    )
    for words in (
        ["--ranks=0"],
        ["--ranks=-1"],
        ["--ranks=99999999999"],
        ["--ranks=2", "--nodes=3"],
        ["--wall-time=90"],
        ["--wall-time=0:00:00"],
        ["--account=a b"],
        ["--partition=x\n#SBATCH --uid=0"],
        ["--module=$(id)"],
        ["--job-name=../x"],
        ["--extra=--mem=0\nrm -rf /"],
        ["--extra="],
        ["--launcher=rm -rf"],
        ["--launcher=mpirun 'x"],
        ["--set=title=a\nb"],
        ["-o", "a\nb"],
        ["-o", "a\x1bb"],
        ["--script", "a\nb.sh"],
        ["--script", "no/such/folder.sh"],
        ["--script=-", "--scheduler=pbs"],
        ["--launcher=srun", "--scheduler=pbs"],
        ["--scheduler=lsf"],
    ):
        said = refused("blocks.yaml", *ASKED, *words)
        assert said.startswith("pgimp: "), words
        assert "Traceback" not in said


def test_script_is_not_replaced_by_accident(folder, capsys):
    script = folder / "blocks.sh"
    assert main(["batch", "blocks.yaml", *ASKED]) == 0
    assert main(["batch", "blocks.yaml", *ASKED]) == 0  # the same
    script.write_text("mine")
    assert main(["batch", "blocks.yaml", *ASKED]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert script.read_text() == "mine"
    assert main(["batch", "blocks.yaml", *ASKED, "--overwrite"]) == 0
    assert script.read_text().startswith("#!/bin/bash\n#SBATCH")
    capsys.readouterr()
    assert main(["batch", "blocks.yaml", *ASKED, "--script", "-"]) == 0
    assert capsys.readouterr().out.startswith("#!/bin/bash\n#SBATCH")


def test_every_word_arrives_as_it_was(job, folder):
    names = {"case": "a 'b\" $(touch x) `id` \\ é.yaml", "output": "-o ut; #"}
    (folder / names["case"]).write_text(CASE)
    change = 'title=it\'s "$HOME" `id`'
    words = ["--job-name=blocks", f"--output={names['output']}", "--set", change]
    words += ["--launcher", "mpirun --mca 'a b' c"]
    assert main(["batch", names["case"], *ASKED, *words]) == 0
    assert job.run("0")[0] == 0
    options = [f"--output={names['output']}", "--resume", f"--set={change}"]
    assert job.calls == [["python", "-m", "pgimp", names["case"], *options]]
    assert not (folder / "x").exists()


@pytest.mark.parametrize("status", [0, 1, 2, 130, 137, 138, 143])
def test_any_other_status_ends_it(job, status):
    assert job().run(f"checkpoint {status}")[0] == status
    assert not job.requeued


def test_stopped_run_is_requeued(job):
    status, said = job().run("waits checkpoint 75", signal.SIGUSR1)
    assert status == 0 and job.requeued
    assert "requeued" in said
    assert job.run("checkpoint 75")[0] == 0 and job.requeued  # it knew the limit by itself


def test_signal_that_a_launcher_loses_is_repeated(job):
    status, _ = job("--module=mpi").run("deaf waits checkpoint 75", signal.SIGUSR1)
    assert status == 0 and job.requeued
    assert job.calls[0] == ["module", "load", "mpi"]


def test_signal_before_the_run_can_take_it(job):
    status, _ = job().run("waits killed", signal.SIGUSR1)
    assert status == 0 and job.requeued


def test_no_progress_is_no_endless_loop(job, folder):
    job()
    assert job.run("checkpoint 75")[0] == 0 and job.requeued
    assert job.run("75")[0] == 0 and job.requeued  # once may happen
    assert job.run("checkpoint 75")[0] == 0 and job.requeued
    assert job.run("75")[0] == 0 and job.requeued
    status, said = job.run("75")
    assert status == 1 and not job.requeued
    assert "no progress" in said
    assert job.run("75")[0] == 0 and job.requeued  # submitted again by someone
    assert job.run("0")[0] == 0
    assert not list((folder / "blocks.out").glob(".batch*"))


def test_cancelled_job_is_not_requeued(job):
    status, said = job().run("waits checkpoint 75", signal.SIGTERM)
    assert status == 143 and not job.requeued
    assert "cancelled" in said
    assert job.run("waits 1", signal.SIGTERM)[0] == 1
    assert not job.requeued


def test_refused_requeue(job):
    status, said = job().run("checkpoint 75", REFUSED="1")
    assert status == 75
    assert "submit this script again" in said


def test_not_in_a_job_or_no_python(job):
    status, said = job().run("0", SLURM_JOB_ID="")
    assert status == 1 and "submit this script with sbatch" in said
    status, said = job.run("0", PGIMP_PYTHON="/no/python")
    assert status == 1 and "there is no /no/python" in said


def test_pbs_job_submits_itself_again_before_its_limit(job, folder):
    job("--scheduler=pbs", "--wall-time=0:00:02")
    began = time.monotonic()
    status, _ = job.run("waits checkpoint 75")
    assert 0.5 < time.monotonic() - began < 10
    again = ["qsub", "-v", f"PGIMP_PYTHON={job.env['PGIMP_PYTHON']}", str(folder / "blocks.sh")]
    assert status == 75 and job.calls[-1] == again
    status, said = job.run("waits killed", REFUSED="1")  # the launcher took longer than the limit
    assert status == 75 and "login node" in said
    assert job.run("waits checkpoint 75", signal.SIGUSR1)[0] == 75 and job.calls[-1] == again
    status, _ = job.run("waits checkpoint 75", signal.SIGTERM)
    assert status == 143 and job.calls[-1] != again
    assert job.run("checkpoint 0")[0] == 0 and job.calls[-1] != again
