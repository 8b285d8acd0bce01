"""Batch scripts: what they say, and what they do with stand-ins for scheduler, launcher and run."""

import os
import signal
import time

import pytest
from batch_jobs import ASKED, Jobs
from two_blocks import CASE

from pgimp.cli import main

pytestmark = pytest.mark.slow(180)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working folder, with a case."""
    folder = tmp_path / "it's $HOME"
    folder.mkdir()
    (folder / "blocks.yaml").write_text(CASE)
    monkeypatch.chdir(folder)
    monkeypatch.setattr("pgimp.commands.batch.imported", [])  # other tests may have imported files
    return folder


@pytest.fixture
def job(folder, tmp_path):
    """``job(*words)`` writes a script; ``job.run(plan)`` is one job of it, on stand-ins."""
    return Jobs(folder, tmp_path)


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


def test_scripts_are_not_written_over_pipes(folder, capsys):
    """A pipe would be replaced, and so would a device."""
    os.mkfifo(folder / "b.sh")
    for more in ([], ["--overwrite"]):
        assert main(["batch", "blocks.yaml", *ASKED, "--script=b.sh", *more]) == 2
        assert "cannot write the script b.sh: it is no regular file" in capsys.readouterr().err
    assert (folder / "b.sh").is_fifo()


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
    status, _ = job().run("deaf waits checkpoint 75", signal.SIGUSR1)
    assert status == 0 and job.requeued


def test_signal_while_a_module_is_loaded(job):
    status, _ = job("--module=mpi").run("waits checkpoint 75", signal.SIGUSR1)
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


def test_a_killed_rank_leaves_a_line(job, folder):
    (folder / "blocks.out").mkdir()
    (folder / "blocks.out" / "log.txt").write_text("so far\n")
    status, said = job().run("137")  # as mpirun ends, of which a rank got a SIGKILL
    line = "batch: a rank was ended by signal 9, as happens when memory runs out"
    assert status == 137 and line in said
    assert (folder / "blocks.out" / "log.txt").read_text() == f"so far\n{line}\n"
    assert "ended with status 1" in job.run("1")[1]
    assert job.run("0") == (0, "")


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
    assert time.monotonic() - began > 0.5  # else it would wait on
    again = ["qsub", "-v", f"PGIMP_PYTHON={job.env['PGIMP_PYTHON']}", str(folder / "blocks.sh")]
    assert status == 75 and job.calls[-1] == again
    status, said = job.run("waits killed", REFUSED="1")  # the launcher took longer than the limit
    assert status == 75 and "login node" in said
    assert job.run("waits checkpoint 75", signal.SIGUSR1)[0] == 75 and job.calls[-1] == again
    status, _ = job.run("waits checkpoint 75", signal.SIGTERM)
    assert status == 143 and job.calls[-1] != again
    assert job.run("checkpoint 0")[0] == 0 and job.calls[-1] != again
